"""Reader of MATLAB files of level 5 (``save -v6``, ``-v7``): vectors, text, cell arrays, structs.

Read here and not by scipy, whose compiled reader ends the whole process with a segmentation fault when an
uncompressed file is damaged (1.17: an unknown type number is looked up unchecked). Whatever the bytes, this one
returns or raises a Python exception.

Source: MathWorks, MAT-File Format, chapter 1, tables 1-1 to 1-3.
"""

import math
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Unreadable", "read_level5"]

_MATRIX, _COMPRESSED = 14, 15  # data types of the MAT-file 5 format, Table 1-1
_NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_ENCODINGS = {1: "ascii", 2: "latin-1", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
_CELL, _STRUCT, _CHAR, _NUMERIC = 1, 2, 4, range(6, 16)  # array types of the MAT-file 5 format, Table 1-3
_OTHERS = {3: "an object", 5: "a sparse matrix", 16: "a function", 17: "an object such as a table or a string array"}
_IS_COMPLEX = 0x800  # array flag of the MAT-file 5 format
_MOST_BYTES = 1 << 28  # of one variable once decompressed: 33 million numbers; a small file can ask for far more

_Part = tuple[int, memoryview]


@dataclass(frozen=True, slots=True)
class Unreadable:
    """A variable of a kind that holds no columns."""

    kind: str


def read_level5(content: bytes) -> dict[str, Any]:
    """Return the named variables: arrays of numbers, text, lists for cell arrays, dicts for structs.

    Raises
    ------
    Exception : of any kind, when the bytes are not such a file.
    """
    order = {b"IM": "<", b"MI": ">"}.get(content[126:128])
    if order is None:
        raise ValueError("the header is missing, or the file is of version 4; save it with -v7")
    found: dict[str, Any] = {}
    for kind, body in _parts(memoryview(content)[128:], order):
        name, value = _matrix(*(_decompressed(body, order) if kind == _COMPRESSED else (kind, body)), order)
        if name in found:
            raise ValueError(f"variable {name!r} is there twice")
        if name:  # MATLAB keeps its classes in a matrix without a name
            found[name] = value
    return found


def _parts(body: memoryview, order: str) -> Iterator[_Part]:
    """Yield (type number, bytes) of each element in `body`."""
    at = 0
    while at < len(body):
        kind, size = struct.unpack_from(f"{order}II", body, at)
        start = at + 8
        if kind >> 16:  # up to four bytes are packed into the tag's second half, their count into its first
            kind, size, start = kind & 0xFFFF, kind >> 16, at + 4
        if start + size > len(body) or (start == at + 4 and size > 4):
            raise ValueError("ends in the middle of a variable")
        yield kind, body[start : start + size]
        at = start + (size if kind == _COMPRESSED else size + -size % 8) if start == at + 8 else at + 8


def _decompressed(body: memoryview, order: str) -> _Part:
    stream = zlib.decompressobj()
    content = stream.decompress(body, _MOST_BYTES)
    if not stream.eof:
        raise ValueError("a compressed variable is cut off or too large")
    (part,) = _parts(memoryview(content), order)
    return part


def _matrix(kind: int, body: memoryview, order: str) -> tuple[str, Any]:
    """Return name and value of a variable, a cell or a field."""
    if kind != _MATRIX:
        raise ValueError(f"an element of type {kind} in the place of a variable")
    if not body:
        return "", np.zeros((0, 0))
    parts = _parts(body, order)
    flags = int(_numbers(next(parts), order)[0])
    if (what := flags & 0xFF) == 17:  # has no shape: its name comes next
        return _text(next(parts), order), Unreadable(_OTHERS[what])
    shape, name = [int(size) for size in _numbers(next(parts), order)], _text(next(parts), order)
    if min(shape) < 0:
        raise ValueError(f"variable {name!r} has the shape {shape}")
    if what in _OTHERS or flags & _IS_COMPLEX:
        return name, Unreadable(_OTHERS.get(what, "complex"))
    if what in _NUMERIC:
        return name, _numbers(next(parts), order).reshape(shape, order="F")
    if what == _CHAR:
        return name, _rows_of_text(_text(next(parts), order), shape)
    if what == _CELL:
        return name, _values(parts, math.prod(shape), order)
    if what == _STRUCT:
        return name, _records(parts, math.prod(shape), order)
    raise ValueError(f"variable {name!r} is of the unknown class {what}")


def _numbers(part: _Part, order: str) -> NDArray[Any]:
    return np.frombuffer(part[1], dtype=order + _NUMBERS[part[0]])


def _text(part: _Part, order: str) -> str:
    encoding = _ENCODINGS[part[0]]
    if encoding in ("utf-16", "utf-32"):
        encoding += "-le" if order == "<" else "-be"
    return bytes(part[1]).decode(encoding)


def _rows_of_text(text: str, shape: list[int]) -> str | list[str]:
    """Return a char array's rows; column by column is how they lie in the file."""
    if shape[0] == 1 or not text:
        return text
    if math.prod(shape) != len(text):
        raise ValueError(f"a text of {len(text)} characters has the shape {shape}")
    return [text[row :: shape[0]] for row in range(shape[0])]


def _values(parts: Iterator[_Part], count: int, order: str) -> list[Any]:
    values = [_matrix(kind, body, order)[1] for kind, body in parts]
    if len(values) != count:
        raise ValueError(f"{len(values)} values in the place of {count}")
    return [value.item() if isinstance(value, np.ndarray) and value.size == 1 else value for value in values]


def _records(parts: Iterator[_Part], count: int, order: str) -> Any:
    """Return a struct as a dict, a struct array as a list of them."""
    width, block = int(_numbers(next(parts), order)[0]), _text(next(parts), order)
    names = [block[at : at + width].split("\0")[0] for at in range(0, len(block), width)]
    n = len(names)
    if len(set(names)) != n:
        raise ValueError("a struct has two fields of the same name")
    values = _values(parts, count * n, order)
    records = [dict(zip(names, values[i * n : (i + 1) * n], strict=True)) for i in range(count if n else 0)]
    return records[0] if count == 1 and records else records
