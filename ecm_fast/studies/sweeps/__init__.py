"""Sweeps: up to 1e9 solves over loads, parameters and effects, on one machine or a cluster.

The cases are cut into chunks; what a chunk is, and what comes of it, depends on the sweep and the chunk's number alone
(`design`, `chunk`, `units`). Any executor may therefore solve any chunk, twice if need be (`engine`), and a sweep that
was stopped goes on from the files that are there (`keeping`).
"""

import os
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from ...errors import InputError, shown
from .cluster import cluster
from .resume import Workers, claim, keep_rows, keep_statistics
from .rows_file import need_pyarrow
from .spec import SweepSpec
from .spec_file import read_spec

__all__ = ["Sweep", "SweepSpec", "read_spec", "sweep"]


@dataclass(frozen=True)
class Sweep:
    """A finished sweep.

    Attributes
    ----------
    folder : holds ``sweep.json`` (what was solved), ``summary.json``, ``failures.csv`` (the first 1000 cases without
        a stable equilibrium) and either ``rows-*.parquet`` or ``statistics.json``
    cases : how many
    statuses : how many cases ended with each status
    solved : how many of them this call solved; the others were there
    seconds : that it took
    """

    folder: Path
    cases: int
    statuses: Mapping[str, int]
    solved: int
    seconds: float = field(compare=False)

    @property
    def files(self) -> list[Path]:
        """The files of rows, in the order of cases; none where statistics were kept."""
        return sorted(self.folder.glob("rows-*.parquet"))

    def dataset(self) -> Any:
        """Return the rows as a pyarrow dataset, which reads no more than it is asked for."""
        from pyarrow import dataset

        return dataset.dataset(list(map(str, self.files)), format="parquet")

    def __repr__(self) -> str:
        kinds = ", ".join(f"{count} {name}" for name, count in self.statuses.items() if count)
        return f"Sweep({self.cases} cases: {kinds}; in {self.folder})"


def sweep(
    spec: SweepSpec | Mapping[str, Any] | str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    executor: Executor | Callable[[], Executor] | str | None = None,
    threads: int | None = None,
    in_flight: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Sweep:
    """Solve every case of a sweep and keep the rows, or statistics of them, in a folder.

    Stopped at any moment and called again it goes on, and ends with the same files; so it does whoever solves.

    Parameters
    ----------
    spec : a TOML file, a dict of the same form (see `read_spec`), or a `SweepSpec`
    out : the folder
    executor : who solves: an executor; or a function that makes one, so that a pool of processes that breaks is made
        anew; or the address of a scheduler of ``distributed``. Default: threads of this process. Workers elsewhere need
        this package and no files of ours
    threads : of this process; default one a core
    in_flight : how many chunks may be under way at an executor; default twice its workers
    progress : called here with how many cases are done, and how many there are

    Raises
    ------
    InputError : the sweep cannot be, the folder holds another one, or another run is writing it.
    """
    plan = spec if isinstance(spec, SweepSpec) else read_spec(spec)
    folder = Path(out)
    if plan.keep == "rows":
        need_pyarrow()
    done_before: list[int] = []

    def tell(done: int, cases: int) -> None:
        done_before.append(done)
        del done_before[1:]
        if progress is not None:
            progress(done, cases)

    start = time.perf_counter()
    keep = keep_rows if plan.keep == "rows" else keep_statistics
    with claim(folder, plan), _workers(executor, threads, in_flight) as workers:
        summary = keep(folder, plan, workers, tell)
    return Sweep(folder, plan.cases, summary["statuses"], plan.cases - done_before[0], time.perf_counter() - start)


@contextmanager
def _workers(
    executor: Executor | Callable[[], Executor] | str | None, threads: int | None, in_flight: int | None
) -> Iterator[Workers]:
    for name, value in (("threads", threads), ("in_flight", in_flight)):
        if value is not None and value < 1:
            raise InputError(f"{name} = {shown(value)}: allowed is a whole number from 1 up")
    if executor is not None and threads is not None:
        raise InputError("threads says how many threads of this process solve: with an executor leave it out")
    if executor is None:
        count = threads or _cores()
        yield Workers(partial(ThreadPoolExecutor, count), in_flight or 2 * count, shares_folder=True)
    elif isinstance(executor, str):
        with cluster(executor) as (pool, count):
            yield Workers(pool, in_flight or 2 * count, shares_folder=False)
    else:
        count = getattr(executor, "_max_workers", None) or _cores()
        yield Workers(executor, in_flight or 2 * count, shares_folder=False)


def _cores() -> int:
    affinity = getattr(os, "sched_getaffinity", None)  # not on every system
    return len(affinity(0)) if affinity is not None else os.cpu_count() or 1
