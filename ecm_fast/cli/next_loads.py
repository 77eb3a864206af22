"""``ecm-fast next``: the loads to measure next to separate look-alikes."""

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError, why
from ..files import check_form, read_whole
from .frame.arguments import EXAMPLES, count, finite_number, mechanism_of, numbers_by_name
from .frame.command import Answer, Command, saved

if TYPE_CHECKING:
    from ..diagnosis.design.next_loads import NextLoads

__all__ = ["COMMAND"]

_MODEL = {"names": [str], "in_set": bool, "refused": str, "behind": float}
_RESULT = {
    "inputs": {
        "mechanism": (str, None),
        "data": [str],
        "priors": {"*": [float]},
        "noise?": {"*": float},
        "columns?": ({"columns": {"*": str}}, None),
    },
    "models": [_MODEL],
    "noise": {"sigma": [(float, None)], "force": (float, None)},
    "verdict?": str,
    "gap?": ({"after?": {"rms_sigma": (float, None), "interval": [(float, None)]}}, None),
    "missing?": [str],
    "transfer?": [{"rivals?": [{"name": str, "carries_over": bool}]}],
}
"""Form of the result of a diagnosis as far as it is read, see `check_form`."""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("result", metavar="RESULT", help="DIR or DIR/diagnose.json, as diagnose --out DIR writes it")
    parser.add_argument("--minutes", type=finite_number, default=20.0, metavar="M", help="time there is; default 20")
    parser.add_argument("--repeats", type=count, default=3, metavar="N", help="readings of each load; default 3")
    parser.add_argument(
        "--add-ons",
        nargs="+",
        metavar="NAME",
        help="what can be mounted: nothing (the tendons alone), wrench, mass, tilt, tilt-back; default: all",
    )
    parser.add_argument(
        "--at-most",
        action="append",
        default=[],
        nargs=2,
        metavar=("COLUMN", "LIMIT"),
        help=f"the most that can be applied of a load ({EXAMPLES['--at-most']}: no push along the neck); may be given "
        "several times",
    )


def _run(args: argparse.Namespace) -> Answer:
    from ..data.column_map import ColumnMap
    from ..data.measurements import read_measurements
    from ..diagnosis.design.load_pool import ADD_ONS
    from ..diagnosis.design.next_loads import Pool, in_question
    from ..studies.diagnosis import Study

    result = _read(args.result)
    inputs = result["inputs"]
    neck = mechanism_of(inputs["mechanism"])
    told = None if inputs.get("columns") is None else ColumnMap.from_dict(inputs["columns"])
    data = [read_measurements(path, told).with_noise(inputs.get("noise", {})) for path in inputs["data"]]
    priors = {name: (float(value), float(std)) for name, (value, std) in inputs["priors"].items()}
    pool = Pool.from_add_ons(args.add_ons or ADD_ONS).within(numbers_by_name("--at-most", args.at_most))
    found = Study(neck, data, priors=priors).next_loads(
        result, minutes=args.minutes, repeats=args.repeats, pool=pool, check_single=True
    )
    sets, alone = in_question(result["models"], result.get("transfer", ()))
    if found is None:
        why = f"no other explanation came near {' with '.join(sets[0])}" if sets else "no effect was found"
        answer: dict[str, Any] = {"set": [" with ".join(names) for names in sets], "next": []}
        return Answer(answer, f"nothing to tell apart: {why}\nnext: {_step(result)}", saved(args, answer))
    step = "measure these, and diagnose old and new files together" if found.suggestions else _step(result)
    return Answer(found.to_json_dict(), f"{_text(found, alone)}\nnext: {step}", saved(args, found.to_json_dict()))


def _step(result: dict[str, Any]) -> str:
    """Return what to do with a diagnosis that no further load would help."""
    from ..diagnosis.answer.next_step import next_step

    verdict, gap = result.get("verdict", "nothing_found"), result.get("gap") or {}
    verdict = "named" if verdict == "family" else verdict  # no load tells more
    return next_step(verdict, gap, result.get("missing", ()))


def _read(path: str) -> dict[str, Any]:
    place = Path(path) / "diagnose.json" if Path(path).is_dir() else Path(path)
    try:
        result: dict[str, Any] = json.loads(read_whole(place))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{place}: cannot be read as the result of a diagnosis ({why(error)}); "
                         f"ecm-fast diagnose DATA --out DIR writes DIR/diagnose.json") from None  # fmt: skip
    try:
        check_form(result, _RESULT)
        for name, prior in result["inputs"]["priors"].items():
            _count(f"inputs.priors.{name}", prior, 2)
        _count("noise.sigma", result["noise"]["sigma"], 3)
        if not result["inputs"]["data"]:
            raise InputError("inputs.data is empty")
    except InputError as error:
        raise InputError(f"{path}: {error}; allowed is diagnose.json as diagnose --out DIR writes it") from None
    return result


def _count(name: str, values: list[Any], count: int) -> None:
    if len(values) != count:
        raise InputError(f"{name} has {len(values)} numbers in the place of {count}")


def _text(found: "NextLoads", alone: bool) -> str:
    first, *rest = found.names
    aim = f"to check {first} against its nearest rivals: {'; '.join(rest)}"
    lines = [aim if alone else f"to tell apart: {'; '.join(found.names)}",
             *found.remarks,
             f"{'of those that loads here can tell, ' * bool(found.twins)}now at least {found.worst_before:.1f} sigma "
             "apart"]  # fmt: skip
    for i, entry in enumerate(found.suggestions, start=1):
        loads = ", ".join(f"{name} {value:g}" for name, value in entry.loads.items())
        mount = "" if entry.mount == "nothing" else f", mount: {entry.mount}"
        lines.append(f"{i}. {entry.repeats} x ({loads}){mount}; {entry.minutes:.1f} min; "
                     f"then {entry.promised_sigma:.1f} sigma")  # fmt: skip
    if not found.suggestions:
        lines.append(found.why_none)
    lines += [f"the best load alone with {_mounted(name)}: {sigma:.1f} sigma" for name, sigma in found.alone.items()]
    return "\n".join(lines)


def _mounted(name: str) -> str:
    return "nothing mounted" if name == "nothing" else f"mount {name}"


COMMAND = Command("which loads to measure next so that look-alikes come apart", _add_arguments, _run)
