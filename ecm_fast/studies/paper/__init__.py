"""Reproduction of the paper's figures and of published measurements, with a verdict for each claim.

One file a subject, named in `_PARTS`. To add a claim, write a function that returns a `Part` and give it a line
there. Every part takes its sizes as arguments, whose defaults are those of the paper.
"""

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from ...errors import InputError, did_you_mean, why
from ...files import csv_text, plain, write_whole
from ...pages.page import VERDICTS, Section, Table, require, write_report
from .claims import PaperClaim, Part
from .fig4_workspace import workspace
from .fig5_polynomial import wrenches
from .fig6_comparison import comparison
from .fig7_section import times
from .measured_cantilevers import silicone, steel
from .measured_discrepancy import missing
from .outlook_conservative import kinds
from .outlook_measured import trained
from .outlook_pose_alone import pose_alone
from .reference_solutions import reference
from .table1_stiffness import table1

__all__ = ["SECTIONS", "PaperClaim", "Reproduction", "reproduce"]

_PARTS: dict[str, tuple[str, Callable[[int], Part]]] = {
    "table1": ("stiffnesses and shear test (Table 1, Fig. 3)", table1),
    "workspace": ("workspace of both presets (Fig. 4)", workspace),
    "wrenches": ("cubic polynomial against the model (Fig. 5)", wrenches),
    "kinds": ("polynomials that have an energy, and others", kinds),
    "trained": ("polynomials trained on measured poses, and forward ones", trained),
    "pose_alone": ("whether the pose alone fixes the wrench", pose_alone),
    "comparison": ("both models on tendon-driven data (Fig. 6)", comparison),
    "times": ("computing times (Fig. 7)", times),
    "steel_cantilever": ("steel cantilever against measurements", lambda seed: steel()),
    "silicone_cantilever": ("silicone cantilever against measurements", lambda seed: silicone()),
    "silicone_missing": ("what the model misses on the silicone cantilever", lambda seed: missing()),
    "reference_solutions": ("solutions by another method", lambda seed: reference()),
}
SECTIONS = tuple(_PARTS)


@dataclass(frozen=True)
class Reproduction:
    """Findings of a reproduction.

    Attributes
    ----------
    parts : the claims of every section, with a verdict each
    numbers : everything the claims rest on, in SI; None where a number is not known
    report : path of the page
    """

    parts: Mapping[str, tuple[PaperClaim, ...]]
    numbers: Mapping[str, Any]
    report: Path

    @property
    def claims(self) -> tuple[PaperClaim, ...]:
        """All claims, in the order of the page."""
        return tuple(claim for claims in self.parts.values() for claim in claims)

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON holds it: text, numbers, None, lists and dictionaries."""
        claims = [{"section": name, **asdict(claim)} for name, part in self.parts.items() for claim in part]
        return {"claims": claims, "numbers": plain(self.numbers), "report": str(self.report)}

    def __repr__(self) -> str:
        counts = ", ".join(f"{_count(self.claims, kind)} {words}" for kind, words in _KINDS.items())
        return f"<Reproduction of {len(self.parts)} sections: {counts}; {self.report}>"


_KINDS = dict(zip(VERDICTS, ("hold", "differ", "cannot be checked"), strict=True))


def reproduce(
    out: str | os.PathLike[str],
    *,
    only: Sequence[str] | None = None,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> Reproduction:
    """Redo it all and write a page, its numbers and a CSV of every picture into the folder `out`.

    The files are ``report.html``, ``results.json``, ``claims.csv`` and one CSV a picture.

    Parameters
    ----------
    out : made where it is missing
    only : some of `SECTIONS`; default all
    seed : of all random loads
    progress : called with one line of text before every part

    Raises
    ------
    InputError : no such section, a file cannot be written, or matplotlib or jinja2 is missing.
    """
    for name in only or ():
        if name not in _PARTS:
            raise InputError(f"no section {name!r}{did_you_mean(name, SECTIONS)}; allowed are {', '.join(SECTIONS)}")
    require()
    folder = Path(out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise InputError(f"{folder}: cannot be made ({why(error)})") from None
    parts = {}
    for name, (what, redo) in _PARTS.items():
        if only and name not in only:
            continue
        if progress is not None:
            progress(what)
        parts[name] = redo(seed)
    return _written(folder, parts)


def _written(folder: Path, parts: Mapping[str, Part]) -> Reproduction:
    sections = [_overview(parts), *(_with_claims(part) for part in parts.values())]
    page = write_report(folder / "report.html", "What ecm-fast reproduces", sections)
    claims = {name: part.claims for name, part in parts.items()}
    result = Reproduction(claims, {name: part.numbers for name, part in parts.items()}, page)
    # beside the page its name is enough, and the file does not change when the folder moves
    content = {**result.to_json(), "report": page.name}
    write_whole(folder / "results.json", json.dumps(content, indent=1, allow_nan=False) + "\n")
    rows = content["claims"]
    write_whole(folder / "claims.csv", csv_text({name: [row[name] for row in rows] for name in rows[0]}))
    return result


def _count(claims: Sequence[PaperClaim], kind: str) -> int:
    return sum(claim.verdict.startswith(kind) for claim in claims)


def _overview(parts: Mapping[str, Part]) -> Section:
    claims = [claim for part in parts.values() for claim in part.claims]
    hold, differ, unknown = (_count(claims, kind) for kind in VERDICTS)
    sentences = (
        f"Of {len(claims)} claims, {hold} hold and {differ} differ; {unknown} cannot be checked, because the number to "
        "compare with, or the measurement behind it, was not published.",
        "The paper is the planar study of a tendon-driven elastic continuum mechanism whose finite element model "
        "this program makes fast. Many dimensions of the mechanism are not in it; the mechanism's defaults say which "
        "values are stated, derived, found or assumed. Both presets are shown: paper, 40 mm long, the length at which "
        "the paper's polynomials are about as good as it says, and slender, 109 mm, the length of the group's later "
        "hardware.",
        "The paper's measurements are not public. Pictures headed SIMULATED show a simulated test bed in their place, "
        "which integrates the beam's differential equations and adds noise; they show that the method works, not that "
        "the neck is made like this.",
    )
    rows: list[tuple[str | float | None, ...]] = [
        (part.section.heading, *(_count(part.claims, kind) for kind in VERDICTS)) for part in parts.values()
    ]
    head = ("section", *_KINDS.values())
    return Section("", sentences, (Table("Claims in each section, by verdict", head, tuple(rows)),))


def _with_claims(part: Part) -> Section:
    rows = tuple((claim.what, claim.theirs, claim.ours, claim.verdict) for claim in part.claims)
    table = Table("Claims and what comes out here", ("claim", "paper or source", "here", "verdict"), rows)
    return replace(part.section, tables=(table, *part.section.tables))
