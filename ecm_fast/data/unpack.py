"""Parquet, MATLAB and Excel files, read in a process of their own: ``python -m ecm_fast.data.unpack ENDING PATH ...``.

The libraries that read them are compiled, and their files compressed. A damaged file can end the process that reads it
(SciPy 1.17 looks up a type number unchecked), and a small one can ask for all the memory there is. In a process of
their own both are one line of `InputError`.
"""

import importlib
import io
import math
import os
import pickle
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from .columns import is_note
from .grid import RawTable, Record
from .readers import table_of

__all__ = ["MOST_CELLS", "READERS", "answer"]

MOST_CELLS = 10_000_000
"""Cells of a file: a day of readings of ten columns, ten a second; as Python's numbers they take half a gigabyte."""
_MEMORY = 4 << 30  # bytes of addresses: what `MOST_CELLS` need twice over, and the libraries themselves
_SECONDS = 120  # of the processor, a hundred times what the largest file takes
_CURE = "save vectors or one struct alone (of a table T: table2struct(T, 'ToScalar', true)), and text as cellstr"


class _Unreadable:
    """A variable of a kind that holds no columns."""

    def __init__(self, kind: str) -> None:
        self.kind = kind


def answer(
    ending: str, content: bytes, path: Path, sheet: str = "", bare: bool = False
) -> RawTable | list[Record] | str:
    """Return the table of a file, or the records of a sheet, or in one line why there is none."""
    try:
        return READERS[ending](content, path, sheet, bare)
    except InputError as error:
        return str(error)
    except MemoryError:
        return f"unpacks to more than the {_MEMORY >> 30} GB that reading a file may take"


def _counted(cells: int) -> None:
    if cells > MOST_CELLS:
        raise InputError(f"unpacks to {cells} cells; allowed are {MOST_CELLS}: split it, or leave rows out")


def _read_parquet(content: bytes, path: Path, sheet: str, bare: bool) -> RawTable:
    parquet = _optional("pyarrow.parquet", "a Parquet file")
    try:
        file = parquet.ParquetFile(io.BytesIO(content))
        _counted(file.metadata.num_rows * file.metadata.num_columns)
        table = file.read(use_threads=False)
        columns = [
            (name, column.to_pylist())
            for name, column in zip(table.column_names, table.columns, strict=True)
            if not is_note(name) and not name.startswith("__index_level_")  # pandas' own, not the user's
        ]
        return RawTable(columns, range(1, table.num_rows + 1), "row")
    except (InputError, MemoryError):
        raise
    except Exception as error:  # a damaged file makes it raise anything
        raise InputError(f"not a readable Parquet file ({_reason(error)})") from None


def _read_mat(content: bytes, path: Path, sheet: str, bare: bool) -> RawTable:
    newest = content.startswith(b"MATLAB") and content[124:128] == b"\0\2IM"
    found = _read_mat73(path) if newest else _read_mat5(content)
    named = {name: value for name, value in found.items() if not name.startswith(("__", "#")) and not is_note(name)}
    if bare:
        return table_of(_flat(named), bare=True)
    if len(named) == 1:
        named = _fields(next(iter(named.values()))) or named
    for name, value in named.items():
        if isinstance(value, _Unreadable) or _fields(value):
            kind = value.kind if isinstance(value, _Unreadable) else "a struct beside others"
            raise InputError(f"{name} is {kind}; {_CURE}")
    return table_of(named)


def _read_mat5(content: bytes) -> dict[str, Any]:
    """Return the variables of a file of version 4 to 7: arrays, text, lists for cell arrays, dicts for structs."""
    scipy: Any = importlib.import_module("scipy.io")  # its stubs know no streams
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", UserWarning)  # its word for a variable that is there twice
            _counted(sum(math.prod(map(int, shape)) for _, shape, _ in scipy.whosmat(io.BytesIO(content))))
            found = scipy.loadmat(io.BytesIO(content))
            return dict(_variable(name, value) for name, value in found.items() if not name.startswith("__"))
    except (InputError, MemoryError):
        raise
    except Exception as error:  # a damaged file makes it raise anything
        raise InputError(f"not a readable MATLAB file ({_reason(error)})") from None


def _variable(name: str, value: Any) -> tuple[str, Any]:
    """Return the name and the value of a variable; an object of MATLAB's own keeps its name in itself."""
    own = getattr(value, "dtype", np.dtype(float)).names or ()
    if own[:2] == ("s0", "s1"):
        first = np.ravel(value)[0]
        return first["s0"].decode(), _Unreadable(f"an object of the class {first['s2'].decode()}")
    return name, _value(value)


def _value(value: Any) -> Any:
    from scipy.io import matlab
    from scipy.sparse import issparse

    if issparse(value):
        return _Unreadable("a sparse matrix")
    if isinstance(value, (matlab.MatlabObject, matlab.MatlabFunction, matlab.MatlabOpaque)):
        return _Unreadable("an object or a function")
    if not isinstance(value, np.ndarray):
        return value
    if value.dtype.names is not None:
        records = [{name: _single(one[name]) for name in value.dtype.names} for one in value.ravel(order="F")]
        return records[0] if len(records) == 1 else records
    if value.dtype.kind == "O":
        return [_single(one) for one in value.ravel(order="F")]
    if value.dtype.kind == "U":
        return value.tolist() if value.size > 1 else "".join(value.ravel().tolist())
    return _Unreadable("complex") if value.dtype.kind == "c" else value


def _single(value: Any) -> Any:
    """Return a cell or a field; what holds one number is that number."""
    own = _value(value)
    return own.item() if isinstance(own, np.ndarray) and own.size == 1 else own


