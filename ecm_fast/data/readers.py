"""Readers of CSV, Parquet and MATLAB files: tables of bare cells, which `columns` interprets."""

import csv
import io
import math
import os
import pickle
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, why
from ..files import read_whole
from .columns import is_note, match

__all__ = ["RawTable", "read_table", "table_of"]


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


def read_table(path: str | os.PathLike[str]) -> RawTable:
    """Read a file; its ending tells the format.

    Raises
    ------
    InputError : the file cannot be read or is not what its ending says; does not name the file, the caller does.
    """
    target = Path(path)
    reader = _READERS.get(target.suffix.lower())
    try:
        content = read_whole(target)
        if reader is None:
            raise InputError(f"file type {target.suffix!r} is not known; allowed are {', '.join(_READERS)}")
    except InputError:
        raise
    except (OSError, ValueError) as error:  # a ValueError is a path with a NUL in it
        raise InputError(f"cannot be read ({why(error)})") from None
    return reader(content, target)


def table_of(columns: Mapping[str, Any]) -> RawTable:
    """Return a table of vectors that are in memory or come from MATLAB, where nan is the only blank of a number."""
    named = {name: value for name, value in columns.items() if not is_note(name)}
    match(named)  # of an unknown matrix the user should hear that it is unknown, not that it is no vector
    cells = [(name, _cells(name, value)) for name, value in named.items()]
    for name, column in cells:
        if len(column) != len(cells[0][1]):
            raise InputError(f"{cells[0][0]} has {len(cells[0][1])} entries, {name} has {len(column)}; "
                             "all columns are equally long")  # fmt: skip
    return RawTable(cells, range(1, len(cells[0][1]) + 1), "row")


def _cells(name: str, value: Any) -> list[object]:
    if not isinstance(value, (list, tuple)):
        array = np.asarray(value)
        if array.size != max(array.shape, default=1) or array.dtype.kind not in "biufUO":
            shape = " x ".join(map(str, array.shape))
            raise InputError(f"{name} is {array.dtype.name} of shape {shape}; allowed is a vector of real numbers "
                             "or text")  # fmt: skip
        value = array.ravel().tolist()
    return [_cell(item) for item in value]


def _cell(item: object) -> object:
    if isinstance(item, np.generic):
        item = item.item()
    if (isinstance(item, float) and math.isnan(item)) or (isinstance(item, np.ndarray) and not item.size):
        return None  # an empty array is how MATLAB writes the empty text in a cell array
    return item


def _read_csv(content: bytes, _: Path) -> RawTable:
    lines = list(io.StringIO(_text(content), newline=""))  # every line ending, counted as `csv` does
    start = next((i for i, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")), None)
    if start is None:
        raise InputError("is empty; the first line names the columns")
    delimiter = _delimiter(lines[start].strip(), start + 1)
    reader = csv.reader(lines[start:], delimiter=delimiter, strict=True, skipinitialspace=True)
    try:
        header = [name.strip() for name in next(reader)]
        records = list(_records(reader, start, len(header)))
    except csv.Error as error:
        raise InputError(f"line {start + reader.line_num}: {error}") from None
    columns = zip(*(cells for _, cells in records), strict=True) if records else [()] * len(header)
    return RawTable(
        [(name, cells) for name, cells in zip(header, columns, strict=True) if not is_note(name)],
        [line for line, _ in records],
        "line",
    )


def _text(content: bytes) -> str:
    cure = "save it as CSV UTF-8"
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise InputError(f"is UTF-16 text; {cure}")
    if b"\0" in content:
        line = content[: content.index(b"\0")].count(b"\n") + 1
        raise InputError(f"line {line}: holds a NUL byte, so it is not UTF-8 text; {cure}")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line, byte = content[: error.start].count(b"\n") + 1, content[error.start]
        raise InputError(f"line {line}: byte 0x{byte:02x} is not UTF-8 text; {cure}") from None


def _delimiter(header: str, line: int) -> str:
    bare = re.sub(r'"[^"]*"', "", header)
    found = [mark for mark in ",;\t" if mark in bare]
    if len(found) > 1 or (not found and len(bare.split()) > 1):
        raise InputError(f"line {line}: the column names are separated by comma, semicolon or tab, one of them "
                         "throughout")  # fmt: skip
    return found[0] if found else ","


def _records(reader: Any, start: int, width: int) -> Iterator[tuple[int, list[str]]]:
    """Yield (line, cells) of every record; one without any content is a blank line, as spreadsheets leave them."""
    line = start + reader.line_num + 1
    for cells in reader:
        if any(cell.strip() for cell in cells):
            if len(cells) != width:
                comma = " (decimals are written with a point)" if len(cells) > width else ""
                raise InputError(f"line {line}: has {len(cells)} cells, the header names {width} columns{comma}")
            yield line, cells
        line = start + reader.line_num + 1  # a quoted cell may hold line breaks: a record counts from its first line


def _unpacked(content: bytes, path: Path) -> RawTable:
    """Return the table of a file that a compiled library reads, by `unpack` in a process of its own.

    What the process answers is trusted: it is our own, and could do no more than this one.
    """
    ending = path.suffix.lower()
    found = [str(Path(__file__).parents[2]), *filter(None, sys.path)]
    # one thread and the system's memory: others map more addresses than a file may take
    one = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "ARROW_DEFAULT_MEMORY_POOL": "system"}
    done = subprocess.run(
        [sys.executable, "-P", "-m", "ecm_fast.data.unpack", ending, os.fspath(path)],
        input=content,
        capture_output=True,
        env={**os.environ, **one, "PYTHONPATH": os.pathsep.join(found)},
    )
    if done.returncode:
        how = f"signal {-done.returncode}" if done.returncode < 0 else f"code {done.returncode}"
        raise InputError(f"not a readable {ending} file (its reader ended with {how})")
    answer: RawTable | str = pickle.loads(done.stdout)
    if isinstance(answer, str):
        raise InputError(answer)
    return answer


_READERS = {".csv": _read_csv, ".txt": _read_csv, ".parquet": _unpacked, ".mat": _unpacked}
