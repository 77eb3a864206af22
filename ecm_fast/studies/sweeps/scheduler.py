"""The scheduler of a sweep: a bounded number of chunks in flight on any executor, with retries."""

from collections import Counter, deque
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from typing import Any

from ...errors import EcmError

__all__ = ["TRIES", "run"]

TRIES = 4
"""Trials of a unit of work before its error is passed on: a worker may be lost, or its machine."""


def run(
    executor: Executor | Callable[[], Executor],
    unit: Callable[[int], Any],
    numbers: Iterable[int],
    take: Callable[[int, Any], None],
    in_flight: int,
) -> None:
    """Call `unit` with every number on the executor, and `take` with each number and what came of it, here.

    Parameters
    ----------
    executor : or a function that makes one; a pool that breaks with a worker is then made anew
    unit : what the executor can send to its workers, pure: it may be called again with the same number
    take : called in the order in which units end
    in_flight : how many units may be submitted and not taken
    """
    make = None if isinstance(executor, Executor) else executor
    pool: Executor = executor if make is None else make()  # type: ignore[assignment]  # no executor: a function
    todo, running, restarts = deque(numbers), dict[Future[Any], int](), 0
    tried = Counter[int]()
    try:
        while todo or running:
            broken = _submit(pool, unit, todo, running, in_flight)
            for future in wait(running, return_when=FIRST_COMPLETED).done if running else ():
                number = running.pop(future)
                try:
                    result = future.result()
                except (EcmError, KeyboardInterrupt):
                    raise
                except BrokenExecutor as error:
                    broken = error
                    todo.appendleft(number)
                except BaseException:
                    tried[number] += 1
                    if tried[number] >= TRIES:
                        raise
                    todo.appendleft(number)
                else:
                    take(number, result)
                    restarts = 0
            if broken is not None:
                restarts += 1
                if make is None or restarts > TRIES:
                    raise broken
                pool.shutdown(wait=False, cancel_futures=True)
                todo.extendleft(running.values())
                running, pool = {}, make()
    finally:
        for future in running:
            future.cancel()
        if make is not None:
            pool.shutdown(wait=True, cancel_futures=True)


def _submit(
    pool: Executor, unit: Callable[[int], Any], todo: deque[int], running: dict[Future[Any], int], in_flight: int
) -> BrokenExecutor | None:
    """Submit as many units as may be under way; returns what a pool says that has lost a worker and takes no more."""
    while todo and len(running) < in_flight:
        try:
            running[pool.submit(unit, todo[0])] = todo[0]
        except BrokenExecutor as error:
            return error
        todo.popleft()
    return None
