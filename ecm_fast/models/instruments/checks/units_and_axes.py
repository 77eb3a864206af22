"""Units, signs, swapped columns and origins: the fewest changes of columns with which a model explains all readings.

Every change is judged on all columns together, with EA, GA and EI calibrated anew: forces in another unit bend the neck
as another unit of z would, and a wrong EA shifts x as another origin would. A change is advised only where it explains
every channel and no change does not.
"""

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....data.columns import CAMERA_SIGMA, CHANNELS, COLUMNS, match
from ....data.measurements import Measurements
from ....mechanism.mechanism import Mechanism
from ....mechanism.mesh.discretization import Discretization
from ....mechanism.sections import STIFFNESSES
from ....mechanism.vector import pack
from ...loads import last_step
from ..measuring_chain import MeasuringChain
from .calibration import Calibration, calibrate
from .finding import Finding

__all__ = ["label_findings"]

Array = NDArray[np.float64]

_ROWS = 40
"""Rows of each kind of load that are looked at, evenly over the order of measurement: a label is wrong in all."""
_FEWEST = 5  # readings of a channel below which its label is not judged
_GOOD = 0.35
"""Misfit up to which a channel counts as explained. Effects of twice their typical size leave up to 0.2, calibrated."""
_OFF = 1.0  # misfit from which on it is said that nothing explains a channel: more than its readings vary
_STRAY = 1.0  # the same of the tenth of the readings that fit worst: a change that half of the rows need is none
_MOSTLY = 0.3  # share of the rows with an equilibrium from which on these alone judge the labels
_POOR = 3.0  # misfit that says no more than that nothing fits
_TAIL = 0.2  # weight of the tenth of the readings that fit worst beside the half that fits best
_PRICE = 0.1  # misfit that each change must take off
_STRETCH, _STRETCH_PRICE = math.log(1.5), 0.15
"""Ratio up to which calibration may move a stiffness for nothing, and the price of each factor e beyond it."""
_BETTER = 0.6  # share of the price without any change that changes may have; a wrong label leaves a tenth, or half
_CHANGES = 3  # columns that may be wrong at once
_KEPT = 2  # explanations that the search goes on from
_FAR = (0.05, 0.2)
"""An origin beyond this share of the length, or this angle [rad], is not that of a camera that was set up a bit off."""
_CERTAIN_ORIGIN = 4.0  # standard deviations within which an origin is taken for one that has a name
_CAMERA = (3e-3, 3e-3, 0.03)  # [m, m, rad] origins up to here are effects of the catalogue: the search judges them

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
_WORDS = {"mm": "millimetres", "cm": "centimetres", "m": "metres", "um": "micrometres", "deg": "degrees",
          "in": "inches", "rad": "radians", "mrad": "milliradians"}  # fmt: skip


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

    def of(self, data: Measurements) -> Measurements:
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


def label_findings(mechanism: Mechanism, data: Measurements, unknown: Collection[str] = ()) -> list[Finding]:
    """Return what the labels of the columns get wrong, the most telling first.

    unknown : stiffnesses of which not even the order of magnitude is known
    """
    search = _Search(mechanism, data, unknown)
    if not search.channels:
        return []
    return _Words(mechanism, data, search.best()).findings(search.plain)


class _Search:
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
            data = change.of(data)
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
        for here in self.kinds:
            known = here[np.isfinite(read[here])]
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


