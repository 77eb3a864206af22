"""Timing: short repetitions of all alternatives in turn, the minimum of each, less an empty call.

Other work on a machine, and the clock of its processor, change times by a factor of two within seconds. What is
compared is therefore measured in turn (A, B, A, B) within one run, in repetitions too short to be interrupted often;
the shortest of them is what the work takes where nothing disturbs it. Every way is called before it is timed, so that
no compilation and no cold memory is counted.
"""

import math
import os
import platform
import statistics
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from itertools import repeat
from pathlib import Path
from typing import Any

from ..pages.plots import shown_time

__all__ = ["EMPTY", "Timing", "each_in_turn", "in_turn", "machine", "nothing"]

EMPTY = "a call that does nothing"
"""Name under which the control is found among the timings."""

Clock = Callable[[], float]
_MOST_CALLS = 1 << 16  # calls in one repetition: a call of 10 ns then lasts 0.7 ms, far above the clock's resolution


@dataclass(frozen=True)
class Timing:
    """Time that one way takes.

    Attributes
    ----------
    best, median : shortest and middle time of one call over the repetitions [s]
    repetitions : how many there were
    calls : how many calls one repetition made
    cases : how many cases one call solves
    """

    best: float
    median: float
    repetitions: int
    calls: int
    cases: int = 1

    @property
    def per_case(self) -> float:
        """The shortest time of one case [s]."""
        return self.best / self.cases

    def __truediv__(self, other: "Timing") -> float:
        """Return how many times as long as `other` this takes, case by case."""
        return self.per_case / other.per_case

    def __repr__(self) -> str:
        how = f"best of {self.repetitions} repetitions of {self.calls} calls"
        cases = "" if self.cases == 1 else f", each of {self.cases} cases"
        return f"<Timing: {shown_time(self.per_case)} a case, {how}{cases}>"


def nothing(*args: object) -> None:
    """Do nothing: what is measured of it is the price of measuring."""


def in_turn(
    ways: Mapping[str, Callable[[], object]],
    *,
    cases: Mapping[str, int] | None = None,
    seconds: float = 0.3,
    shortest: float = 2e-4,
    clock: Clock = time.perf_counter,
) -> dict[str, Timing]:
    """Time calls without arguments; the control is added under the name `EMPTY`.

    Parameters
    ----------
    ways : what is compared, by name
    cases : how many cases one call of a way solves; where a name is missing, one
    seconds : how long each way is repeated in all, but at least three times
    shortest : calls are repeated until a repetition takes so long [s]
    clock : in seconds
    """
    all_ways = {**ways, EMPTY: nothing}
    calls = {name: _warm_up(way, shortest, clock) for name, way in all_ways.items()}
    times: dict[str, list[float]] = {name: [] for name in all_ways}
    spent = dict.fromkeys(all_ways, 0.0)
    left = list(ways)
    while left:
        for name in (*left, EMPTY):
            took = _repetition(all_ways[name], calls[name], clock)
            spent[name] += took
            times[name].append(took / calls[name])
        left = [name for name in left if spent[name] < seconds or len(times[name]) < 3]
    many = {} if cases is None else cases
    return {
        name: Timing(min(measured), statistics.median(measured), len(measured), calls[name], many.get(name, 1))
        for name, measured in times.items()
    }


def each_in_turn(
    ways: Mapping[str, tuple[Callable[..., object], Sequence[Sequence[Any]]]],
    *,
    rounds: Mapping[str, int],
    clock: Clock = time.perf_counter,
) -> dict[str, list[float]]:
    """Time every call of a series on its own: the shortest time of each, over the rounds [s].

    Parameters
    ----------
    ways : by name, a function and the arguments of its calls, one tuple a call; a round makes them all, in order
    rounds : how often each way is repeated, after one call that is not timed
    clock : in seconds; reading it is part of every time, and all of that of `nothing`
    """
    best = {name: [math.inf] * len(arguments) for name, (_, arguments) in ways.items()}
    for way, arguments in ways.values():
        way(*arguments[0])
    for i in range(max(rounds.values())):
        for name, (way, arguments) in ways.items():
            if i < rounds[name]:
                shortest = best[name]
                for k, args in enumerate(arguments):
                    start = clock()
                    way(*args)
                    shortest[k] = min(shortest[k], clock() - start)
    return best


def _warm_up(way: Callable[[], object], shortest: float, clock: Clock) -> int:
    """Call a way for the first time, and return how many calls make a repetition."""
    way()
    calls = 1
    while calls < _MOST_CALLS and _repetition(way, calls, clock) < shortest:
        calls *= 2
    return calls


def _repetition(way: Callable[[], object], calls: int, clock: Clock) -> float:
    start = clock()
    for _ in repeat(None, calls):
        way()
    return clock() - start


def machine() -> dict[str, Any]:
    """Return what times depend on: processor, cores, load, versions."""
    load = os.getloadavg() if hasattr(os, "getloadavg") else (float("nan"),)
    names = ("numba", "llvmlite", "numpy", "scipy")
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "load": round(load[0], 2),
        "python": platform.python_version(),
        **{name: _version(name) for name in names},
    }


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _processor() -> str:
    """Return the processor's name, where the system tells it."""
    if sys.platform == "linux":
        try:
            lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        except OSError:
            lines = []
        for line in lines:
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()
