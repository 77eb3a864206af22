"""Single cells: numbers, blanks, times and labels, as files and people write them."""

import math
import re
from collections.abc import Sequence
from datetime import UTC, date, datetime, time
from decimal import Decimal

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "DECIMAL_COMMA",
    "bad_cells",
    "decimal_mark",
    "is_blank",
    "is_number",
    "is_time",
    "label",
    "number",
    "seconds",
    "shown",
    "with_point",
]

_BAD_CELLS_SHOWN = 5  # enough to see a pattern on one line
_BLANKS = " \t\xa0"
_NOTHING = ("", "nan", "-", "--", "n/a", "#n/a", "na", "#nv", "none", "null")
"""Words for no number, in small letters; #N/A and #NV are Excel's."""
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
DECIMAL_COMMA = re.compile(r"[+-]?[0-9]*,[0-9]+(?:[eE][+-]?[0-9]+)?")
"""A number whose decimals are written with a comma."""
_THOUSANDS = re.compile(r"[+-]?[1-9][0-9]{0,2}[.,][0-9]{3}")  # could be a thousand and something

_DAY = r"(?:(?P<year>\d{4})-(?P<month>\d\d?)-(?P<day>\d\d?)|(?P<d>\d\d?)\.(?P<m>\d\d?)\.(?P<y>\d{4}))"
_CLOCK = r"(?P<hour>\d\d?):(?P<minute>\d\d)(?::(?P<second>\d\d)(?P<rest>[.,]\d+)?)?"
_TIME = re.compile(rf"(?:{_DAY}(?:[T ]+{_CLOCK})?|{_CLOCK.replace('?P<', '?P<c')})\s*(?P<zone>Z|[+-]\d\d:?\d\d)?")


def is_blank(cell: object) -> bool:
    """Tell whether a cell holds no number and says so."""
    return cell is None or (isinstance(cell, str) and cell.strip(_BLANKS).lower() in _NOTHING)


def number(cell: object) -> float:
    """Return the number a cell holds, nan for anything else; `float` alone would take ``1_000`` and other scripts."""
    if isinstance(cell, str):
        text = cell.strip(_BLANKS)
        return float(text) if _NUMBER.fullmatch(text) else math.nan
    if isinstance(cell, bool) or not isinstance(cell, (int, float, Decimal)):
        return math.nan
    try:
        return float(cell)
    except (OverflowError, ValueError):  # an integer beyond doubles; a signaling NaN of a decimal
        return math.inf


def is_number(cell: object) -> bool:
    """Tell whether a cell holds a number, by whichever mark of decimals, or a time."""
    if isinstance(cell, str) and DECIMAL_COMMA.fullmatch(cell.strip(_BLANKS)):
        return True
    return not math.isnan(number(cell)) or is_time(cell)


def label(cell: object) -> str:
    """Return a label's text, a whole number without decimals (MATLAB knows no others), nothing for anything else."""
    if isinstance(cell, str):
        return cell.strip(_BLANKS)
    value = number(cell)
    if not math.isfinite(value):
        return ""
    return str(int(value)) if value == int(value) else repr(value)


def is_time(cell: object) -> bool:
    """Tell whether a cell holds a time of day or a date, ISO 8601 or day.month.year."""
    if isinstance(cell, str):
        return _TIME.fullmatch(cell.strip(_BLANKS)) is not None
    return isinstance(cell, (date, time))


def seconds(cells: Sequence[object]) -> tuple[NDArray[np.float64], dict[int, str]]:
    """Return the seconds of times since the first one, (n,), nan where blank, and for each bad cell what is wrong."""
    values, bad = np.full(len(cells), math.nan), {}
    first: datetime | None = None
    last = -math.inf
    for i, cell in enumerate(cells):
        if is_blank(cell):
            continue
        try:
            when = _moment(cell)
            first = first or when
            values[i] = (when - first).total_seconds()
            if when.year == 1 and values[i] < last:
                bad[i] = f"{shown(cell)} (earlier than the time before it, perhaps past midnight: give the date too)"
            last = values[i]
        except (ValueError, TypeError, AttributeError):  # TypeError: one of the two has no time zone
            bad[i] = f"{shown(cell)} (allowed is a time like the first one, as 2026-03-01T12:00:30.5 or 12:00:30.5)"
    return values, bad


def _moment(cell: object) -> datetime:
    if isinstance(cell, datetime):
        return cell
    if isinstance(cell, date):
        return datetime(cell.year, cell.month, cell.day)
    if isinstance(cell, time):
        return datetime.combine(date(1, 1, 1), cell)
    found = _TIME.fullmatch(cell.strip(_BLANKS)) if isinstance(cell, str) else None
    if found is None:
        raise ValueError
    part = {name: text for name, text in found.groupdict().items() if text}
    year, month, day = (int(part.get(one, part.get(one[0], 1))) for one in ("year", "month", "day"))
    hour, minute, second = (int(part.get(one, part.get(f"c{one}", 0))) for one in ("hour", "minute", "second"))
    rest = part.get("rest", part.get("crest", ".0")).replace(",", ".")
    when = datetime(year, month, day, hour, minute, second, int(1e6 * float(rest) + 0.5))
    zone = part.get("zone")
    if zone is None:
        return when
    return when.replace(tzinfo=UTC if zone == "Z" else datetime.strptime(zone, "%z").tzinfo)


def decimal_mark(cells: Sequence[object]) -> tuple[str, bool]:
    """Return the mark of decimals in the numbers of a table, and whether any of them shows that it is one.

    The mark is empty where no number has one, and both where some have a point and some a comma. That ``1,234`` is no
    thousand and something is shown by another number of the table with the same mark, say ``0,5``.
    """
    texts = [cell.strip(_BLANKS) for cell in cells if isinstance(cell, str)]
    commas = [text for text in texts if DECIMAL_COMMA.fullmatch(text)]
    points = [text for text in texts if "." in text and _NUMBER.fullmatch(text)]
    mark = "," * bool(commas) + "." * bool(points)
    return mark, not all(_THOUSANDS.fullmatch(text) for text in commas + points)


def with_point(cell: object) -> object:
    """Return a cell whose number has a point where it had a comma."""
    return cell.replace(",", ".") if isinstance(cell, str) and DECIMAL_COMMA.fullmatch(cell.strip(_BLANKS)) else cell


def shown(cell: object) -> str:
    """Return a cell as an error shows it."""
    text = repr(cell) if isinstance(cell, str) else " ".join(repr(cell).split())
    return text if len(text) <= 40 else f"{text[:36]} ..."


def bad_cells(bad: Sequence[tuple[int, str]]) -> str:
    """Return one line on bad cells, each with its row and what is wrong with it: the first of the file."""
    first = [text for _, text in sorted(bad, key=lambda entry: entry[0])[:_BAD_CELLS_SHOWN]]
    count = f"{len(bad)} bad cells: " if len(bad) > 1 else ""
    rest = len(bad) - len(first)
    return f"{count}{'; '.join(first)}{f'; and {rest} more' if rest else ''}"
