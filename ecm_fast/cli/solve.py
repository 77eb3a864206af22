"""``ecm-fast solve``: one equilibrium."""

import argparse
import math
from collections.abc import Mapping
from typing import Any

from ._arguments import add_model, add_path, discretization, finite_number, mechanism, tension
from ._command import DONE, NOT_CONVERGED, Answer, Command, saved

__all__ = ["COMMAND"]


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--tendons", nargs=2, type=tension, required=True, metavar=("L", "R"), help="forces, left and right [N]"
    )
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

    model = FiniteElementModel(mechanism(args), **discretization(args))
    eq = model.solve(args.tendons, args.wrench, path=args.path)
    answer = {
        **{name: getattr(eq, name) for name in ("x", "z", "theta", "converged", "stable", "iterations")},
        **{name: getattr(eq, name) for name in ("jacobian", "compliance", "message", "load_factor")},
        "status": eq.status.name.lower(),
    }
    notes = () if eq.stable else (eq.message,)
    text = _text(answer) if eq.converged else ""
    return Answer(answer, text, (*notes, *saved(args, answer)), DONE if eq.converged else NOT_CONVERGED)


def _text(answer: Mapping[str, Any]) -> str:
    theta = answer["theta"]
    lines = [
        f"x     = {answer['x']:.9g} m",
        f"z     = {answer['z']:.9g} m",
        f"theta = {theta:.9g} rad ({math.degrees(theta):.6g} deg)",
        f"{answer['message']} ({answer['iterations']} Newton steps)",
        "d(x, z, theta)/d(left, right tendon force) [m/N, m/N, rad/N]",
    ]
    return "\n".join(lines + [" ".join(f"{entry:14.6g}" for entry in row) for row in answer["jacobian"]])


COMMAND = Command("one equilibrium of the neck under tendon forces and a dead wrench", _add_arguments, _run)