def _read_mat73(path: Path) -> dict[str, Any]:
    reader = _optional("pymatreader", "a MATLAB file of version 7.3 (or save it with -v7)")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", UserWarning)  # its word for a class it cannot read
            return dict(sorted(reader.read_mat(str(path)).items()))  # its own order changes from run to run
    except MemoryError:
        raise
    except Exception as error:  # a damaged file makes it raise anything
        raise InputError(f"not a readable MATLAB 7.3 file ({_reason(error)})") from None


def _fields(value: Any) -> dict[str, Any]:
    """Return the columns of a struct, or of a struct array with one record a row; nothing for anything else."""
    if isinstance(value, dict):
        return value
    if not isinstance(value, list) or not all(isinstance(record, dict) for record in value):
        return {}
    return {name: [record.get(name) for record in value] for record in value[:1] for name in record}


def _flat(values: dict[str, Any]) -> dict[str, Any]:
    """Return the entries of structs and cells beside each other, ``run.force``, ``run{1}``; others are left out."""
    found = dict[str, Any]()
    for name, value in values.items():
        inner = _fields(value)
        if inner:
            found |= _flat({f"{name}.{key}": entry for key, entry in inner.items()})
        elif isinstance(value, list) and any(isinstance(entry, np.ndarray) for entry in value):  # a cell array of them
            found |= _flat({f"{name}{{{i + 1}}}": entry for i, entry in enumerate(value)})
        elif not isinstance(value, _Unreadable):
            found[name] = value
    return found


def _read_xlsx(content: bytes, path: Path, sheet: str, bare: bool) -> list[Record]:
    openpyxl = _optional("openpyxl", "an Excel file")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its word on styles and validations that it leaves out
            values, formulas = (
                openpyxl.load_workbook(io.BytesIO(content), read_only=True, data_only=only) for only in (True, False)
            )
            sheets = {name: _rows(values[name]) for name in values.sheetnames if hasattr(values[name], "iter_rows")}
            name = _sheet(sheets, sheet)
            for (place, cells), (*_, written) in zip(sheets[name], _rows(formulas[name]), strict=False):
                if any(cell is None and isinstance(own, str) for cell, own in zip(cells, written, strict=False)):
                    raise InputError(f"row {place}: holds a formula without its value; open the file in a spreadsheet "
                                     "program and save it")  # fmt: skip
            return sheets[name]
    except (InputError, MemoryError):
        raise
    except Exception as error:  # a damaged file makes it raise anything
        raise InputError(f"not a readable Excel file ({_reason(error)})") from None


def _rows(sheet: Any) -> list[Record]:
    """Return the rows of a sheet that hold anything, all as wide as the widest."""
    rows, cells = list[tuple[int, list[Any]]](), 0
    for place, row in enumerate(sheet.iter_rows(values_only=True), start=1):
        cells += len(row)
        _counted(cells)
        if any(cell is not None for cell in row):
            rows.append((place, list(row)))
    used = [i for _, row in rows for i, cell in enumerate(row) if cell is not None]
    first, last = min(used, default=0), max(used, default=-1)
    return [(place, [*row, *[None] * (last + 1 - len(row))][first : last + 1]) for place, row in rows]


def _sheet(sheets: dict[str, list[Record]], asked: str) -> str:
    """Return the name of the sheet that is asked for, or of the only one that holds numbers."""
    if asked:
        if asked not in sheets:
            raise InputError(f"has no sheet {asked!r}; it has {', '.join(sheets)}")
        return asked
    numbers = {
        name: sum(isinstance(cell, (int, float)) for _, row in rows for cell in row) for name, rows in sheets.items()
    }
    found = [name for name, count in numbers.items() if count]
    if len(found) > 1:
        raise InputError(f"has the sheets {', '.join(found)}; say which: sheet = {found[0]!r} in the file of "
                         "--columns, or --sheet to ecm-fast import")  # fmt: skip
    return found[0] if found else _first_used(sheets)


def _first_used(sheets: dict[str, list[Record]]) -> str:
    for name, rows in sheets.items():
        if rows:
            return name
    raise InputError("is empty; the first row names the columns")


def _optional(module: str, what: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError:
        name = module.split(".")[0]
        raise InputError(f"reading {what} needs {name}: pip install 'ecm-fast[data]'") from None


def _reason(error: Exception) -> str:
    """Return a library's message as one short line."""
    return " ".join(str(error).split())[:200] or type(error).__name__


_Reader = Callable[[bytes, Path, str, bool], RawTable | list[Record]]
READERS: dict[str, _Reader] = {
    ".parquet": _read_parquet,
    ".mat": _read_mat,
    ".xlsx": _read_xlsx,
}


def _limit() -> None:
    """Bound what this process may take, where the system can."""
    try:
        import resource
    except ImportError:  # not on Windows
        return
    for kind, most in ((resource.RLIMIT_AS, _MEMORY), (resource.RLIMIT_CPU, _SECONDS), (resource.RLIMIT_CORE, 0)):
        hard = resource.getrlimit(kind)[1]
        least = most if hard == resource.RLIM_INFINITY else min(most, hard)
        try:
            resource.setrlimit(kind, (least, hard))
        except (OSError, ValueError):  # macOS refuses a limit below what is mapped already
            continue


def main() -> None:
    """Read the content of a file from stdin, and write the pickled answer to stdout."""
    _, ending, path, sheet, bare = sys.argv
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints is no answer
    content = sys.stdin.buffer.read()
    _limit()
    pickle.dump(answer(ending, content, Path(path), sheet, bool(bare)), out)
    out.close()


if __name__ == "__main__":
    main()
