"""Units, signs and origins of pose columns, estimated by comparison with the mechanism as given.

No parameter is fitted. A wrong label moves poses by factors or by the size of the neck, far more than any effect of
the catalogue, so the nominal mechanism is exact enough to tell.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ...data.columns import COLUMNS, FORCE, Units, match
from ...data.measurements import Measurements
from ...mechanism.mechanism import Mechanism
from ...models.instruments.prediction import predict
from .finding import Finding

__all__ = ["label_findings"]

Array = NDArray[np.float64]

_CHANNELS = ("x", "z", "theta")
_ROWS = 200
_GOOD, _POOR = 0.35, 3.0
_PRICE = 0.1
"""What each change must gain of the misfit, which is 1 for a model that knows nothing."""
_TAIL = 0.2
_FEWEST = 5
_LENGTHS = (1e3, 1e2, 10.0, 0.1, 1e-2, 1e-3, 1e6, 25.4)
_ANGLES = (180.0 / math.pi, 1e3, math.pi / 180.0, 1e-3)
_FORCES = {"kgf": 9.80665, "lbf": 4.4482216, "kN": 1e3, "mN": 1e-3}
_FAR = (0.05, 0.2)
"""An offset beyond this share of the length, or this angle, is not that of a camera that was set up a bit off."""


@dataclass(frozen=True)
class _Reading:
    """How one channel has to be read to meet the model: pose = sign * value / factor - offset."""

    factor: float
    sign: float
    offset: float
    misfit: float
    tail: float

    @property
    def plain(self) -> bool:
        """Whether the channel is read as it is labelled."""
        return self.factor == 1.0 and self.sign == 1.0 and self.offset == 0.0

    @property
    def price(self) -> float:
        """Misfit, also that of the few rows which are off most, and what the changes cost."""
        changes = (self.factor != 1.0) + (self.sign != 1.0) + (self.offset != 0.0)
        return min(self.misfit, _POOR) + _TAIL * min(self.tail, _POOR) + _PRICE * changes


def label_findings(mechanism: Mechanism, data: Measurements) -> list[Finding]:
    """Return what the labels of the columns get wrong, most telling first."""
    kept = np.flatnonzero(data.measured.any(axis=1))
    part = data.select(kept[np.unique(np.linspace(0, kept.size - 1, min(_ROWS, kept.size)).astype(int))])
    best, chosen, least, shown = "", {}, math.inf, {}
    for word, loads in _loads(part):
        pose = predict(mechanism, loads).pose
        readings = {name: _read(part, pose, i, mechanism.beam.length) for i, name in enumerate(_CHANNELS)}
        found = {name: reading for name, reading in readings.items() if reading}
        if not found:
            continue
        price = sum(reading.price for reading in found.values()) + _PRICE * bool(word)
        if price < least:
            best, chosen, least, shown = word, found, price, dict(zip(_CHANNELS, pose.T, strict=True))
        if not word and all(reading.misfit <= _GOOD and reading.plain for reading in found.values()):
            break
    return _findings(data, part, mechanism, best, chosen, shown)


def _loads(data: Measurements) -> Iterator[tuple[str, Measurements]]:
    """Yield what the force columns may hold, in a word, and the loads that this means."""
    yield "", data
    if np.ptp(data.lam_l - data.lam_r) > 0.0:
        yield "swapped", replace(data, lam_l=data.lam_r.copy(), lam_r=data.lam_l.copy())
    largest = float(data.lam.max(initial=0.0))
    for unit, factor in _FORCES.items():
        if 2.0 < largest * factor < 2000.0:
            yield unit, replace(data, lam_l=data.lam_l * factor, lam_r=data.lam_r * factor)


def _read(data: Measurements, pose: Array, channel: int, length: float) -> _Reading | None:
    """Return the cheapest way to read a channel; None where it was not measured or not predicted."""
    value, model = data.pose[:, channel], pose[:, channel]
    known = np.isfinite(value) & np.isfinite(model)
    if known.sum() < _FEWEST:
        return None
    value, model = value[known], model[known]
    floor = (max(0.01 * length, 5e-4), max(0.003 * length, 5e-4), 0.005)[channel]
    moved = float(np.median(np.abs(model - np.median(model))))
    spread = max(moved, floor)
    signs = (1.0,) if channel == 0 or moved < floor else (1.0, -1.0)
    factors = () if channel > 0 and moved < floor else _ANGLES if channel == 2 else _LENGTHS
    options = []
    for factor, sign in product((1.0, *factors), signs):
        off = sign * value / factor - model
        shift = float(np.median(off))
        for offset in (0.0, shift) if factor == 1.0 or moved > floor else (0.0,):
            misfit, tail = np.quantile(np.abs(off - offset), (0.5, 0.9)) / spread
            options.append(_Reading(factor, sign, offset, float(misfit), float(tail)))
    plain = options[0]
    clear = plain.misfit < 0.5 * _GOOD and plain.tail < 2.0 * _GOOD
    return plain if clear else min(options, key=lambda option: option.price)


def _findings(
    data: Measurements,
    part: Measurements,
    mechanism: Mechanism,
    word: str,
    chosen: Mapping[str, _Reading],
    model: Mapping[str, Array],
) -> list[Finding]:
    good = all(reading.misfit <= _GOOD for reading in chosen.values())
    names = _names(data)
    out = []
    if word and good:
        out.append(_of_forces(data, names, word))
    for name, reading in chosen.items():
        if reading.misfit > _GOOD:
            out.append(_unexplained(names[name], reading, mechanism))
            continue
        value = getattr(part, name)
        if reading.factor != 1.0:
            out.append(_of_unit(names[name], name, value, model[name], reading))
        if reading.sign < 0.0:
            cure = f"turn the sign of {names[name][0]}: a stronger left tendon gives z > 0 and theta < 0"
            out.append(
                Finding("mirrored", (), f"{names[name][0]}: its sign is the opposite of the model's", cure, True)
            )
        if reading.offset != 0.0:
            out.append(_of_origin(names[name][0], name, reading, mechanism.beam.length))
    return sorted(out, key=lambda finding: not finding.certain)


def _names(data: Measurements) -> dict[str, tuple[str, str]]:
    """Return for each quantity its column in the file, and the unit that this says."""
    return {
        column.name: (name, unit)
        for name, (column, unit) in zip(data.columns, match(data.columns), strict=True)
        if unit
    }


def _scale(units: Units, unit: str) -> float:
    times, per = units[unit]
    return times / per


def _of_unit(named: tuple[str, str], name: str, value: Array, model: Array, reading: _Reading) -> Finding:
    column, unit = named
    units = COLUMNS[name].units
    true = _scale(units, unit) / reading.factor
    held = next((other for other in units if math.isclose(_scale(units, other), true, rel_tol=1e-6)), "")
    words = {"mm": "millimetres", "cm": "centimetres", "m": "metres", "um": "micrometres", "deg": "degrees",
             "rad": "radians", "mrad": "milliradians"}  # fmt: skip
    seen, says = (_typical(name, array) / _scale(units, unit) for array in (value, model))
    what = "median" if name == "x" else "largest size"
    sentence = f"{column}: the {what} is {seen:.3g} where the model says {says:.3g}"
    if not held:
        return Finding("unit", (), sentence, f"the column is {reading.factor:.3g} times too large", True)
    return Finding("unit", (), sentence, f"the column holds {words[held]}; label it {name}_{held}", True)


def _typical(name: str, values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if name == "x" else float(np.quantile(np.abs(known), 0.95))


def _of_forces(data: Measurements, names: Mapping[str, tuple[str, str]], word: str) -> Finding:
    left, right = (names.get(name, (f"{name}_N", "N")) for name in ("lam_l", "lam_r"))
    if word == "swapped":
        free = not (data.fz.any() or data.tau.any() or data.tilt.any())
        other = ", or mirror both z and theta: with tendon loads alone the two cannot be told apart" if free else ""
        sentence = (
            f"the neck bends towards the other side than {left[0]} and {right[0]} say: left and right are swapped"
        )
        return Finding("swapped", (), sentence, f"exchange the columns {left[0]} and {right[0]}{other}", True)
    factor = _FORCES[word]
    sentence = f"{left[0]}, {right[0]}: the neck bends as under {factor:.4g} times these forces, up to "
    sentence += f"{factor * data.lam.max():.3g} N instead of {data.lam.max():.3g} N"
    cure = f"label them lam_l_{word} and lam_r_{word}" if word in FORCE else f"multiply them by {factor:.6g}"
    return Finding("unit", (), sentence, f"the columns hold {word}; {cure}", True)


def _of_origin(column: str, name: str, reading: _Reading, length: float) -> Finding:
    unit, scale = ("mrad", 1e3) if name == "theta" else ("mm", 1e3)
    far = abs(reading.offset) > (_FAR[1] if name == "theta" else _FAR[0] * length)
    sentence = f"{column}: the readings lie {scale * reading.offset:+.3g} {unit} from the model in the median row"
    origin = "the origin is at the clamp, theta is 0 for the straight neck"
    rest = " and x at rest the length of the beam" if name == "x" else ""
    cure = f"{origin}{rest}: take {scale * reading.offset:.4g} {unit} off"
    return Finding("origin", (), sentence, cure if far else f"if the origin is off: {cure}", far)


def _unexplained(named: tuple[str, str], reading: _Reading, mechanism: Mechanism) -> Finding:
    sentence = f"{named[0]}: half of the readings are off by more than {reading.misfit:.2g} of what the loads move it"
    cure = "no unit, sign or origin explains that: is this the mechanism file of this neck "
    cure += f"(length {mechanism.beam.length:g} m, EI {mechanism.beam.EI:g} N m^2)?"
    return Finding("unexplained", (), sentence, cure)
