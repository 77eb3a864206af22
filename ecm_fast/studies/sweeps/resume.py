"""Resumption of a sweep: completed chunks are kept, and the final files do not depend on interruptions."""

import json
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from ...errors import InputError, why
from ...files import csv_text, refuse_input, write_whole
from .rows_file import checksum, label
from .scheduler import run
from .spec import SweepSpec, column
from .statistics import LISTED, Tally, pilot
from .worker import Made, count_rows, file_of, make_rows, write_rows

__all__ = ["Workers", "claim", "keep_rows", "keep_statistics"]

Executors = Executor | Callable[[], Executor]
Progress = Callable[[int, int], None]
# seconds between two checkpoints of statistics
_CHECKPOINT = 2.0
CHECKSUMS = "rows.sha256"
"""The checksums of the files of rows, for ``sha256sum --check`` too; a file counts as done once its line is here."""
_OWN = ("sweep.json", "statistics.json", "summary.json", "failures.csv", CHECKSUMS)


class Workers:
    """The executor of a sweep or its maker, how many units are under way, and whether it shares our folder."""

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
    for name in _OWN:
        refuse_input(folder / name)
    head = folder / "sweep.json"
    text = f"{spec.text}\n"
    with _sole_writer(folder):
        if head.exists() and head.read_text(encoding="utf-8", errors="replace") != text:
            raise InputError(f"{folder}: holds another sweep (its sweep.json says which); give another folder")
        for name in ("rows-*.parquet", *_OWN):
            for left in folder.glob(f".{name}.*"):
                left.unlink()
        if not head.exists():
            _remove_others(folder, spec)
            write_whole(head, text)
        yield


@contextmanager
def _sole_writer(folder: Path) -> Iterator[None]:
    """Keep every other run out of a folder; the operating system ends the lock with the process, however it ends."""
    lock = FileLock(folder / ".lock", timeout=0)
    try:
        lock.acquire()
    except Timeout:
        raise InputError(f"{folder}: another run is writing it; wait for its end, or give another folder") from None
    except OSError as error:
        raise InputError(f"{folder}: cannot be written here ({why(error)})") from None
    try:
        yield
    finally:
        lock.release()


def _remove_others(folder: Path, spec: SweepSpec) -> None:
    """Remove the rows of another sweep, whose ``sweep.json`` is gone: they must not be taken for this one's."""
    for path in folder.glob("rows-*.parquet"):
        about = label(path)
        if about is not None and about.get("sweep") != spec.digest:
            path.unlink()


def keep_rows(folder: Path, spec: SweepSpec, workers: Workers, progress: Progress) -> dict[str, Any]:
    """Solve every chunk whose file is missing; returns the summary."""
    todo, sums = list[int](), _checksums(folder)
    statuses, failing, done = Tally({}).statuses, list[int](), 0

    def note(number: int, counts: Mapping[str, int]) -> None:
        nonlocal done
        for name, count in counts.items():
            statuses[name] += count
        if counts["converged"] < spec.rows(number):
            failing.append(number)
        done += spec.rows(number)

    for number in range(spec.chunks):
        label = _label(folder, spec, number, sums)
        if label is None:
            todo.append(number)
        else:
            note(number, label["statuses"])
    progress(done, spec.cases)

    def take(number: int, made: Made) -> None:
        if made.content is not None:
            write_whole(folder / file_of(number), made.content)
        sums[file_of(number)] = made.checksum
        with (folder / CHECKSUMS).open("a", encoding="utf-8") as file:
            file.write(_line(file_of(number), made.checksum))
        note(number, made.statuses)
        progress(done, spec.cases)

    unit = partial(write_rows, spec.text, str(folder)) if workers.shares_folder else partial(make_rows, spec.text)
    run(workers.executor, unit, todo, take, workers.in_flight)
    listed = _first_failures(folder, spec, sorted(failing), sums)
    names = [file_of(number) for number in range(spec.chunks)]
    write_whole(folder / CHECKSUMS, "".join(_line(name, sums[name]) for name in names))
    return _finish(folder, spec, statuses, listed)


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


def _line(name: str, checksum: str) -> str:
    return f"{checksum}  {name}\n"


def _checksums(folder: Path) -> dict[str, str]:
    """Return the checksums that were noted, by the names of files; a line that is damaged fits no file."""
    try:
        text = (folder / CHECKSUMS).read_text(encoding="utf-8", errors="replace")
    except FileNotFoundError:
        return {}
    return {name: digest for digest, _, name in (line.partition("  ") for line in text.splitlines())}


def _label(folder: Path, spec: SweepSpec, number: int, sums: Mapping[str, str]) -> dict[str, Any] | None:
    """Return what the file of a chunk says about itself; None where it is missing, damaged, or none of this sweep."""
    path = folder / file_of(number)
    try:
        if checksum(path.read_bytes()) != sums.get(path.name):
            return None
    except FileNotFoundError:
        return None
    about = label(path)
    return about if about is not None and (about["sweep"], about["chunk"]) == (spec.digest, number) else None


def _first_failures(folder: Path, spec: SweepSpec, failing: list[int], sums: Mapping[str, str]) -> list[dict[str, Any]]:
    """Return the first failures, from the files of the chunks that have some."""
    listed: list[dict[str, Any]] = []
    for number in failing:
        if len(listed) == LISTED:
            break
        about = _label(folder, spec, number, sums)
        if about is None:
            raise InputError(f"{folder / file_of(number)}: has vanished or changed; run the sweep again")
        listed += about["failures"][: LISTED - len(listed)]
    return listed


def _checkpoint(path: Path, spec: SweepSpec) -> tuple[dict[str, tuple[float, float]], Tally, int]:
    """Return ranges, statistics so far and the next chunk: from the file, or from the beginning."""
    if path.exists():
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            noted = content.pop("sha256")
            if (content["sweep"], noted) == (spec.digest, checksum(json.dumps(content).encode())):
                total = Tally.from_json(content)
                ranges = {name: (channel.low, channel.high) for name, channel in total.channels.items()}
                return ranges, total, int(content["chunks"])
        except (ValueError, KeyError, TypeError, AttributeError):
            pass  # damaged by something else than this program, which writes it whole: begin again
    ranges = pilot(spec)
    return ranges, Tally.empty(spec, ranges), 0


def _write_checkpoint(path: Path, spec: SweepSpec, total: Tally, chunks: int) -> None:
    content = {"sweep": spec.digest, "chunks": chunks, **total.json()}
    digest = checksum(json.dumps(content).encode())
    write_whole(path, json.dumps({**content, "sha256": digest}) + "\n")


def _finish(folder: Path, spec: SweepSpec, statuses: dict[str, int], failed: list[dict[str, Any]]) -> dict[str, Any]:
    """Write the list of failures and the summary."""
    names = ["case", "status", "load_factor", *(column(entry.name) for entry in spec.varied)]
    write_whole(folder / "failures.csv", csv_text({name: [case[name] for case in failed] for name in names}))
    summary = {"sweep": spec.digest, "cases": spec.cases, "statuses": statuses, "failures_listed": len(failed)}
    write_whole(folder / "summary.json", json.dumps(summary, indent=1) + "\n")
    return summary
