"""``ecm-fast identify``: parameters fitted to measurements."""

import argparse
from typing import TYPE_CHECKING, Any

from .frame.arguments import (
    add_model,
    add_noise,
    discretization,
    finite_number,
    measurements,
    mechanism,
    priors_by_name,
)
from .frame.command import DONE, IN_OUT, NOT_CONVERGED, Answer, Command, folder, outputs

if TYPE_CHECKING:
    from ..identification.result import Identification

__all__ = ["COMMAND"]

_SHOWN = 5  # lines that fit a screen


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("data", nargs="+", metavar="DATA", help="measurements with poses: .csv, .xlsx, .parquet, .mat")
    parser.add_argument(
        "--fit", nargs="+", required=True, metavar="NAME", help="parameters, such as EA GA EI; others keep their values"
    )
    parser.add_argument("--channels", nargs="+", metavar="C", help="which of x, z, theta count; default: all")
    parser.add_argument(
        "--prior",
        action="append",
        default=[],
        nargs=3,
        metavar=("NAME", "VALUE", "STD"),
        help="what another test found, with its standard deviation; may be given for several parameters",
    )
    parser.add_argument("--loss", default="linear", metavar="L", help="linear, huber or soft_l1; default linear")
    parser.add_argument("--force-sigma", type=finite_number, metavar="N", help="noise of the force readings [N]")
    add_noise(parser)
    add_model(parser)


def _run(args: argparse.Namespace) -> Answer:
    from ..identification.identify import identify

    neck, data = mechanism(args), [measurements(path, args) for path in args.data]
    chosen: dict[str, Any] = {**discretization(args)}
    if args.channels is not None:
        chosen["channels"] = args.channels
    path = folder(args.out or "out") / "identified.toml"
    outputs(path)
    fit = identify(
        neck,
        data,
        args.fit,
        priors=priors_by_name(args.prior),
        loss=args.loss,
        force_sigma=args.force_sigma,
        **chosen,
    )
    fit.mechanism.to_toml(path)
    shown = [f"left out: {where}: {reason}" for where, reason in fit.left_out[:_SHOWN]]
    notes = (*(f"warning: {text}" for text in fit.warnings), *shown, f"wrote {path}")
    follows = f"next: ecm-fast predict NEW --mechanism {path} on measurements that were not fitted"
    if fit.warnings:
        follows = "next: see to the warnings; ecm-fast diagnose says what the model is missing"
    return Answer(_answer(fit, str(path)), f"{_text(fit)}\n{follows}", notes, DONE if fit.settled else NOT_CONVERGED)


def _answer(fit: "Identification", path: str) -> dict[str, Any]:
    return {
        "parameters": {
            name: {"value": found.value, "std": found.std, "lower": found.lower, "upper": found.upper}
            for name, found in fit.parameters.items()
        },
        "rms": fit.rms,
        "warnings": fit.warnings,
        "correlation": fit.correlation,
        "rows": fit.rows,
        "left_out": [{"row": where, "reason": reason} for where, reason in fit.left_out],
        "noise": fit.noise,
        "chi2": fit.chi2,
        "degrees_of_freedom": fit.dof,
        "level": fit.level,
        "solves": fit.solves,
        "mechanism": path,
    }


def _text(fit: "Identification") -> str:
    lines = [f"{fit.counted}; {fit.level:.0%} intervals"]
    lines += [f"{name} {found}" for name, found in fit.parameters.items()]
    rms = [(name.rpartition("_")[::2], value) for name, value in fit.rms.items() if value is not None]
    lines.append(f"rms of measured less predicted: {', '.join(f'{n} {value:.6g} {unit}' for (n, unit), value in rms)}")
    lines.append(f"noise: {', '.join(f'{name} {origin}' for name, origin in fit.noise.items())}")
    return "\n".join(lines)


COMMAND = Command("find the parameters at which the model meets measurements best", _add_arguments, _run, IN_OUT)
