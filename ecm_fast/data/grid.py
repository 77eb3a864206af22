"""Tables as people write them: the mark between columns, the lines of names and units, the mark of decimals.

Nothing is guessed: what can be read in two ways is refused, with the key of `Layout` that says which it is.
"""

import csv
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ..errors import InputError
from .cells import decimal_mark, is_blank, is_number, with_point
from .columns import is_known, is_note
from .units import OTHER, unit_of

__all__ = ["PLAIN", "Layout", "RawTable", "Record", "decoded", "table", "text_records"]

Record = tuple[int, Sequence[object]]
"""A record's line or row, and its cells."""

_MARKS = ("\t", ";", ",", " ")
_LOOKED_AT = 100  # records that show how a table is laid out
_MOST_LEVELS = 8  # lines of names above each other
_NO_UNIT = ("-", "1", "none", "text")  # of a column of numbers or words, in a line of units


@dataclass(frozen=True, slots=True)
class RawTable:
    """Named columns of cells, notes left out; a cell is text, a number or None for a blank.

    Attributes
    ----------
    columns : (name, cells) as they stand in the file
    rows : what a user calls each record: its line in a text file, else its row
    counted : "line" or "row"
    """

    columns: Sequence[tuple[str, Sequence[object]]]
    rows: Sequence[int]
    counted: str


@dataclass(frozen=True, slots=True)
class Layout:
    """Layout of a table as far as it is told; the rest is recognized.

    Attributes
    ----------
    decimal : the mark of decimals, a point or a comma
    header : line that names the columns
    sheet : of a workbook
    """

    decimal: str = ""
    header: int = 0
    sheet: str = ""


PLAIN = Layout()
"""Nothing is told."""


