"""The paper's figures and other people's measurements, redone: which claims hold, with the numbers behind them.

One file a subject: `workspace`, `cantilevers`, `solutions`. To add a claim, write a function that returns a `Part`
and give it a line in `_PARTS`.
"""

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ..errors import InputError, why
from ..files import write_whole
from ..report import VERDICTS, Section, Table, require, write_report
from ._claim import Claim, Part, plain
from .cantilevers import silicone, steel
from .solutions import reference
from .workspace import workspace

__all__ = ["Claim", "Reproduction", "reproduce"]

_PARTS: dict[str, tuple[str, Callable[[], Part]]] = {
    "workspace": ("workspace of both presets (Fig. 4)", workspace),
    "steel_cantilever": ("steel cantilever against measurements", steel),
    "silicone_cantilever": ("silicone cantilever against measurements", silicone),
    "reference_solutions": ("solutions by another method", reference),
}


@dataclass(frozen=True)
class Reproduction:
    """What was found.

    Attributes
    ----------
    claims : with a verdict each
    numbers : everything the claims rest on, in SI; None where a number is not known
    report : path of the page
    """

    claims: tuple[Claim, ...]
    numbers: Mapping[str, Any]
    report: Path

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON holds it: text, numbers, None, lists and dictionaries."""
        claims = [asdict(claim) for claim in self.claims]
        return {"claims": claims, "numbers": plain(self.numbers), "report": str(self.report)}


def reproduce(out: str | os.PathLike[str], *, progress: Callable[[str], None] | None = None) -> Reproduction:
    """Redo it all and write ``report.html``, ``results.json`` and a CSV of every picture into the folder `out`.

    Parameters
    ----------
    out : made where it is missing
    progress : called with one line of text before every part

    Raises
    ------
    InputError : a file cannot be written, or matplotlib or jinja2 is missing.
    """
    require()
    folder = Path(out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise InputError(f"{folder}: cannot be made ({why(error)})") from None
    parts = {}
    for name, (what, redo) in _PARTS.items():
        if progress is not None:
            progress(what)
        parts[name] = redo()
    claims = tuple(claim for part in parts.values() for claim in part.claims)
    sections = [_overview(claims), *(part.section for part in parts.values())]
    page = write_report(folder / "report.html", "What ecm-fast reproduces", sections)
    result = Reproduction(claims, {name: part.numbers for name, part in parts.items()}, page)
    # beside the page its name is enough, and the file does not change when the folder moves
    content = {**result.to_json(), "report": page.name}
    write_whole(folder / "results.json", json.dumps(content, indent=1, allow_nan=False) + "\n")
    return result


def _overview(claims: tuple[Claim, ...]) -> Section:
    hold, differ, unknown = (sum(claim.verdict.startswith(kind) for claim in claims) for kind in VERDICTS)
    sentences = (
        f"Of {len(claims)} claims, {hold} hold and {differ} differ; {unknown} cannot be checked because the number to "
        "compare with was not published.",
        "The paper is the planar study of a tendon-driven elastic continuum mechanism whose finite element model "
        "this program makes fast. Many dimensions of the mechanism are not in it; the mechanism's defaults say which "
        "values are stated, derived, found or assumed.",
    )
    rows = tuple((claim.what, claim.theirs, claim.ours, claim.verdict) for claim in claims)
    return Section(
        "", sentences, (Table("Claims and what comes out here", ("claim", "paper or source", "here", "verdict"), rows),)
    )
