"""``ecm-fast reproduce``: the paper's results, and which of its claims hold."""

import argparse

from ._answer import Answer, Command, folder
from ._streams import note

__all__ = ["COMMAND"]


def _run(args: argparse.Namespace) -> Answer:
    from ..reproduce import reproduce

    out = folder(args.out or "out")
    result = reproduce(out, progress=note)
    text = "\n".join(
        f"{claim.what}\n    theirs: {claim.theirs}; here: {claim.ours}\n    {claim.verdict}" for claim in result.claims
    )
    return Answer(result.to_json(), text, (f"wrote {out}",))


COMMAND = Command("the paper's tables and figures, and which of its claims hold", lambda parser: None, _run)
