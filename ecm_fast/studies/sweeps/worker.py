"""The functions that run on a worker: arguments are a sweep's text and a chunk's number.

A worker needs this package, no files: it may be a thread, a process or another machine.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ...files import write_whole
from .buffers import own_room
from .chunk import solve, spec_of
from .rows_file import checksum, encode
from .statistics import Tally, tally_of

__all__ = ["Made", "count_rows", "file_of", "make_rows", "write_rows"]


@dataclass(frozen=True)
class Made:
    """Result of a chunk: counts by status, the checksum of its file, and that file where it is not written yet."""

    statuses: dict[str, int]
    checksum: str
    content: bytes | None = None


def file_of(number: int) -> str:
    """Return the name of the file of a chunk's rows; the names sort as the cases do."""
    return f"rows-{number:07d}.parquet"


def write_rows(text: str, folder: str, number: int) -> Made:
    """Solve the chunk `number` and write its rows, for workers that share the folder."""
    spec = spec_of(text)
    statuses, content = encode(spec, number, solve(spec, number, own_room()))
    write_whole(Path(folder) / file_of(number), [content])
    return Made(statuses, checksum(content))


def make_rows(text: str, number: int) -> Made:
    """Solve the chunk `number` and return the file of its rows."""
    spec = spec_of(text)
    statuses, content = encode(spec, number, solve(spec, number, own_room()))
    return Made(statuses, checksum(content), bytes(content))


def count_rows(text: str, ranges: Mapping[str, tuple[float, float]], number: int) -> Tally:
    """Solve the chunk `number` and return its statistics."""
    return tally_of(spec_of(text), number, ranges, own_room())
