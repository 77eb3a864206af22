"""Readers of CSV, Parquet and MATLAB files: tables of bare cells, which `columns` interprets."""

import csv
import importlib
import io
import math
import os
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, why
from ..files import read_whole
from .columns import is_note, match
from .matlab import Unreadable, read_level5

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


def _read_parquet(content: bytes, _: Path) -> RawTable:
    parquet = _optional("pyarrow.parquet", "a Parquet file")
    try:
        table = parquet.ParquetFile(io.BytesIO(content)).read()
        columns = [
            (name, column.to_pylist())
            for name, column in zip(table.column_names, table.columns, strict=True)
            if not is_note(name) and not name.startswith("__index_level_")  # pandas' own, not the user's
        ]
        return RawTable(columns, range(1, table.num_rows + 1), "row")
    except Exception as error:  # a damaged file makes it raise anything
        raise InputError(f"not a readable Parquet file ({_reason(error)})") from None


def _read_mat(content: bytes, path: Path) -> RawTable:
    if content.startswith(b"MATLAB") and content[124:128] == b"\0\2IM":
        found = _read_mat73(path)
    else:
        try:
            found = read_level5(content)
        except Exception as error:  # a damaged file makes it raise anything
            raise InputError(f"not a readable MATLAB file ({_reason(error)})") from None
    named = {name: value for name, value in found.items() if not name.startswith(("__", "#")) and not is_note(name)}
    if len(named) == 1:
        named = _fields(next(iter(named.values()))) or named
    for name, value in named.items():
        if isinstance(value, Unreadable) or _fields(value):
            kind = value.kind if isinstance(value, Unreadable) else "a struct beside others"
            raise InputError(f"{name} is {kind}; save vectors or one struct alone (of a table T: "
                             "table2struct(T, 'ToScalar', true)), and text as cellstr")  # fmt: skip
    return table_of(named)


def _read_mat73(path: Path) -> dict[str, Any]:
    reader = _optional("pymatreader", "a MATLAB file of version 7.3 (or save it with -v7)")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", UserWarning)  # its word for a class it cannot read
            return dict(sorted(reader.read_mat(str(path)).items()))  # its own order changes from run to run
    except Exception as error:  # a damaged file makes it raise anything
        raise InputError(f"not a readable MATLAB 7.3 file ({_reason(error)})") from None


def _fields(value: Any) -> dict[str, Any]:
    """Return the columns of a struct, or of a struct array with one record a row; nothing for anything else."""
    if isinstance(value, dict):
        return value
    if not isinstance(value, list) or not all(isinstance(record, dict) for record in value):
        return {}
    return {name: [record.get(name) for record in value] for record in value[:1] for name in record}


def _optional(module: str, what: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError:
        name = module.split(".")[0]
        raise InputError(f"reading {what} needs {name}: pip install 'ecm-fast[data]'") from None


def _reason(error: Exception) -> str:
    """Return a library's message as one short line."""
    return " ".join(str(error).split())[:200] or type(error).__name__


_READERS = {".csv": _read_csv, ".txt": _read_csv, ".parquet": _read_parquet, ".mat": _read_mat}
