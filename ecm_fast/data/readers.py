"""Readers of CSV, Excel, Parquet and MATLAB files: tables of bare cells, which `columns` interprets."""

import glob
import math
import os
import pickle
import subprocess
import sys
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, why
from ..files import read_whole
from .columns import is_note, match
from .grid import PLAIN, Layout, RawTable, Record, decoded, table, text_records

__all__ = ["files_of", "is_pattern", "read_table", "table_of"]


def read_table(path: str | os.PathLike[str], layout: Layout = PLAIN, *, bare: bool = False) -> RawTable:
    """Read a file; its ending tells the format.

    Parameters
    ----------
    path : of the file
    layout : what is told of it
    bare : whether the names of the columns may be any, and missing: a map will say what they mean

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
    return reader(content, target, layout, bare)


def is_pattern(path: str | os.PathLike[str]) -> bool:
    """Tell whether a path is a pattern of several files: it has wildcards, and no file is named so."""
    return glob.has_magic(os.fspath(path)) and not os.path.lexists(path)


def files_of(pattern: str | os.PathLike[str]) -> list[str]:
    """Return the files that a pattern fits, sorted.

    Raises
    ------
    InputError : there is none.
    """
    found = sorted(glob.glob(os.fspath(pattern)))
    if not found:
        raise InputError(f"{pattern}: fits no file")
    return found


def table_of(columns: Mapping[str, Any], *, bare: bool = False) -> RawTable:
    """Return a table of vectors that are in memory or come from MATLAB, where nan is the only blank of a number.

    With `bare` names may be any, the columns of a matrix are taken one by one, and what is no column is left out.
    """
    named = {name: value for name, value in columns.items() if not is_note(name)}
    if bare:
        named = _vectors(named)
    else:
        match(named)  # of an unknown matrix the user should hear that it is unknown, not that it is no vector
    cells = [(name, _cells(name, value)) for name, value in named.items()]
    for name, column in cells:
        if len(column) != len(cells[0][1]):
            raise InputError(f"{cells[0][0]} has {len(cells[0][1])} entries, {name} has {len(column)}; "
                             "all columns are equally long")  # fmt: skip
    return RawTable(cells, range(1, len(cells[0][1]) + 1) if cells else (), "row")


def _vectors(columns: Mapping[str, Any]) -> dict[str, Any]:
    """Return the vectors among variables, those in matrices as ``name[1]`` and so on: all of the most usual length."""
    arrays = {name: np.asarray(value, dtype=object if isinstance(value, list) else None)
              for name, value in columns.items() if not isinstance(value, str)}  # fmt: skip
    arrays = {name: value for name, value in arrays.items() if value.dtype.kind in "biufO" and value.size > 1}
    longest = Counter(max(value.shape) for value in arrays.values())
    if not longest:
        raise InputError("holds no vector and no matrix of numbers")
    length = max(longest, key=lambda size: (longest[size], size))
    found = dict[str, Any]()
    for name, value in arrays.items():
        if value.size == length:
            found[name] = value
        elif value.ndim == 2 and length in value.shape and value.shape[0] != value.shape[1]:
            rows = value if value.shape[0] == length else value.T
            found |= {f"{name}[{i + 1}]": rows[:, i] for i in range(rows.shape[1])}
    return found


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


def _read_text(content: bytes, _: Path, layout: Layout, bare: bool) -> RawTable:
    records, mark = text_records(decoded(content))
    return table(records, "line", layout, mark, bare=bare)


def _unpacked(content: bytes, path: Path, layout: Layout, bare: bool) -> RawTable:
    """Return the table of a file that a compiled library reads, by `unpack` in a process of its own.

    What the process answers is trusted: it is our own, and could do no more than this one.
    """
    ending = path.suffix.lower()
    found = [str(Path(__file__).parents[2]), *filter(None, sys.path)]
    # one thread and the system's memory: others map more addresses than a file may take
    one = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "ARROW_DEFAULT_MEMORY_POOL": "system"}
    done = subprocess.run(
        [sys.executable, "-P", "-m", "ecm_fast.data.unpack", ending, os.fspath(path), layout.sheet, "bare" * bare],
        input=content,
        capture_output=True,
        env={**os.environ, **one, "PYTHONPATH": os.pathsep.join(found)},
    )
    if done.returncode:
        how = f"signal {-done.returncode}" if done.returncode < 0 else f"code {done.returncode}"
        raise InputError(f"not a readable {ending} file (its reader ended with {how})")
    answer: RawTable | list[Record] | str = pickle.loads(done.stdout)
    if isinstance(answer, str):
        raise InputError(answer)
    return table(answer, "row", layout, bare=bare) if isinstance(answer, list) else answer


_TEXT = (".csv", ".txt", ".tsv", ".dat", ".asc")
_READERS = {**dict.fromkeys(_TEXT, _read_text), **dict.fromkeys((".xlsx", ".parquet", ".mat"), _unpacked)}
