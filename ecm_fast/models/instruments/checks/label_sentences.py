"""Sentences about units, signs, swapped columns and origins that are wrong, and their cures."""

import math
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....data.columns import CAMERA_SIGMA, CHANNELS, COLUMNS, match
from ....data.measurements import Measurements
from ....mechanism.mechanism import Mechanism
from ....mechanism.mesh.discretization import Discretization
from ....mechanism.vector import pack
from ...loads import last_step
from ..measuring_chain import MeasuringChain
from .finding import Finding
from .units_and_axes import Change, Explanation, LabelSearch

__all__ = ["label_findings"]

Array = NDArray[np.float64]

_OFF = 1.0  # misfit from which on it is said that nothing explains a channel: more than its readings vary
_BETTER = 0.6  # share of the price without any change that changes may have; a wrong label leaves a tenth, or half
_FAR = (0.05, 0.2)
"""An origin beyond this share of the length, or this angle [rad], is not that of a camera that was set up a bit off."""
_CERTAIN_ORIGIN = 4.0  # standard deviations within which an origin is taken for one that has a name
_CAMERA = (3e-3, 3e-3, 0.03)  # [m, m, rad] origins up to here are effects of the catalogue: the search judges them
_WORDS = {"mm": "millimetres", "cm": "centimetres", "m": "metres", "um": "micrometres", "deg": "degrees",
          "in": "inches", "rad": "radians", "mrad": "milliradians"}  # fmt: skip


def label_findings(mechanism: Mechanism, data: Measurements, unknown: Collection[str] = ()) -> list[Finding]:
    """Return what the labels of the columns get wrong, the most telling first.

    unknown : stiffnesses of which not even the order of magnitude is known
    """
    search = LabelSearch(mechanism, data, unknown)
    if not search.channels:
        return []
    return _Sentences(mechanism, data, search.best()).findings(search.plain)


class _Sentences:
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
        sided = self._beside_tendons()
        mirror = "" if sided else ", or mirror both z and theta: with tendon loads alone the two cannot be told apart"
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
        cure += ', or tell it: zeroed = "first", "session" or "unloaded", --zeroed' * ("at rest," in where)
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
