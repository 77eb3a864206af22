"""``ecm-fast reproduce``: the paper's results, and a verdict for each of its claims."""

import argparse

from .frame.arguments import count
from .frame.command import IN_OUT, Answer, Command, folder
from .frame.terminal import note

__all__ = ["COMMAND"]


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--only", metavar="SECTION", action="append", help="one section of the page, e.g. table1; may be repeated"
    )
    parser.add_argument("--seed", type=count, default=0, metavar="N", help="of all random loads; default 0")


def _run(args: argparse.Namespace) -> Answer:
    from ..studies.paper import reproduce

    out = args.out or "out"
    result = reproduce(out, only=args.only, seed=args.seed, progress=note)
    text = "\n".join(
        f"{claim.what}\n    theirs: {claim.theirs}; here: {claim.ours}\n    {claim.verdict}" for claim in result.claims
    )
    return Answer(result.to_json(), text, (f"wrote {folder(out)}",))


COMMAND = Command("the paper's tables and figures, and which of its claims hold", _add_arguments, _run, IN_OUT)
