"""A Parquet writer for columns of numbers as they lie in memory, without a copy.

One row group, one page a column, plain and without compression. That is little enough of the format to be written out
here; a general writer copies every number twice, which costs a quarter of solving for it. Numbers of fields, types and
encodings are those of ``parquet.thrift`` (github.com/apache/parquet-format), in Thrift's compact protocol.
"""

import functools
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

__all__ = ["parquet_file"]

_MAGIC = b"PAR1"
_INT32, _DOUBLE, _INT_8 = 1, 5, 15
_PLAIN, _RLE, _RLE_DICTIONARY = 0, 3, 8
_DATA_PAGE, _DICTIONARY_PAGE = 0, 2

Field = tuple[int, bytes]
"""A field's type in the compact protocol, and what it holds."""


def parquet_file(
    columns: Mapping[str, NDArray[np.float64]],
    codes: tuple[str, NDArray[np.int64], int],
    about: Mapping[bytes, bytes],
    author: str,
) -> list[bytes | memoryview]:
    """Return a file as parts to be written one after the other; columns are parts themselves.

    Parameters
    ----------
    columns : by name, (rows,) each
    codes : name, values (rows,) and how many there are, at most 128: 0, 1, 2, ...; a last column, of 8-bit integers
    about : what the file says about itself, by key
    author : the program that writes it, and its version
    """
    parts: list[bytes | memoryview] = [_MAGIC]
    place, chunks, rows = len(_MAGIC), list[Field](), len(codes[1])
    for name, values in columns.items():
        data = np.ascontiguousarray(values, dtype="<f8").data.cast("B")
        head = _page(_DATA_PAGE, data.nbytes, rows, _PLAIN)
        chunks.append(_chunk(name, _DOUBLE, (_PLAIN, _RLE), rows, place, len(head) + data.nbytes))
        parts += head, data
        place += len(head) + data.nbytes
    name, numbers, kinds = codes
    known, places = np.arange(kinds, dtype="<i4").tobytes(), _places(numbers)
    dictionary = _page(_DICTIONARY_PAGE, len(known), kinds, _PLAIN) + known
    coded = dictionary + _page(_DATA_PAGE, len(places), rows, _RLE_DICTIONARY) + places
    chunks.append(_chunk(name, _INT32, (_PLAIN, _RLE, _RLE_DICTIONARY), rows, place, len(coded), first=len(dictionary)))
    group = _struct({1: _list(chunks), 2: _i64(place + len(coded) - len(_MAGIC)), 3: _i64(rows)})
    said = [_struct({1: _binary(key), 2: _binary(value)}) for key, value in about.items()]
    kind = {1: _i32(2), 2: _schema(tuple(columns), name), 3: _i64(rows)}
    footer = _struct(kind | {4: _list([group]), 5: _list(said), 6: _binary(author.encode())})[1]
    return [*parts, coded, footer, len(footer).to_bytes(4, "little"), _MAGIC]


@functools.lru_cache(maxsize=8)
def _schema(columns: tuple[str, ...], codes: str) -> Field:
    """Return names and types of the columns."""
    root = _struct({4: _binary(b"schema"), 5: _i32(len(columns) + 1)})
    leaves = [_struct({1: _i32(_DOUBLE), 3: _i32(0), 4: _binary(name.encode())}) for name in columns]
    last = _struct({1: _i32(_INT32), 3: _i32(0), 4: _binary(codes.encode()), 6: _i32(_INT_8)})
    return _list([root, *leaves, last])


def _places(codes: NDArray[np.int64]) -> bytes:
    """Return places in the dictionary of codes, 8 bits each: as one run where all are 0, else one after the other."""
    if not codes.any():
        return b"\x08" + _varint(len(codes) << 1) + b"\0"
    eights = -(-len(codes) // 8)
    return b"\x08" + _varint(eights << 1 | 1) + codes.astype(np.uint8).tobytes().ljust(8 * eights, b"\0")


@functools.lru_cache(maxsize=64)  # the pages of one file have the same head, and so have those of the next
def _page(kind: int, size: int, values: int, encoding: int) -> bytes:
    """Return the head of a page."""
    own = {1: _i32(values), 2: _i32(encoding)}
    if kind == _DATA_PAGE:
        own |= {3: _i32(_RLE), 4: _i32(_RLE)}
    return _struct({1: _i32(kind), 2: _i32(size), 3: _i32(size), 5 if kind == _DATA_PAGE else 7: _struct(own)})[1]


@functools.lru_cache(maxsize=256)
def _chunk(name: str, kind: int, encodings: tuple[int, ...], rows: int, place: int, size: int, first: int = 0) -> Field:
    """Return what the footer says about a column.

    place : where it begins in the file, size : of all its pages, first : of the one that holds the dictionary
    """
    about = {
        1: _i32(kind),
        2: _list([_i32(encoding) for encoding in encodings]),
        3: _list([_binary(name.encode())]),
        4: _i32(0),
        5: _i64(rows),
        6: _i64(size),
        7: _i64(size),
        9: _i64(place + first),
    }
    if first:
        about[11] = _i64(place)
    return _struct({2: _i64(place), 3: _struct(about)})


def _varint(number: int) -> bytes:
    """Return a number of 0 or more, seven bits a byte, the lowest first."""
    found = bytearray()
    while number > 0x7F:
        found.append(number & 0x7F | 0x80)
        number >>= 7
    found.append(number)
    return bytes(found)


def _i32(number: int) -> Field:
    return 5, _varint(number << 1)  # the lowest bit is the sign: none here is negative


def _i64(number: int) -> Field:
    return 6, _varint(number << 1)


def _binary(content: bytes) -> Field:
    return 8, _varint(len(content)) + content


def _list(entries: Iterable[Field]) -> Field:
    kinds, contents = zip(*entries, strict=True)
    size = bytes([len(kinds) << 4 | kinds[0]]) if len(kinds) < 15 else bytes([0xF0 | kinds[0]]) + _varint(len(kinds))
    return 9, size + b"".join(contents)


def _struct(fields: Mapping[int, Field]) -> Field:
    """Return a struct: before each field how far its number is from the one before, and its type."""
    heads = zip([0, *fields], fields, strict=False)
    return 12, b"".join(bytes([new - old << 4 | fields[new][0]]) + fields[new][1] for old, new in heads) + b"\0"
