"""The controls of the live page: loads, main parameters and every effect of the catalogue."""

import math
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ...errors import InputError, did_you_mean, key_shown, shown
from ...mechanism.catalogue import CATALOGUE
from ...mechanism.derived import limits
from ...mechanism.mechanism import Mechanism
from ...mechanism.parameters import PARAMETERS, find
from ...mechanism.quantity import Quantity
from ...mechanism.vector import pack

__all__ = ["LAM_MAX", "LOADS", "Control", "checked", "controls"]

LAM_MAX = 160.0
"""Largest tendon force of the paper [N]: how far the sliders go, and the workspace."""
LOADS = ("lam_l", "lam_r", "fx", "fz", "tau")
_MAIN = (
    "beam.length",
    "beam.EA",
    "beam.GA",
    "beam.EI",
    "head.mass",
    "head.h",
    "tendons.plate_half_width",
    "tendons.pulley_x",
    "tendons.pulley_z",
    "tendons.pulley_radius",
    "gravity.g",
)
# an effect's slider goes so many of its typical sizes to either side
_SIZES = 5.0


@dataclass(frozen=True)
class Control:
    """A slider.

    Attributes
    ----------
    name : a load, or the full key of a parameter
    label, unit : for the reader
    group : loads, neck or effects
    low, high, value : its ends, and where it stands first
    """

    name: str
    label: str
    unit: str
    group: str
    low: float
    high: float
    value: float

    def json(self) -> dict[str, Any]:
        """Return it as the page takes it."""
        return asdict(self)


def controls(neck: Mechanism) -> list[Control]:
    """Return the sliders for a mechanism, which stands in their middle."""
    par = pack(neck)
    values = dict(zip((entry.key for entry in PARAMETERS), par.tolist(), strict=True))
    sliders = [
        Control("lam_l", "left tendon force", "N", "loads", 0.0, LAM_MAX, 40.0),
        Control("lam_r", "right tendon force", "N", "loads", 0.0, LAM_MAX, 10.0),
        Control("fx", "load along x", "N", "loads", -30.0, 30.0, 0.0),
        Control("fz", "load along z", "N", "loads", -30.0, 30.0, 0.0),
        Control("tau", "moment", "N m", "loads", -1.0, 1.0, 0.0),
    ]
    numbers = [_main(find(key), values[key]) for key in _MAIN]
    numbers += [_effect(entry, values[entry.key]) for effect in CATALOGUE.values() for entry in effect]
    return sliders + [_possible(control, limits(control.name, par)) for control in numbers]


def _possible(control: Control, ends: tuple[float, float]) -> Control:
    """Return a slider that stays within what the mechanism's other numbers leave possible."""
    return replace(control, low=max(control.low, ends[0]), high=min(control.high, ends[1]))


def _main(entry: Quantity, value: float) -> Control:
    """Half as much to twice as much; about zero, so many typical sizes."""
    ends = sorted((0.5 * value, 2.0 * value)) if value else (-_SIZES * entry.typical, _SIZES * entry.typical)
    return _control(entry, "neck", entry.meaning, ends[0], ends[1], value)


def _effect(entry: Quantity, value: float) -> Control:
    away = _SIZES * entry.typical
    return _control(
        entry, "effects", f"{entry.name}: {entry.meaning}", min(value, entry.default - away),
        max(value, entry.default + away), value,
    )  # fmt: skip


def _control(entry: Quantity, group: str, label: str, low: float, high: float, value: float) -> Control:
    unit = "" if entry.unit == "-" else entry.unit
    return Control(entry.key, label, unit, group, max(low, entry.lower), min(high, entry.upper), value)


def checked(given: object) -> dict[str, float]:
    """Return the inputs of a request, or raise where they cannot be meant.

    Raises
    ------
    InputError : not numbers by the names of loads and parameters; names the first that is not.
    """
    if not isinstance(given, dict):
        raise InputError(f"inputs = {shown(given)}: allowed is an object of numbers by name")
    inputs = {}
    for name, value in given.items():
        if name in LOADS:
            least = 0.0 if name.startswith("lam") else -np.inf
            number = float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else math.nan
            if not (math.isfinite(number) and number >= least and abs(number) <= 1e6):
                raise InputError(f"{name} = {shown(value)}: allowed is a number{' >= 0' if least == 0.0 else ''} "
                                 "of at most 1e6 [N]")  # fmt: skip
            inputs[name] = number
        elif name in _KEYS:
            inputs[name] = find(name).check(value)
        else:
            raise InputError(f"no input is called {key_shown(name)!r}{did_you_mean(name, (*LOADS, *_KEYS))}")
    return inputs


_KEYS = {entry.key for entry in PARAMETERS if entry.key != "beam.axial_law"}
