"""Units of columns, and how people write them."""

import math
from collections.abc import Mapping

__all__ = [
    "ANGLE",
    "COUPLE",
    "FORCE",
    "KINDS",
    "LENGTH",
    "MASS",
    "OTHER",
    "TEXT",
    "TIME",
    "Units",
    "kind_of",
    "unit_of",
]

Units = Mapping[str, tuple[float, float]]

# SI value = value * times / per. Two factors, because 109 / 1000 is the double nearest 0.109 and 109 * 0.001 is not.
LENGTH: Units = {"m": (1, 1), "cm": (1, 100), "mm": (1, 1000), "um": (1, 1_000_000), "in": (254, 10_000)}
ANGLE: Units = {"rad": (1, 1), "mrad": (1, 1000), "deg": (math.pi, 180)}
FORCE: Units = {"N": (1, 1), "kN": (1000, 1), "mN": (1, 1000), "kgf": (980_665, 100_000), "gf": (980_665, 100_000_000),
                "lbf": (4.4482216152605, 1)}  # fmt: skip
COUPLE: Units = {"Nm": (1, 1), "Ncm": (1, 100), "Nmm": (1, 1000), "kNm": (1000, 1), "mNm": (1, 1000),
                 "kgfcm": (980_665, 10_000_000)}  # fmt: skip
TIME: Units = {"s": (1, 1), "ms": (1, 1000), "min": (60, 1), "h": (3600, 1)}
MASS: Units = {"kg": (1, 1), "g": (1, 1000)}
TEXT: Units = {}

KINDS = {"length": LENGTH, "angle": ANGLE, "force": FORCE, "couple": COUPLE, "time": TIME, "mass": MASS}
"""Units by what they measure."""

_SPELLINGS = {
    "\u00b0": "deg", "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad", "newton": "N",
    "newtons": "N", "millimeter": "mm", "millimeters": "mm", "meter": "m", "meters": "m", "metre": "m", "metres": "m",
    "\u00b5m": "um", "\u03bcm": "um", "micron": "um", "microns": "um", "inch": "in", "inches": "in", "kp": "kgf",
    "kg-f": "kgf", "kgforce": "kgf", "grf": "gf", "gram-force": "gf", "pound-force": "lbf", "sec": "s", "secs": "s",
    "second": "s", "seconds": "s", "sek": "s", "msec": "ms", "minutes": "min", "hours": "h",
}  # fmt: skip
OTHER = ("\u00b0C", "degC", "C", "K", "V", "mV", "A", "mA", "Hz", "kHz", "%", "MPa", "kPa", "bar", "mbar", "mm/min",
         "mm/s", "mm/mm", "N/m")  # fmt: skip
"""Units of columns that people have and no load or pose is given in."""
_TWO_SIZES = ("mn", "mnm")
"""Written without their capitals, units could be of two sizes: mega and milli."""


def unit_of(text: str) -> str:
    """Return the unit that a text means, nothing where it is none or could be several."""
    bare = "".join(letter for letter in text.strip() if letter not in " .*\u00b7\u22c5")
    every = [unit for units in KINDS.values() for unit in units]
    if bare in every:
        return bare
    if bare.lower() in _TWO_SIZES:
        return ""
    known = {**_SPELLINGS, **{unit.lower(): unit for unit in every}}
    return known.get(bare.lower(), "")


def kind_of(unit: str) -> str:
    """Return what a unit measures, nothing where it is none."""
    return next((kind for kind, units in KINDS.items() if unit in units), "")
