"""Resumption of a sweep: completed chunks are kept, and the final files do not depend on interruptions."""

import json
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from ...errors import InputError, why
from ...files import csv_text, write_whole
from .lock import sole_writer
from .rows_file import label
from .scheduler import run
from .spec import SweepSpec, column
from .statistics import LISTED, Tally, pilot
from .worker import count_rows, file_of, make_rows, write_rows

__all__ = ["Workers", "claim", "keep_rows", "keep_statistics"]

Executors = Executor | Callable[[], Executor]
Progress = Callable[[int, int], None]
# seconds between two checkpoints of statistics
_CHECKPOINT = 2.0


class Workers:
    """Who solves: an executor or what makes one, how many units are under way, and whether it shares our folder."""

    def __init__(self, executor: Executors, in_flight: int, shares_folder: bool) -> None:
        self.executor = executor
        self.in_flight = in_flight
        self.shares_folder = shares_folder


@contextmanager
def claim(folder: Path, spec: SweepSpec) -> Iterator[None]:
    """Make the folder, or see that it is this sweep's, and keep others out; remove what a killed run left half done.

    Raises
    ------
    InputError : it holds another sweep, cannot be made, or another run writes it now.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({why(error)})") from None
    head = folder / "sweep.json"
    text = f"{spec.text}\n"
    with sole_writer(folder):
        if head.exists() and head.read_text(encoding="utf-8", errors="replace") != text:
            raise InputError(f"{folder}: holds another sweep (its sweep.json says which); give another folder")
        for name in ("rows-*.parquet", "sweep.json", "statistics.json", "summary.json", "failures.csv"):
            for left in folder.glob(f".{name}.*"):
                left.unlink()
        if not head.exists():
            write_whole(head, text)
        yield


def keep_rows(folder: Path, spec: SweepSpec, workers: Workers, progress: Progress) -> dict[str, Any]:
    """Solve every chunk whose file is missing; returns the summary."""
    todo: list[int] = []
    statuses, failing, done = Tally({}).statuses, list[int](), 0

    def note(number: int, found: Mapping[str, int]) -> None:
        nonlocal done
        for name, count in found.items():
            statuses[name] += count
        if found["converged"] < spec.rows(number):
            failing.append(number)
        done += spec.rows(number)

    for number in range(spec.chunks):
        there = _label(folder, spec, number)
        if there is None:
            todo.append(number)
        else:
            note(number, there["statuses"])
    progress(done, spec.cases)

    def take(number: int, made: dict[str, int] | tuple[dict[str, int], bytes]) -> None:
        if isinstance(made, tuple):
            made, content = made
            write_whole(folder / file_of(number), content)
        note(number, made)
        progress(done, spec.cases)

    unit = partial(write_rows, spec.text, str(folder)) if workers.shares_folder else partial(make_rows, spec.text)
    run(workers.executor, unit, todo, take, workers.in_flight)
    return _finish(folder, spec, statuses, _first_failures(folder, spec, sorted(failing)))


def keep_statistics(folder: Path, spec: SweepSpec, workers: Workers, progress: Progress) -> dict[str, Any]:
    """Solve every chunk from where the last checkpoint stands, adding up in their order; returns the summary."""
    path = folder / "statistics.json"
    ranges, total, first = _checkpoint(path, spec)
    waiting: dict[int, Tally] = {}
    following, written = first, time.monotonic()
    progress(min(first * spec.chunk, spec.cases), spec.cases)

    def take(number: int, part: Tally) -> None:
        nonlocal following, written
        waiting[number] = part
        while following in waiting:
            total.add(waiting.pop(following))
            following += 1
        if time.monotonic() - written > _CHECKPOINT:
            _write_checkpoint(path, spec, total, following)
            written = time.monotonic()
        progress(min(following * spec.chunk, spec.cases), spec.cases)

    unit = partial(count_rows, spec.text, ranges)
    run(workers.executor, unit, range(first, spec.chunks), take, workers.in_flight)
    _write_checkpoint(path, spec, total, following)
    return _finish(folder, spec, total.statuses, total.failures)


def _label(folder: Path, spec: SweepSpec, number: int) -> dict[str, Any] | None:
    """Return what the file of a chunk says about itself; None where it is missing or no whole one of this sweep."""
    path = folder / file_of(number)
    about = label(path) if path.exists() else None
    return about if about is not None and (about["sweep"], about["chunk"]) == (spec.digest, number) else None


def _first_failures(folder: Path, spec: SweepSpec, failing: list[int]) -> list[dict[str, Any]]:
    """Return the first failures, from the files of the chunks that have some."""
    listed: list[dict[str, Any]] = []
    for number in failing:
        if len(listed) == LISTED:
            break
        about = _label(folder, spec, number)
        if about is None:
            raise InputError(f"{folder / file_of(number)}: has vanished or changed; run the sweep again")
        listed += about["failures"][: LISTED - len(listed)]
    return listed


def _checkpoint(path: Path, spec: SweepSpec) -> tuple[dict[str, tuple[float, float]], Tally, int]:
    """Return ranges, statistics so far and the next chunk: from the file, or from the beginning."""
    if path.exists():
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            total = Tally.of_json(content)
            ranges = {name: (channel.low, channel.high) for name, channel in total.channels.items()}
            return ranges, total, int(content["chunks"])
        except (ValueError, KeyError, TypeError):
            pass  # damaged by something else than this program, which writes it whole: begin again
    ranges = pilot(spec)
    return ranges, Tally.empty(spec, ranges), 0


def _write_checkpoint(path: Path, spec: SweepSpec, total: Tally, chunks: int) -> None:
    write_whole(path, json.dumps({"sweep": spec.digest, "chunks": chunks, **total.json()}) + "\n")


def _finish(folder: Path, spec: SweepSpec, statuses: dict[str, int], failed: list[dict[str, Any]]) -> dict[str, Any]:
    """Write the list of failures and the summary."""
    names = ["case", "status", "load_factor", *(column(entry.name) for entry in spec.varied)]
    write_whole(folder / "failures.csv", csv_text({name: [case[name] for case in failed] for name in names}))
    summary = {"sweep": spec.digest, "cases": spec.cases, "statuses": statuses, "failures_listed": len(failed)}
    write_whole(folder / "summary.json", json.dumps(summary, indent=1) + "\n")
    return summary