class _Words:
    """An explanation in words, with its cures."""

    def __init__(self, mechanism: Mechanism, data: Measurements, best: Explanation) -> None:
        self.mechanism, self.data, self.best = mechanism, data, best
        self.names = {
            column.name: (name, unit)
            for name, (column, unit) in zip(data.columns, match(data.columns), strict=True)
            if unit
        }

    def findings(self, plain: Explanation) -> list[Finding]:
        """Return one finding for every change, where they explain all, else what is not explained."""
        if self.best.changes and self.best.good and self.best.price < _BETTER * plain.price:
            changes = sorted(self.best.changes, key=lambda change: change.kind == "origin")
            return [finding for change in changes for finding in self._of(change)]
        return [self._unexplained(name, usual) for name, (usual, _) in plain.misfit.items() if usual > _OFF]

    def _of(self, change: Change) -> list[Finding]:
        if change.kind == "sign" and len(change.columns) > 1 and not self._beside_tendons():
            return [self._swap(Change("swap", ("lam_l", "lam_r")))]
        if change.kind == "sign":
            return [self._sign(name) for name in change.columns]
        if change.kind == "origin":
            return self._origin(change.columns[0])
        return [self._unit(change) if change.kind == "unit" else self._swap(change)]

    def _named(self, name: str) -> tuple[str, str]:
        """Return the column of a quantity in the file, and its unit."""
        return self.names.get(name, (COLUMNS[name].names[0], next(iter(COLUMNS[name].units))))

    def _unit(self, change: Change) -> Finding:
        columns, unit = [self._named(name)[0] for name in change.columns], self._named(change.columns[0])[1]
        units = COLUMNS[change.columns[0]].units
        true = _scale(units, unit) * change.factor
        held = next((other for other in units if math.isclose(_scale(units, other), true, rel_tol=1e-4)), "")
        labels = " and ".join(f"{name}_{held}" for name in change.columns)
        label = f"label {'them' if columns[1:] else 'it'} {labels}"
        if change.columns[0] in CHANNELS:
            sentence, factor = self._pose_off(change.columns[0], columns[0], unit), 1.0 / change.factor
            if not held:
                return Finding("unit", (), sentence, f"the column is {factor:.4g} times too large", True)
            return Finding("unit", (), sentence, f"the column holds {_WORDS[held]}; {label}", True)
        largest = max(float(np.abs(getattr(self.data, name)).max(initial=0.0)) for name in change.columns)
        si = next(iter(units))
        sentence = f"{', '.join(columns)}: the neck bends as under {change.factor:.4g} times these readings, up to "
        sentence += f"{change.factor * largest:.3g} {si} instead of {largest:.3g} {si}"
        many = "the columns hold" if columns[1:] else "the column holds"
        times = f"multiply {'them' if columns[1:] else 'it'} by {change.factor:.6g}"
        cure = f"{many} {held}; {label}" if held else times
        return Finding("unit", (), sentence, cure, True)

    def _pose_off(self, name: str, column: str, unit: str) -> str:
        """Return what a channel reads beside what the model says, in the column's unit."""
        scale, channel = _scale(COLUMNS[name].units, unit), CHANNELS.index(name)
        read, model = getattr(self.data, name), self.best.calibration.pose[:, channel]
        what = "median" if name == "x" else "largest size"
        seen, says = (_typical(name, values) / scale for values in (read, model))
        return f"{column}: the {what} is {seen:.3g} where the model says {says:.3g}"

    def _sign(self, name: str) -> Finding:
        column = self._named(name)[0]
        cure = f"turn the sign of {column}"
        if name in CHANNELS:
            cure += ": a stronger left tendon gives z > 0 and theta < 0, and x grows from the clamp to the head"
        else:
            cure += ": fx, fz and tau are positive along x, z and with theta"
        return Finding("mirrored", (), f"{column}: its sign is the opposite of the model's", cure, True)

    def _swap(self, change: Change) -> Finding:
        one, other = (self._named(name)[0] for name in change.columns)
        if change.columns != ("lam_l", "lam_r"):
            sentence = f"{one}, {other}: each holds what the model says of the other one"
            return Finding("swapped", (), sentence, f"exchange the columns {one} and {other}", True)
        told_apart = self._beside_tendons()
        mirror = (
            "" if told_apart else ", or mirror both z and theta: with tendon loads alone the two cannot be told apart"
        )
        sentence = f"the neck bends towards the other side than {one} and {other} say: left and right are swapped"
        return Finding("swapped", (), sentence, f"exchange the columns {one} and {other}{mirror}", True)

    def _beside_tendons(self) -> bool:
        """Whether a load other than the tendons' tells left from right."""
        return bool(self.data.fz.any() or self.data.tau.any() or self.data.tilt.any())

    def _origin(self, name: str) -> list[Finding]:
        column, found, channel = self._named(name)[0], self.best.calibration, CHANNELS.index(name)
        unit = "mrad" if name == "theta" else "mm"
        value, std = float(found.origin[channel]), float(found.origin_std[channel])
        where, value = self._known_origin(name, value, std)
        far = abs(value) > (_FAR[1] if name == "theta" else _FAR[0] * self.mechanism.beam.length)
        sentence = f"{column}: the readings lie {1e3 * value:+.4g} {unit} from the model once calibrated"
        cure = f"{where}: take {1e3 * value:.4g} {unit} off"
        if far:
            return [Finding("origin", (), sentence, cure, True)]
        if abs(value) < _CAMERA[channel]:
            return []
        return [Finding("origin", (), sentence, f"if the origin is off: {cure}")]

    def _known_origin(self, name: str, value: float, std: float) -> tuple[str, float]:
        """Return the origin in words, and its value: that of an origin with a name where the readings agree with it."""
        reach = max(_CERTAIN_ORIGIN * std, CAMERA_SIGMA[CHANNELS.index(name)])
        if name == "theta":
            turns = (0.5 * math.pi, -0.5 * math.pi, math.pi, -math.pi)
            named = {f"theta is 0 for the straight neck, here it reads {math.degrees(turn):.0f} degrees": turn
                     for turn in turns}  # fmt: skip
        elif name == "x":
            length, rest = self.mechanism.beam.length, self._at_rest()
            named = {
                f"x was set to zero at the head of the straight neck, {1e3 * length:.1f} mm from the clamp": -length,
                f"x was set to zero with the neck at rest, {1e3 * rest:.1f} mm from the clamp": -rest,
            }
        else:
            named = {}
        near = min(named, key=lambda words: abs(named[words] - value), default="")
        if near and abs(named[near] - value) <= reach:
            return near, named[near]
        rest_of_x = " and x at rest the length of the beam" if name == "x" else ""
        return f"the origin is at the clamp, theta is 0 for the straight neck{rest_of_x}", value

    def _at_rest(self) -> float:
        """Return where the calibrated model has the head without any load [m]."""
        rest = Measurements.from_columns({"lam_l_N": [0.0], "lam_r_N": [0.0]})
        calibrated = pack(self.mechanism.replace(**self.best.calibration.stiffnesses))
        pose, _, _ = MeasuringChain(Discretization.from_elements(1, 5), rest).solve(calibrated, last_step(1e-9))
        return float(pose[0, 0])

    def _unexplained(self, name: str, misfit: float) -> Finding:
        column, beam = self._named(name)[0], self.mechanism.beam
        sentence = f"{column}: half of the readings are off by more than {misfit:.2g} of what they vary by"
        cure = "no unit, sign, swap or origin of columns explains all readings: is this the mechanism file of this "
        cure += f"neck (length {beam.length:g} m, EI {beam.EI:g} N m^2)?"
        return Finding("unexplained", (), sentence, cure)


def _scale(units: Mapping[str, tuple[float, float]], unit: str) -> float:
    times, per = units[unit]
    return times / per


def _typical(name: str, values: Array) -> float:
    known: Any = values[np.isfinite(values)]
    if not known.size:
        return math.nan
    return float(np.median(known)) if name == "x" else float(np.quantile(np.abs(known), 0.95))
