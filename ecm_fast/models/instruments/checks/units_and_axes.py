"""Units, signs, swapped columns and origins: the fewest changes of columns with which a model explains all readings.

Every change is judged on all columns together, with EA, GA and EI calibrated anew: forces in another unit bend the neck
as another unit of z would, and a wrong EA shifts x as another origin would. A change is advised only where it explains
every channel and no change does not.
"""

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ....data.columns import CHANNELS
from ....data.measurements import Measurements
from ....mechanism.mechanism import Mechanism
from ....mechanism.sections import STIFFNESSES
from .calibration import Calibration, calibrate

__all__ = ["Change", "Explanation", "LabelSearch"]

Array = NDArray[np.float64]

_ROWS = 40
"""Rows of each kind of load that are looked at, evenly over the order of measurement: a label is wrong in all."""
_FEWEST = 5  # readings of a channel below which its label is not judged
_GOOD = 0.35
"""Misfit up to which a channel counts as explained. Effects of twice their typical size leave up to 0.2, calibrated."""
_STRAY = 1.0  # the same of the tenth of the readings that fit worst: a change that half of the rows need is none
_MOSTLY = 0.3  # share of the rows with an equilibrium from which on these alone judge the labels
_POOR = 3.0  # misfit that says no more than that nothing fits
_TAIL = 0.2  # weight of the tenth of the readings that fit worst beside the half that fits best
_PRICE = 0.1  # misfit that each change must take off
_STRETCH, _STRETCH_PRICE = math.log(1.5), 0.15
"""Ratio up to which calibration may move a stiffness for nothing, and the price of each factor e beyond it."""
_CHANGES = 3  # columns that may be wrong at once
_KEPT = 2  # explanations that the search goes on from

_UNITS: Mapping[str, tuple[float, ...]] = {
    "length": (1e-3, 1e-2, 0.1, 10.0, 1e2, 1e3, 1e-6, 0.0254, 1.0 / 25.4),
    "angle": (math.pi / 180.0, 1e-3, 180.0 / math.pi, 1e3),
    "force": (9.80665, 4.4482216152605, 1e3, 1e-3, 9.80665e-3, 1.0 / 9.80665),
    "couple": (1e-3, 1e3, 9.80665e-3, 1.0 / 9.80665),
    "mass": (1e-3,),
}
"""Factors by which columns of a kind are taken for something else: of millimetres, degrees, kilograms-force, ..."""
_KIND = {"x": "length", "z": "length", "theta": "angle", "lam_l": "force", "lam_r": "force", "fx": "force",
         "fz": "force", "tau": "couple", "extra_mass": "mass", "tilt": "angle"}  # fmt: skip


@dataclass(frozen=True)
class Change:
    """Reading of columns otherwise than they are labelled.

    Attributes
    ----------
    kind : unit, sign, swap or origin
    columns : quantities that it concerns
    factor : what a unit multiplies the values by
    """

    kind: str
    columns: tuple[str, ...]
    factor: float = 1.0

    def read(self, data: Measurements) -> Measurements:
        """Return measurements that are read in this way; an origin is found by calibration."""
        if self.kind == "swap":
            one, other = self.columns
            changed = {one: getattr(data, other), other: getattr(data, one)}
        else:
            by = -1.0 if self.kind == "sign" else self.factor
            changed = {name: by * getattr(data, name) for name in self.columns}
        return replace(data, **changed)


@dataclass(frozen=True, eq=False)
class Explanation:
    """A set of changes, and what it leaves.

    Attributes
    ----------
    changes : of columns
    calibration : of the model to what is then read
    misfit : by channel, the median size of the residual over that of the readings' own movement, and the same of the
        tenth that fits worst
    price : of misfit and changes together
    """

    changes: tuple[Change, ...]
    calibration: Calibration
    misfit: dict[str, tuple[float, float]]
    price: float

    def explained(self, name: str) -> bool:
        """Whether a channel is explained."""
        usual, worst = self.misfit[name]
        return usual <= _GOOD and worst <= _STRAY

    @property
    def good(self) -> bool:
        """Whether every channel is explained."""
        return all(map(self.explained, self.misfit))


