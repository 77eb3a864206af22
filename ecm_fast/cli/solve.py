"""``ecm-fast solve``: one equilibrium."""

import argparse
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from .frame.arguments import add_model, add_path, discretization, finite_number, mechanism, tension
from .frame.command import DONE, NOT_CONVERGED, Answer, Command, saved

if TYPE_CHECKING:
    from ..mechanism.mechanism import Mechanism

__all__ = ["COMMAND"]


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--tendons", nargs=2, type=tension, metavar=("L", "R"), help="forces, left and right [N]")
    parser.add_argument(
        "--tendon", action="append", type=_named, default=[], metavar="NAME=FORCE",
        help="force of a [[tendon]] of the mechanism [N]; what is not given is 0; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--length", action="append", type=_named, default=[], metavar="NAME=LENGTH",
        help="free length of a [[tendon]] [m] instead of its force; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--wrench",
        nargs=3,
        type=finite_number,
        default=(0.0, 0.0, 0.0),
        metavar=("FX", "FZ", "TAU"),
        help="dead wrench at Q, the middle of the head plate [N, N, N m]; default none",
    )
    add_model(parser)
    add_path(parser)


def _run(args: argparse.Namespace) -> Answer:
    from ..models.finite_element import FiniteElementModel

    neck = mechanism(args)
    model = FiniteElementModel(neck, **discretization(args))
    eq = model.solve(_forces(args, neck), args.wrench, lengths=dict(args.length) or None, path=args.path)
    answer = {
        **{name: getattr(eq, name) for name in ("x", "z", "theta", "converged", "stable", "iterations")},
        **{name: getattr(eq, name) for name in ("jacobian", "compliance", "message", "load_factor")},
        "status": eq.status.name.lower(),
    }
    if not neck.has_pair or neck.markers:
        forces, lengths = eq.forces.tolist(), eq.lengths.tolist()
        answer["tendons"] = {
            name: {"force": force, "length": length}
            for name, force, length in zip(neck.tendon_names, forces, lengths, strict=True)
        }
        poses = {name: pose.tolist() for name, pose in eq.markers.items()}
        answer["markers"] = {name: dict(zip(("x", "z", "theta"), pose, strict=True)) for name, pose in poses.items()}
    notes = () if eq.stable else (eq.message,)
    text = _text(answer) if eq.converged else ""
    return Answer(answer, text, (*notes, *saved(args, answer)), DONE if eq.converged else NOT_CONVERGED)


def _named(text: str) -> tuple[str, float]:
    name, equals, value = text.partition("=")
    if not equals or not name:
        raise argparse.ArgumentTypeError(f"{text!r}: allowed is NAME=NUMBER")
    return name, tension(value)


def _forces(args: argparse.Namespace, neck: "Mechanism") -> Any:
    """Return tendon forces as the model takes them; the pair's must be given."""
    if neck.has_pair:
        if args.tendon or args.length:
            raise InputError("--tendon, --length: the mechanism has no [[tendon]]; its pair is given by --tendons L R")
        if args.tendons is None:
            raise InputError("--tendons L R is missing: the forces of the left and the right tendon [N]")
        return args.tendons
    if args.tendons is not None:
        names = " ".join(f"--tendon {name}=FORCE" for name in neck.tendon_names)
        raise InputError(f"--tendons L R: the mechanism has tendons of its own; say {names or 'nothing: it has none'}")
    return dict(args.tendon)


def _text(answer: Mapping[str, Any]) -> str:
    theta = answer["theta"]
    lines = [
        f"x     = {answer['x']:.9g} m",
        f"z     = {answer['z']:.9g} m",
        f"theta = {theta:.9g} rad ({math.degrees(theta):.6g} deg)",
        f"{answer['message']} ({answer['iterations']} Newton steps)",
    ]
    for name, state in answer.get("tendons", {}).items():
        lines.append(f"tendon {name}: {state['force']:.6g} N, length {state['length']:.9g} m")
    for name, pose in answer.get("markers", {}).items():
        turned = math.degrees(pose["theta"])
        lines.append(f"marker {name}: x {pose['x']:.9g} m, z {pose['z']:.9g} m, theta {turned:.6g} deg")
    names = ", ".join(answer.get("tendons", ("left", "right")))
    lines.append(f"d(x, z, theta)/d({names} tendon force) [m/N, m/N, rad/N]")
    return "\n".join(lines + [" ".join(f"{entry:14.6g}" for entry in row) for row in answer["jacobian"]])


COMMAND = Command("one equilibrium of the neck under tendon forces and a dead wrench", _add_arguments, _run)
