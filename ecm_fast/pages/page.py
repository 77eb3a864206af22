"""HTML pages with inline figures, and the numbers of every figure as CSV.

A page holds no script and asks no other host for anything; its Content-Security-Policy says so to the browser.
Matplotlib and jinja2 are optional and imported when the first page is written.
"""

from __future__ import annotations

import io
import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from ..errors import InputError
from ..files import csv_text, write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["VERDICTS", "Picture", "Section", "Table", "require", "svg", "write_report"]

VERDICTS = ("holds", "differs", "cannot")
"""First words of a verdict on a claim; a cell that starts with one is set in its color."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure with what is seen in it.

    Attributes
    ----------
    name : of its CSV, without the ending; unique in a page
    caption : one or two sentences, also read to those who do not see the figure
    columns : the numbers of the figure, equally long, by the heading of their column
    """

    name: str
    caption: str
    figure: Figure
    columns: Mapping[str, Sequence[Any] | NDArray[Any]]


@dataclass(frozen=True)
class Table:
    """Rows of text and numbers; None and what is not finite is shown as a dash."""

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[str | float | None, ...], ...]


@dataclass(frozen=True)
class Section:
    """Content under one heading: sentences first, then tables, then pictures."""

    heading: str
    sentences: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    pictures: tuple[Picture, ...] = field(default=())


def write_report(path: str | os.PathLike[str], title: str, sections: Sequence[Section]) -> Path:
    """Write a page to `path` and a CSV of every picture beside it.

    Raises
    ------
    InputError : a file cannot be written, or matplotlib or jinja2 is missing.
    """
    require()
    import jinja2

    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {"cell": _cell, "drawing": _drawing}
    environment.tests |= {"number": _is_number, "verdict": _is_verdict}
    template = environment.from_string((files(__package__) / "template.html").read_text(encoding="utf-8"))
    page = template.render(title=title, sections=sections)
    for section in sections:
        for picture in section.pictures:
            write_whole(Path(path).parent / f"{picture.name}.csv", csv_text(picture.columns))
    return write_whole(path, page)


def require() -> None:
    """Raise `InputError` where matplotlib or jinja2 is missing, before any work is done for a page."""
    try:
        import jinja2  # noqa: F401
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise InputError(f"a report needs {error.name}: pip install 'ecm-fast[report]'") from None


def svg(figure: Figure, name: str) -> str:
    """Return a figure as an element to stand in an HTML page; the same picture, drawn anew, gives the same text.

    Parameters
    ----------
    name : what the ids inside start from, so that pictures of one page do not share them
    """
    import matplotlib

    text = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": name, "svg.fonttype": "none"}):
        figure.savefig(text, format="svg", dpi=200, metadata={"Date": None})
    drawing = text.getvalue()
    drawing = drawing[drawing.index("<svg") :]
    drawing = re.sub(r"\s*<metadata>.*?</metadata>", "", drawing, flags=re.DOTALL)
    drawing = re.sub(r' xmlns(:\w+)?="[^"]*"', "", drawing)  # known to a browser inside HTML
    # groups are numbered alike in every picture; a page must not have an id twice, and nothing refers to these
    used = set(re.findall(r'#(\w+)["\')]', drawing))
    return re.sub(r' id="([^"]+)"', lambda found: found[0] if found[1] in used else "", drawing).rstrip()


def _drawing(picture: Picture) -> Any:
    from markupsafe import Markup

    return Markup(svg(picture.figure, picture.name))  # matplotlib escapes the texts in it


def _is_number(value: object) -> bool:
    return value is None or isinstance(value, (int, float))


def _is_verdict(value: object) -> bool:
    return isinstance(value, str) and value.split(" ", 1)[0] in VERDICTS


def _cell(value: str | float | None) -> str:
    if isinstance(value, str):
        return value
    if value is None or not math.isfinite(value):
        return "–"  # noqa: RUF001  a dash in a table
    return f"{value:.4g}"