class LabelSearch:
    """The search for the cheapest explanation."""

    def __init__(self, mechanism: Mechanism, data: Measurements, unknown: Collection[str]) -> None:
        kept = np.flatnonzero(data.measured.any(axis=1))
        of_kinds = [kept[place[_evenly(place.size, _ROWS)]] for place in _kinds(data.select(kept))]
        self.rows = np.unique(np.concatenate([kept[:0], *of_kinds]))
        self.mechanism, self.data, self.unknown = mechanism, data, unknown
        counts = data.measured[self.rows].sum(axis=0)
        self.channels = [name for name, count in zip(CHANNELS, counts, strict=True) if count >= _FEWEST]
        self.kinds = [place for place in _kinds(data.select(self.rows)) if place.size >= _FEWEST]
        self.plain = self._judged(())

    def best(self) -> Explanation:
        """Return the cheapest explanation."""
        front, best = [self.plain], self.plain
        moved = dict(zip(STIFFNESSES, np.abs(self.plain.calibration.moved).tolist(), strict=True))
        if self.plain.good and max(moved["EA"], moved["EI"]) < _STRETCH:  # these loads may hardly fix GA
            return self.plain
        if self._carried():
            return self.plain
        every = list(_changes(self.data, self.channels))
        for _ in range(_CHANGES):
            tried = [
                self._judged((*known.changes, change)) for known in front for change in self._further(known, every)
            ]
            front = sorted([*front, *tried], key=lambda entry: entry.price)[:_KEPT]
            if front[0].price >= best.price:
                break
            best = front[0]
            if best.good:
                break
        return best

    def _carried(self) -> bool:
        """Whether the readings as they are labelled are explained in all rows with an equilibrium, a good part of all.

        What the others lack is stability, as a strip in tension whose law gives way in shear: no label is at fault.
        """
        found = self.plain.calibration
        stable = np.isfinite(found.pose[:, 0])
        if stable.all() or stable.mean() < _MOSTLY:
            return False
        read, off = self.data.pose[self.rows][stable], np.abs(found.residual[stable])
        places = [CHANNELS.index(name) for name in self.channels]
        return all(np.nanquantile(off[:, i], 0.9) <= _GOOD * _spread(read[:, i]) for i in places)

    def _further(self, known: Explanation, every: list[Change]) -> Iterator[Change]:
        """Yield the changes that may add to an explanation: of columns not changed yet, and of no channel explained."""
        touched = {(change.kind, name) for change in known.changes for name in change.columns}
        for change in every:
            explained = all(name in known.misfit and known.explained(name) for name in change.columns)
            if not explained and not any((change.kind, name) in touched for name in change.columns):
                yield change

    def _judged(self, changes: tuple[Change, ...]) -> Explanation:
        data = self.data
        for change in changes:
            data = change.read(data)
        free = [CHANNELS.index(name) for change in changes if change.kind == "origin" for name in change.columns]
        found = calibrate(self.mechanism, data, self.rows, unknown=self.unknown, free=free)
        price, misfit = _PRICE * len(changes), dict[str, tuple[float, float]]()
        for name in self.channels:
            usual, worst = misfit[name] = self._misfit(CHANNELS.index(name), data, found)
            price += min(usual, _POOR) + _TAIL * min(worst, _POOR)
        price += _POOR * float(np.isnan(found.pose[:, 0]).mean())
        given = [name not in self.unknown for name in found.stiffnesses]
        price += _STRETCH_PRICE * float(np.maximum(np.abs(found.moved[given]) - _STRETCH, 0.0).sum())
        return Explanation(changes, found, misfit, price)

    def _misfit(self, channel: int, data: Measurements, found: Calibration) -> tuple[float, float]:
        """Return the misfit of half of the readings and of all but a tenth, in the kind of load that fits worst."""
        length, largest = self.mechanism.beam.length, (0.0, 0.0)
        floor = (max(0.01 * length, 5e-4), max(0.003 * length, 5e-4), 0.005)[channel]
        read, off = data.pose[self.rows, channel], np.abs(found.residual[:, channel])
        moved = max(_spread(read), floor)
        for rows in self.kinds:
            known = rows[np.isfinite(read[rows])]
            if known.size >= _FEWEST:
                size = np.nan_to_num(off[known], nan=np.inf) / max(moved, _spread(read[known]))
                usual, worst = (float(np.quantile(size, share, method="lower")) for share in (0.5, 0.9))
                largest = max(largest[0], usual), max(largest[1], worst)
        return largest


def _spread(values: Array) -> float:
    """Return the median distance of what is known of values from their median."""
    known = values[np.isfinite(values)]
    return float(np.median(np.abs(known - np.median(known))))


def _kinds(data: Measurements) -> Iterator[NDArray[np.int64]]:
    """Yield the places of rows with each kind of load, and of those with tendon forces alone."""
    kinds = [getattr(data, name) != 0.0 for name in ("fx", "fz", "tau", "tilt", "extra_mass")]
    yield from (np.flatnonzero(kind) for kind in (*kinds, ~np.any(kinds, axis=0)))


def _evenly(count: int, most: int) -> NDArray[np.int64]:
    """Return at most so many places of `count`, evenly spaced."""
    return np.unique(np.linspace(0, count - 1, min(most, count)).astype(np.int64))


def _changes(data: Measurements, channels: Collection[str]) -> Iterator[Change]:
    """Yield what may be wrong with a column, or with two at once."""
    loads = [name for name in ("lam_l", "lam_r", "fx", "fz", "tau", "tilt", "extra_mass") if getattr(data, name).any()]
    if {"lam_l", "lam_r"} & {*loads}:
        both = tuple(name for name in ("lam_l", "lam_r") if name in loads)
        yield from (Change("unit", both, factor) for factor in _UNITS["force"])
        yield Change("swap", ("lam_l", "lam_r"))
    if {"x", "z"} <= {*channels}:
        yield Change("swap", ("x", "z"))
    if {"z", "theta"} <= {*channels}:
        yield Change("sign", ("z", "theta"))  # z to the other side turns the angle, too
    for name in (*channels, *loads):
        yield from (Change("unit", (name,), factor) for factor in _UNITS[_KIND[name]])
        if name not in ("lam_l", "lam_r", "extra_mass"):
            yield Change("sign", (name,))
        if name in channels:
            yield Change("origin", (name,))
    if {"fx", "fz"} & {*loads}:
        yield Change("swap", ("fx", "fz"))
