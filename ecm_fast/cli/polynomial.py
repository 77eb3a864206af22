"""``ecm-fast polynomial fit`` and ``polynomial eval``: the paper's polynomial from pose to wrench."""

import argparse
import warnings
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from .frame.arguments import (
    add_columns,
    add_model,
    add_path,
    count,
    discretization,
    finite_number,
    measurements,
    mechanism,
)
from .frame.command import IN_OUT, Answer, Command, folder, saved

if TYPE_CHECKING:
    from ..models.polynomial.model import PolynomialModel

__all__ = ["EVAL", "FIT"]

_POSES = 1000  # training poses, as many as in the paper's Section 3


def _add_fit_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("data", nargs="?", metavar="DATA", help="measurements with loads and whole poses; default none")
    parser.add_argument("--degree", type=count, default=3, metavar="D", help="1 to 6; default 3")
    parser.add_argument(
        "--conservative", action="store_true", help="as the gradient of one energy: symmetric stiffness"
    )
    parser.add_argument(
        "--poses",
        type=count,
        metavar="N",
        help=f"poses of the model under random dead wrenches; default {_POSES}, with DATA none",
    )
    parser.add_argument("--seed", type=count, default=0, metavar="S", help="for these wrenches; default 0")
    add_model(parser)
    add_path(parser)
    add_columns(parser)


def _fit(args: argparse.Namespace) -> Answer:
    from ..models.finite_element import FiniteElementModel
    from ..models.polynomial.model import PolynomialModel
    from ..models.polynomial.training import TrainingSet, training_poses, training_rows

    model = FiniteElementModel(mechanism(args), **discretization(args))
    known = TrainingSet.empty()
    if args.data is not None:
        known += training_rows(model, measurements(args.data, args), path=args.path)
    poses = args.poses if args.poses is not None or args.data is not None else _POSES
    if poses is not None:
        known += training_poses(model, poses, args.seed, path=args.path)
    poly = PolynomialModel.fit(known.poses, known.wrenches, args.degree, args.conservative)
    path = poly.to_json(folder(args.out or "out") / "polynomial.json")
    answer = {
        "model": path,
        "degree": poly.degree,
        "conservative": args.conservative,
        "coefficients": poly.coefficient_count,
        "rows": poly.rows,
        "dropped": known.dropped,
        "rms": _by_column(poly.outputs, poly.rms),
        "condition": poly.condition,
        "range": _by_column(poly.inputs, zip(poly.lower, poly.upper, strict=True)),
    }
    dropped = (f"{known.dropped} of {len(known) + known.dropped} poses cannot be used",) if known.dropped else ()
    return Answer(answer, _fit_text(answer), (*dropped, f"wrote {path}"))


def _fit_text(answer: Mapping[str, Any]) -> str:
    lines = [
        f"degree {answer['degree']}, {answer['coefficients']} coefficients from {answer['rows']} poses, "
        f"condition number {answer['condition']:.3g}",
        f"rms of what the fit leaves: {_shown(answer['rms'])}",
    ]
    return "\n".join(
        lines + [f"range of {name}: {low:.6g} to {high:.6g}" for name, (low, high) in answer["range"].items()]
    )


def _add_eval_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL", help="what 'polynomial fit' wrote (.json)")
    parser.add_argument("data", nargs="?", metavar="DATA", help="measurements whose poses are evaluated")
    parser.add_argument(
        "--pose", nargs=3, type=finite_number, metavar=("X", "Z", "THETA"), help="one pose instead [m, m, rad]"
    )
    parser.add_argument("--mechanism", metavar="F", help="compare with the wrench of DATA's loads on this mechanism")
    add_path(parser)
    add_columns(parser)


def _eval(args: argparse.Namespace) -> Answer:
    from ..models.polynomial.model import PolynomialModel

    if (args.data is None) == (args.pose is None):
        raise InputError("allowed is either DATA or --pose X Z THETA; see ecm-fast polynomial eval --help")
    poly = PolynomialModel.from_json(args.model)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        answer, text, notes = _eval_data(args, poly) if args.pose is None else _eval_pose(args, poly)
    return Answer(answer, text, (*dict.fromkeys(str(entry.message) for entry in caught), *notes))


def _eval_pose(args: argparse.Namespace, poly: "PolynomialModel") -> tuple[dict[str, Any], str, tuple[str, ...]]:
    wrench, stiffness = poly.wrench(args.pose), poly.stiffness(args.pose)
    named = _by_column(poly.outputs, wrench)
    answer = {**named, "stiffness": stiffness, "in_range": not poly.outside(args.pose).any()}
    lines = [_shown(named), "d(fx, fz, tau)/d(x, z, theta), rows [N/m, N/m, N/rad], the last [N, N, N m/rad]"]
    lines += [" ".join(f"{entry:14.6g}" for entry in row) for row in stiffness]
    return answer, "\n".join(lines), saved(args, answer)


def _eval_data(args: argparse.Namespace, poly: "PolynomialModel") -> tuple[dict[str, Any], str, tuple[str, ...]]:
    from ..files import csv_text, write_whole
    from ..models.finite_element import FiniteElementModel
    from ..models.instruments.rest_pose import absolute
    from ..models.polynomial.training import WrenchErrors, measured_wrenches

    data = measurements(args.data, args)
    if data.zeroed and args.mechanism is None:
        raise InputError(f"{args.data}: poses that are zeroed at rest need --mechanism, whose rest pose is added")
    data = data if args.mechanism is None else absolute(mechanism(args), data)
    columns = _by_column((*poly.inputs, *poly.outputs), [*data.pose.T, *poly.wrench(data.pose).T])
    rms = None
    if args.mechanism is not None:
        observed = measured_wrenches(FiniteElementModel(mechanism(args)), data, path=args.path)
        for name, values in _by_column(poly.outputs, observed.T).items():
            columns[name.replace("_", "_measured_")] = values
        rms = _by_column(poly.outputs, WrenchErrors(observed, poly.wrench(data.pose)).rms)
    path = write_whole(folder(args.out or "out") / "wrenches.csv", csv_text(columns))
    poses = int(data.measured.all(axis=1).sum())
    answer = {"rows": poses, "outside": int(poly.outside(data.pose).any(axis=1).sum()), "rms": rms, "csv": path}
    text = f"{poses} of {data.n} rows have a whole pose, {answer['outside']} of them outside the range"
    if rms is not None:
        text += f"\nrms of predicted less measured: {_shown(rms)}"
    return answer, text, (f"wrote {path}",)


def _by_column(names: Iterable[str], values: Iterable[Any]) -> dict[str, Any]:
    """Return values by the columns of a measurement file, which have the unit in their names."""
    from ..data.columns import COLUMNS

    return {COLUMNS[name].names[0]: value for name, value in zip(names, values, strict=True)}


def _shown(values: Mapping[str, float]) -> str:
    pairs = ((name.split("_"), value) for name, value in values.items())
    return ", ".join(f"{name} {value:.6g} {unit.replace('Nm', 'N m')}" for (name, unit), value in pairs)


FIT = Command(
    "fit the polynomial from pose to wrench to poses of the model or to measurements", _add_fit_arguments, _fit, IN_OUT
)
EVAL = Command(
    "evaluate a fitted polynomial at one pose or at those of a data file", _add_eval_arguments, _eval, IN_OUT
)