def decoded(content: bytes) -> str:
    """Return the text of a file: UTF-8, UTF-16 as Excel writes it, else the 8-bit letters of Western Europe."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return _utf16(content, "utf-16")
    for ending, nul in (("utf-16-le", slice(1, 8, 2)), ("utf-16-be", slice(0, 8, 2))):
        if content[:8].count(b"\0") == len(content[nul]) == content[nul].count(b"\0") > 0:
            return _utf16(content, ending)
    if b"\0" in content:
        line = content[: content.index(b"\0")].count(b"\n") + 1
        raise InputError(f"line {line}: holds a NUL byte, so it is no text; save it as CSV UTF-8")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace")


def _utf16(content: bytes, encoding: str) -> str:
    try:
        return content.decode(encoding)
    except UnicodeDecodeError as error:
        raise InputError(
            f"begins as UTF-16 text and goes on as none (byte {error.start}); save it as CSV UTF-8"
        ) from None


def text_records(text: str) -> tuple[list[Record], str]:
    """Return the records of a text, blank ones left out, and the mark that separates their cells.

    Raises
    ------
    InputError : it is empty, or a record cannot be taken apart.
    """
    lines = list(io.StringIO(text, newline=""))  # every line ending, counted as `csv` does
    start = next((i for i, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")), None)
    if start is None:
        raise InputError("is empty; the first line names the columns")
    mark = _mark(lines[start : start + _LOOKED_AT])
    return list(_split(lines[start:], start, mark)), mark


def _mark(lines: Sequence[str]) -> str:
    """Return what separates columns: the mark that makes most numbers of lines, of equal ones the least else."""
    for mark in _MARKS[:3]:
        names = next(csv.reader(lines[:1], delimiter=mark, skipinitialspace=True), [])
        if names and all(is_known(name.strip()) or is_note(name.strip()) for name in names):
            return mark
    found = {mark: counts for mark in _MARKS if (counts := _numbers(lines, mark))[0]}
    if found:
        return max(found, key=lambda mark: found[mark])  # of equal ones the first
    last = lines[-1].strip()  # in the name of a lone column a blank parts nothing
    return next((mark for mark in _MARKS if mark in lines[0].strip() and (mark in last or len(lines) == 1)), ",")


def _numbers(lines: Sequence[str], mark: str) -> tuple[int, int]:
    """Return how many cells are numbers, and less how many are none, of records as long as the last; 0 if of one."""
    try:
        records = [cells for _, cells in _split(lines, 0, mark)]
    except InputError:
        return 0, 0
    alike = [cells for cells in records if len(cells) == len(records[-1])] if records else []
    if not alike or len(alike[0]) < 2:
        return 0, 0
    cells = [cell for record in alike for cell in record]
    numbers = sum(map(is_number, cells))
    return numbers, numbers - len(cells)


def _split(lines: Sequence[str], start: int, mark: str) -> Iterator[Record]:
    """Yield the records; one without any content is a blank line, as spreadsheets leave them."""
    if mark == " ":
        apart = ([cell for cell in line.strip().split(" ") if cell] for line in lines)
        yield from ((start + i + 1, cells) for i, cells in enumerate(apart) if cells)
        return
    reader = csv.reader(lines, delimiter=mark, strict=True, skipinitialspace=True)
    line = start + 1
    try:
        for cells in reader:
            if any(cell.strip() for cell in cells):
                yield line, [cell.strip() for cell in cells]
            line = start + reader.line_num + 1  # a quoted cell may hold line breaks: its record counts from the first
    except csv.Error as error:
        raise InputError(f"line {start + reader.line_num}: {error}") from None


def table(records: Sequence[Record], counted: str, layout: Layout, mark: str = "", *, bare: bool = False) -> RawTable:
    """Return the columns of records by their names, with a unit that stands below a name added as ``[unit]``.

    Parameters
    ----------
    records : not empty
    counted : what their numbers count, "line" or "row"
    layout : what is told
    mark : what separated the cells, where they were text
    bare : whether columns without names are taken, by their places from 1 on

    Raises
    ------
    InputError : no names, unequal records, or decimals that can be read in two ways.
    """
    names, body = _header(records, counted, layout)
    if not names and not bare:
        raise InputError(f"{counted} {body[0][0]}: holds numbers where the names of the columns are expected: "
                         "add them, or name columns by place: --rename 1=lam_l_N --rename 2=lam_r_N ...")  # fmt: skip
    names = names or [str(i + 1) for i in range(len(body[0][1]))]
    rows = [cells for _, cells in body]
    while len(names) > 1 and not names[-1] and rows and all(_ends_blank(cells, len(names)) for cells in rows):
        names, rows = names[:-1], [cells[: len(names) - 1] for cells in rows]  # a mark at the end of each line
    for (place, _), cells in zip(body, rows, strict=True):
        if len(cells) != len(names):
            comma = " (decimals are written with a point)" if mark == "," and len(cells) > len(names) else ""
            raise InputError(f"{counted} {place}: has {len(cells)} cells, the header names {len(names)} columns{comma}")
    columns = list(zip(*rows, strict=True)) if rows else [()] * len(names)
    pairs: list[tuple[str, Sequence[object]]] = [
        (name, cells) for name, cells in zip(names, columns, strict=True) if bare or not is_note(name)
    ]
    if _decimal([cell for _, cells in pairs for cell in cells], mark, layout) == ",":
        pairs = [(name, [with_point(cell) for cell in cells]) for name, cells in pairs]
    return RawTable(pairs, [place for place, _ in body], counted)


def _ends_blank(cells: Sequence[object], width: int) -> bool:
    return len(cells) < width or (len(cells) == width and is_blank(cells[-1]))


def _header(records: Sequence[Record], counted: str, layout: Layout) -> tuple[list[str], Sequence[Record]]:
    """Return the names of the columns, nothing where there are none, and the records below them."""
    if layout.header:
        at = next((i for i, (place, _) in enumerate(records) if place == layout.header), None)
        if at is None:
            raise InputError(f"header = {layout.header}: there is nothing in that {counted}")
    elif _all_known(records[0][1]):
        at = 0
    else:
        seen = records[:_LOOKED_AT]
        full = sorted(_filled(cells) for _, cells in seen)[len(seen) // 2]
        first = next((i for i, (_, cells) in enumerate(seen) if _holds_data(cells) and 2 * _filled(cells) >= full
                      and _same_width(seen, i, -1)), None)  # fmt: skip
        if first == 0:
            return [], records
        at = 0 if first is None else first - 1
    below = at + 1
    if not layout.header and at > 0 and _holds_units(records[at][1]) and _same_width(records, at - 1, at):
        at -= 1
    elif below < len(records) and _holds_units(records[below][1]) and _same_width(records, at, below):
        below += 1
    names = _unique(records, at)
    if below - at == 2:
        names = [_with_unit(name, _bare(unit)) for name, unit in zip(names, records[below - 1][1], strict=True)]
    body = records[below:]
    if body and len(body[0][1]) == len(names) + 1 and all(is_blank(cells[-1]) for _, cells in body):
        names = [*names, ""]
    return names, body


def _all_known(cells: Sequence[object]) -> bool:
    names = [_text(cell) for cell in cells]
    return all(is_known(name) or is_note(name) for name in names)


def _filled(cells: Sequence[object]) -> int:
    return sum(not is_blank(cell) for cell in cells)


def _holds_data(cells: Sequence[object]) -> bool:
    """Tell whether a record holds numbers rather than names: half of what stands in it or more."""
    numbers = sum(map(is_number, cells))
    words = sum(not is_number(cell) and not is_blank(cell) for cell in cells)
    return numbers > 0 and numbers >= words


def _holds_units(cells: Sequence[object]) -> bool:
    """Tell whether a record holds units, some perhaps unknown in brackets, and no name of a column among them."""
    texts = {_text(cell): _bare(cell) for cell in cells if _bare(cell)}
    return any(map(unit_of, texts.values())) and all(
        unit_of(text) or text in (*OTHER, *_NO_UNIT) or (whole[0] in "[(" and whole[-1] in "])")
        for whole, text in texts.items()
    )


def _with_unit(name: str, unit: str) -> str:
    own = name.rpartition("_")[2]
    return name if not unit or unit in _NO_UNIT or (own and own == unit_of(unit)) else f"{name} [{unit}]"


def _same_width(records: Sequence[Record], one: int, other: int) -> bool:
    return len(records[one][1]) == len(records[other][1])


def _unique(records: Sequence[Record], at: int) -> list[str]:
    """Return the names in a record; where some are alike, with those of the records above before them."""
    names = [_text(cell) for cell in records[at][1]]
    for above in range(at - 1, max(at - _MOST_LEVELS, -1), -1):
        given = [name for name in names if name]
        if len({*given}) == len(given) or not _same_width(records, above, at):
            break
        names = [f"{_text(cell)} {name}".strip() for cell, name in zip(records[above][1], names, strict=True)]
    return names


def _text(cell: object) -> str:
    return "" if cell is None else " ".join(str(cell).split())


def _bare(cell: object) -> str:
    """Return a cell without the brackets around it."""
    return _text(cell).strip("[](){}<> ")


def _decimal(cells: Sequence[object], mark: str, layout: Layout) -> str:
    """Return the mark of decimals.

    Raises
    ------
    InputError : there are two, or it could as well part thousands.
    """
    found, shows = decimal_mark(cells)
    if layout.decimal == "." or (not layout.decimal and mark == "," and found == "."):
        return "."
    if len(found) > 1:
        raise InputError("some numbers are written with a decimal point and some with a comma; write all with one")
    if layout.decimal == "," and found == ".":
        raise InputError('numbers are written with a point where decimal = "," is told')
    if found and not shows and not layout.decimal and mark != " ":  # programs write blanks, spreadsheets the others
        raise InputError(f"numbers such as 1{found}234 could be thousands or decimals; say decimal = '{found}' or the "
                         "other mark in the file of --columns, or --decimal to ecm-fast import")  # fmt: skip
    return found
