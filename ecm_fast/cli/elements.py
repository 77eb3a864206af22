"""``ecm-fast elements``: the smallest number of elements that keeps a tolerance."""

import argparse
from typing import TYPE_CHECKING, Any

from .frame.arguments import add_columns, finite_number, measurements, mechanism
from .frame.command import IN_OUT, Answer, Command, folder
from .frame.terminal import note

if TYPE_CHECKING:
    from ..studies.elements.study import ElementStudy

__all__ = ["COMMAND"]

_DRAWN = ("tendons", "box")


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--mechanism", metavar="F", help="mechanism file (TOML); default: the preset 'slender'")
    parser.add_argument(
        "--loads",
        default="tendons",
        metavar="LOADS",
        help="'tendons', random forces from 0 to 160 N, the default; 'box', the paper's wrenches; or a data file",
    )
    parser.add_argument(
        "--tolerance",
        type=finite_number,
        default=1e-3,
        metavar="E",
        help="error of the tip that is allowed, in lengths of the beam and rad; default 1e-3",
    )
    parser.add_argument("--family", metavar="NAME", help="lagrange, se2 or strain, the only one compared; default: all")
    add_columns(parser)


def _run(args: argparse.Namespace) -> Answer:
    from ..pages.page import require

    require()
    neck, loads = mechanism(args), _loads(args.loads, args)
    out = folder(args.out or "out")
    from ..studies.elements.page import summary, write_study
    from ..studies.elements.study import study_elements

    study = study_elements(neck, loads, args.tolerance, family=args.family, progress=note)
    found = {**summary(study), "report": write_study(study, out)}
    return Answer(found, _text(study), (f"wrote {out}",))


def _loads(words: str, args: argparse.Namespace) -> Any:
    return words if words in _DRAWN else measurements(words, args)


def _text(study: "ElementStudy") -> str:
    from ..studies.elements.answer import answer

    lines = [f"{len(study.known.loads)} load cases, errors known to {study.known.error:.0e}", "none beats:"]
    lines += [f"    {row.sentence}" for row in study.front]
    return "\n".join([*lines, f"for {study.tolerance:g}: {study.sentence}", *answer(study)])


COMMAND = Command("how few elements suffice, and of which kind", _add_arguments, _run, IN_OUT)
