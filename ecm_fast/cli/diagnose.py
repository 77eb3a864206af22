"""``ecm-fast diagnose`` and ``ecm-fast plan``: the missing effect, and the effects that given loads can show."""

import argparse
from functools import partial
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from .frame.arguments import (
    EXAMPLES,
    add_noise,
    column_map,
    finite_number,
    measurements,
    mechanism,
    numbers_by_name,
    priors_by_name,
)
from .frame.command import DONE, Answer, Command, folder, outputs, saved
from .frame.terminal import Waiting

if TYPE_CHECKING:
    from ..diagnosis import Diagnosis, Plan
    from ..mechanism.mechanism import Mechanism

__all__ = ["DIAGNOSE", "PLAN", "VERDICT_CODES"]

VERDICT_CODES = {"named": 10, "family": 11, "outside_catalogue": 12, "nothing_found": 13, "data_gap": 20}
"""Exit codes of --exit-code; those below 10 mean that a command failed, as of every command."""
_CODES = ", ".join(f"{code} {name}" for name, code in VERDICT_CODES.items())
_SHOWN = 8  # lines that fit a screen


def _add_common(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("data", nargs="+", metavar="DATA", help="measurements: .csv, .xlsx, .parquet or .mat")
    parser.add_argument("--mechanism", metavar="F", help="mechanism file (TOML); default: the preset 'slender'")
    parser.add_argument(
        "--candidates",
        nargs="+",
        metavar="NAME",
        help="the only names that the answer may give, say one to try it alone; default: the whole catalogue",
    )
    parser.add_argument(
        "--uncertain",
        action="append",
        default=[],
        metavar="NAME[=STD]",
        help="a parameter, an effect or camera_frame whose value in the mechanism file holds only within STD, or "
        "without it not at all: it is calibrated along and never named; may be given several times",
    )
    parser.add_argument(
        "--prior",
        action="append",
        default=[],
        nargs=3,
        metavar=("NAME", "VALUE", "STD"),
        help="what a material test found of EA, GA, EI or of what is declared uncertain, with its standard "
        f"deviation: it takes the place of the mechanism file's value ({EXAMPLES['--prior']}); may be given several "
        "times",
    )
    add_noise(parser)
    parser.add_argument("--force-sigma", type=finite_number, metavar="N", help="noise of the force readings [N]")
    parser.add_argument(
        "--alpha",
        type=finite_number,
        default=0.01,
        metavar="A",
        help="chance that data which lack nothing raise an alarm; default 0.01, smaller: fewer alarms, less is found",
    )


def _add_diagnose(parser: argparse.ArgumentParser) -> None:
    _add_common(parser)
    parser.add_argument(
        "--test",
        action="append",
        default=[],
        metavar="DATA2",
        help="measurements that are never fitted: the answer says whether what was found carries over to them; may "
        "be given several times",
    )
    parser.add_argument("--report", metavar="PAGE", help="write the page here; with --out it is DIR/diagnosis.html")
    parser.add_argument("--exit-code", action="store_true", help=f"end with the verdict's code: {_CODES}")


def _common(args: argparse.Namespace) -> dict[str, Any]:
    return {
        "data": [measurements(path, args) for path in args.data],
        "candidates": args.candidates,
        "uncertain": _uncertain(args.uncertain),
        "priors": priors_by_name(args.prior),
        "force_sigma": args.force_sigma,
        "alpha": args.alpha,
    }


def _uncertain(given: list[str]) -> dict[str, float | None]:
    found: dict[str, float | None] = {}
    for text in given:
        name, equals, number = text.strip().partition("=")
        try:
            found[name] = finite_number(number) if equals else None
        except argparse.ArgumentTypeError as error:
            raise InputError(f"argument --uncertain {name}: {error}") from None
    return found


def _diagnose(args: argparse.Namespace) -> Answer:
    waiting = Waiting()
    try:
        return _diagnosed(args, waiting)
    finally:
        waiting.end()


def _diagnosed(args: argparse.Namespace, waiting: Waiting) -> Answer:
    from ..studies.diagnosis import Study

    study = Study(mechanism(args), **_common(args), test=[measurements(path, args) for path in args.test],
                  progress=waiting)  # fmt: skip
    path, page = folder(args.out or "out") / "mechanism.toml", _page_path(args)
    outputs(path, *() if page is None else (page,))
    found = study.diagnose()
    found.mechanism.to_toml(path, _origin(found, args))
    further = study.next_loads(found)
    answer = {
        **found.to_json_dict(),
        "mechanism": str(path),
        "report": None if page is None else str(page),
        "next": [entry.to_json_dict() for entry in further.suggestions] if further else [],
        "inputs": _inputs(args),
    }
    warnings = [f"warning: {text}" for text in (*found.noticed, *found.warnings, *found.alarms)]
    notes = (*warnings, f"wrote {path}", *saved(args, answer))
    code = VERDICT_CODES[found.verdict] if args.exit_code else DONE

    def draw(page: Path) -> tuple[str, ...]:
        try:
            return (f"wrote {study.page(found, page, further)}",)
        finally:
            waiting.end()

    return Answer(answer, _text(found, study.mechanism), notes, code, None if page is None else partial(draw, page))


def _origin(found: "Diagnosis", args: argparse.Namespace) -> list[str]:
    """Return what a mechanism file should say of where its numbers come from."""
    fitted = ", ".join((*found.calibration, *found.dimensions))
    return [f"From ecm-fast diagnose {' '.join(args.data)}: {found.sentence}", f"Fitted, too: {fitted}."]


def _page_path(args: argparse.Namespace) -> Path | None:
    """Return where the page goes, None where none is asked for."""
    if args.report:
        return Path(args.report)
    return None if args.out is None else folder(args.out) / "diagnosis.html"


def _inputs(args: argparse.Namespace) -> dict[str, Any]:
    """Return what ``next`` needs to go on."""
    return {
        "mechanism": None if args.mechanism is None else str(Path(args.mechanism).resolve()),
        "data": [str(Path(path).resolve()) for path in args.data],
        "priors": {name: list(prior) for name, prior in priors_by_name(args.prior).items()},
        "noise": numbers_by_name("--noise", args.noise),
        "columns": None if (told := column_map(args)) is None else told.to_dict(),
    }


def _text(found: "Diagnosis", neck: "Mechanism") -> str:
    from ..diagnosis.answer.next_step import next_step
    from ..diagnosis.answer.sentences import MIRRORS, alike, dimensions, meaning, next_best, size

    lines = [f"{found.verdict}: {found.sentence}"]
    for claim in found.effects:
        lines += [size(claim, name) for name in claim.parameters]
        lines += [f"  {meaning(claim)}", f"  {claim.sigmas:.1f} sigma, {MIRRORS[claim.mirror]}, group: {claim.group}",
                  f"  look-alikes: {alike(found.models, found.names, claim) or 'none'}"]  # fmt: skip
    lines += [f"  {text}" for text in [next_best(found.models, found.names)] if text]
    lines += [f"{name} {estimate}{_beside(neck, name, estimate.value)}" for name, estimate in found.calibration.items()]
    lines += [text for text in [dimensions(found.dimensions, neck.effects)] if text]
    lines += _gap_lines(found)
    if found.verdict == "nothing_found":
        smallest = sorted((s for s in found.sights if isfinite(s.smallest)), key=lambda s: s.smallest / s.typical)
        lines += [f"would have been found: {s.name} from {s.smallest:.3g} {s.unit}" for s in smallest[:_SHOWN]]
    lines += [f"left out: {place}: {reason}" for place, reason in found.outliers[:_SHOWN]]
    lines.append(f"next: {next_step(found.verdict, found.gap.to_json_dict() if found.gap else {}, found.missing)}")
    return "\n".join(lines)


def _beside(neck: "Mechanism", name: str, value: float) -> str:
    """Return how far a stiffness is from the mechanism file's."""
    given = getattr(neck.beam, name, None) if name in ("EA", "GA", "EI") else None
    return "" if not given else f", {value / given - 1.0:+.1%} of the mechanism file's"


def _gap_lines(found: "Diagnosis") -> list[str]:
    words = {
        "calibrated alone": f"calibrated alone ({', '.join(found.calibration)} and dimensions fitted, no effect)",
        "floor": "floor (noise of camera and forces)",
    }
    stages = found.gap.stages if found.gap else {}
    rows = f"{found.gap.rows} rows set aside" if found.gap else ""
    lines = [
        f"{rows}, {words.get(name, name)}: x {1e3 * rms.x:.3g} mm, z {1e3 * rms.z:.3g} mm, "
        f"theta {1e3 * rms.theta:.3g} mrad, {rms.sigma:.3g} sigma"
        for name, rms in stages.items()
        if found.effects or name != "with what was found"
    ]
    return lines + [
        f"never fitted, {gap.what}: {gap.given.sigma:.3g} sigma as given, {gap.before.sigma:.3g} calibrated alone, "
        f"{gap.after.sigma:.3g} with what was found; allowed {gap.allowed:.3g}"
        for gap in found.transfer
    ]


def _plan(args: argparse.Namespace) -> Answer:
    from ..studies.diagnosis import plan

    found = plan(mechanism(args), **_common(args))
    answer = found.to_json_dict()
    return Answer(answer, _plan_text(found), (*(f"warning: {t}" for t in found.warnings), *saved(args, answer)))


def _plan_text(found: "Plan") -> str:
    lines = [f"{found.rows} loads; {found.noise}"]
    for sight in found.sights:
        rivals = ", ".join(f"{name} ({sigmas:.1f})" for name, _, sigmas in sight.rivals[:3])
        cure = f"; would be shown by {sight.cure}" if sight.cure else ""
        lines.append(f"{sight.visible:9} {sight.name}: typical {sight.typical:g} {sight.unit} is {sight.sigmas:.1f} "
                     f"sigma, found from {sight.smallest:.2g}; nearest {rivals or 'none'}{cure}")  # fmt: skip
    lines.append("next: measure these loads, then ecm-fast diagnose DATA")
    return "\n".join(lines)


DIAGNOSE = Command(
    "find which effect the model is missing, with its look-alikes and the proof",
    _add_diagnose,
    _diagnose,
    "folder for mechanism.toml (the neck with what was found), diagnose.json (for next) and the page diagnosis.html "
    "with the numbers of its pictures, a CSV file each; made where it is missing; without it only out/mechanism.toml "
    "is written",
)
PLAN = Command("say which effects loads can show, before anything is measured", _add_common, _plan)
