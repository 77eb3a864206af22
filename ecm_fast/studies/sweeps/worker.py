"""The functions that run on a worker: arguments are a sweep's text and a chunk's number.

A worker needs this package, no files: it may be a thread, a process or another machine.
"""

from collections.abc import Mapping
from pathlib import Path

from ...files import write_whole
from .buffers import own_room
from .chunk import solve, spec_of
from .rows_file import encode
from .statistics import Tally, tally_of

__all__ = ["count_rows", "file_of", "make_rows", "write_rows"]


def file_of(number: int) -> str:
    """Return the name of the file of a chunk's rows; the names sort as the cases do."""
    return f"rows-{number:07d}.parquet"


def write_rows(text: str, folder: str, number: int) -> dict[str, int]:
    """Solve the chunk `number` and write its rows, for workers that share the folder; returns counts by status."""
    spec = spec_of(text)
    statuses, parts = encode(spec, number, solve(spec, number, own_room()))
    write_whole(Path(folder) / file_of(number), parts)
    return statuses


def make_rows(text: str, number: int) -> tuple[dict[str, int], bytes]:
    """Solve the chunk `number`; returns counts by status and the file of its rows."""
    spec = spec_of(text)
    statuses, parts = encode(spec, number, solve(spec, number, own_room()))
    return statuses, b"".join(parts)


def count_rows(text: str, ranges: Mapping[str, tuple[float, float]], number: int) -> Tally:
    """Solve the chunk `number` and return its statistics."""
    return tally_of(spec_of(text), number, ranges, own_room())
