"""Statistics of a sweep: histograms, extremes and moments, added chunk by chunk in order."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...kernels._jit import kernel
from ...models.equilibrium import Status
from .buffers import ScratchBuffers
from .chunk import Solved, solve
from .rows_file import failures
from .spec import OUTPUTS, SweepSpec, column

__all__ = ["LISTED", "Channel", "Tally", "pilot", "tally_of"]

LISTED = 1000
"""Most failed cases that a sweep lists with their inputs."""
# ranges of histograms are found from about this many cases, spread over the whole sweep
_PILOT = 4096


@dataclass
class Channel:
    """One column of the pose, over all stable equilibria.

    Attributes
    ----------
    low, high : ends of the histogram
    counts : (bins + 2,) how many are below, in each bin, above
    sums : how many, mean, sums of squares, cubes and fourth powers of the distances from the mean
    least, most : the extreme values with the inputs that give them; None where no case is stable
    """

    low: float
    high: float
    counts: NDArray[np.int64]
    sums: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0)
    least: dict[str, float] | None = None
    most: dict[str, float] | None = None

    def add(self, other: "Channel") -> None:
        """Take the cases of a later chunk in."""
        self.counts += other.counts
        self.sums = _together(self.sums, other.sums)
        if other.least is not None and (self.least is None or other.least["value"] < self.least["value"]):
            self.least = other.least
        if other.most is not None and (self.most is None or other.most["value"] > self.most["value"]):
            self.most = other.most

    @property
    def moments(self) -> dict[str, float | None]:
        """Mean, standard deviation, skewness and excess kurtosis; None where they are not defined."""
        n, mean, second, third, fourth = self.sums
        if n == 0:
            return dict.fromkeys(("mean", "std", "skewness", "kurtosis"))
        spread = second > 0.0
        return {
            "mean": mean,
            "std": math.sqrt(second / (n - 1)) if n > 1 else None,
            "skewness": math.sqrt(n) * third / second**1.5 if spread else None,
            "kurtosis": n * fourth / second**2 - 3.0 if spread else None,
        }

    def json(self) -> dict[str, Any]:
        """Return it as a file holds it."""
        return {
            "low": self.low,
            "high": self.high,
            "counts": self.counts.tolist(),
            "sums": list(self.sums),
            "least": self.least,
            "most": self.most,
            "moments": self.moments,
        }

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> "Channel":
        """Return what `json` wrote."""
        given = {name: content[name] for name in ("low", "high", "least", "most")}
        return cls(**given, counts=np.array(content["counts"], dtype=np.int64), sums=tuple(content["sums"]))


@dataclass
class Tally:
    """Statistics of the cases so far: counts by status, the first failures with their inputs, channels of the pose."""

    channels: dict[str, Channel]
    statuses: dict[str, int] = field(default_factory=lambda: {status.name.lower(): 0 for status in Status})
    failures: list[dict[str, Any]] = field(default_factory=list)

    @classmethod
    def empty(cls, spec: SweepSpec, ranges: Mapping[str, tuple[float, float]]) -> "Tally":
        """Return statistics of no cases."""
        return cls({name: Channel(*ranges[name], np.zeros(spec.bins + 2, dtype=np.int64)) for name in OUTPUTS})

    def add(self, other: "Tally") -> None:
        """Take the cases of a later chunk in."""
        for name, channel in self.channels.items():
            channel.add(other.channels[name])
        for name, count in other.statuses.items():
            self.statuses[name] += count
        self.failures += other.failures[: LISTED - len(self.failures)]

    def json(self) -> dict[str, Any]:
        """Return it as a file holds it."""
        channels = {name: channel.json() for name, channel in self.channels.items()}
        return {"statuses": self.statuses, "failures": self.failures, "channels": channels}

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> "Tally":
        """Return what `json` wrote."""
        channels = {name: Channel.from_json(channel) for name, channel in content["channels"].items()}
        return cls(channels, dict(content["statuses"]), list(content["failures"]))

    def __repr__(self) -> str:
        return f"Tally({sum(self.statuses.values())} cases, {self.statuses['converged']} stable)"


def tally_of(spec: SweepSpec, number: int, ranges: Mapping[str, tuple[float, float]], room: ScratchBuffers) -> Tally:
    """Return the statistics of the chunk `number`, whose cases are solved in a room."""
    solved = solve(spec, number, room)
    found = Tally.empty(spec, ranges)
    places, sums = np.empty(2, dtype=np.int64), np.empty(5)
    for name, values in _outputs(solved).items():
        channel = found.channels[name]
        per_unit = spec.bins / (channel.high - channel.low)
        tally(values, solved.result.status, channel.low, per_unit, channel.counts, places, sums)
        channel.sums = tuple(sums.tolist())
        if places[0] >= 0:
            channel.least, channel.most = (_case(spec, number, solved, values, int(row)) for row in places)
    found.statuses = solved.result.counts()
    found.failures = failures(spec, number, solved)
    return found


def pilot(spec: SweepSpec) -> dict[str, tuple[float, float]]:
    """Return the ranges of the histograms: those given, else what a few cases from all over the sweep span.

    Raises
    ------
    InputError : none of these cases has a stable equilibrium, so that nothing says where a histogram should lie.
    """
    ranges = {name: (low, high) for name, low, high in spec.ranges}
    missing = [name for name in OUTPUTS if name not in ranges]
    if not missing:
        return ranges
    numbers = sorted({round(share * (spec.chunks - 1)) for share in np.linspace(0.0, 1.0, 4)})
    stride, room = max(1, len(numbers) * spec.rows(0) // _PILOT), ScratchBuffers()
    stable: dict[str, list[NDArray[np.float64]]] = {name: [] for name in missing}
    for number in numbers:
        part = solve(spec, number, room, stride=stride)
        for name in missing:
            stable[name].append(_outputs(part)[name][part.result.stable])
    for name in missing:
        seen = np.concatenate(stable[name])
        if not seen.size:
            raise InputError(f"no case tried is stable: lower the loads, or give statistics.{name} = [from, to]")
        low, high = float(seen.min()), float(seen.max())
        margin = 0.05 * (high - low) or 1e-6
        ranges[name] = low - margin, high + margin
    return ranges


def _outputs(solved: Solved) -> dict[str, NDArray[np.float64]]:
    return dict(zip(OUTPUTS, (solved.result.x, solved.result.z, solved.result.theta), strict=True))


def _case(spec: SweepSpec, number: int, solved: Solved, values: NDArray[np.float64], row: int) -> dict[str, float]:
    inputs = {column(name): float(drawn[row]) for name, drawn in solved.inputs.items()}
    return {"value": float(values[row]), "case": number * spec.chunk + row, **inputs}


def _together(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, ...]:
    """Return the sums of two sets of values as those of one (Pebay, Sandia report SAND2008-6212)."""
    (na, ma, a2, a3, a4), (nb, mb, b2, b3, b4) = a, b
    if na == 0 or nb == 0:
        return a if nb == 0 else b
    n, d = na + nb, mb - ma
    s, r = d / n, na * nb
    return (
        n,
        ma + nb * s,
        a2 + b2 + r * d * s,
        a3 + b3 + r * (na - nb) * d * s * s + 3.0 * s * (na * b2 - nb * a2),
        a4
        + b4
        + r * (na * na - r + nb * nb) * d * s**3
        + 6.0 * s * s * (na * na * b2 + nb * nb * a2)
        + 4.0 * s * (na * b3 - nb * a3),
    )


@kernel
def tally(values: Any, status: Any, low: float, per_unit: float, counts: Any, places: Any, sums: Any) -> None:
    """Count and sum the values of the cases whose status is 0.

    values, status : (n,)
    low, per_unit : where the histogram begins, bins by unit of the value
    counts : (bins + 2,)   added to: below, the bins, above
    places : (2,)   overwritten: the rows of the least and the largest value, -1 where there is none
    sums : (5,)   overwritten: how many, mean, sums of the squares, cubes and fourth powers of the distances from it
    """
    n, total, least, most, last = 0, 0.0, 0.0, 0.0, counts.shape[0] - 1
    places[0], places[1] = -1, -1
    for i in range(values.shape[0]):
        if status[i] == 0:
            value = values[i]
            if n == 0 or value < least:
                least, places[0] = value, i
            if n == 0 or value > most:
                most, places[1] = value, i
            n += 1
            total += value
            place = (value - low) * per_unit + 1.0
            counts[int(min(max(place, 0.0), last))] += 1
    mean = total / n if n > 0 else 0.0
    second, third, fourth = 0.0, 0.0, 0.0
    for i in range(values.shape[0]):
        away = values[i] - mean if status[i] == 0 else 0.0
        square = away * away
        second += square
        third += square * away
        fourth += square * square
    sums[0], sums[1], sums[2], sums[3], sums[4] = n, mean, second, third, fourth
