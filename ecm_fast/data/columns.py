"""The columns of a measurement file, each with its units and rules."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, did_you_mean
from .cells import DECIMAL_COMMA, is_blank, is_time, label, number, seconds, shown
from .units import ANGLE, COUPLE, FORCE, LENGTH, MASS, OTHER, TEXT, TIME, Units, kind_of, unit_of

__all__ = [
    "CAMERA_SIGMA",
    "CHANNELS",
    "CHANNEL_KEYS",
    "COLUMNS",
    "LOADS",
    "PAIR",
    "Column",
    "channel_key",
    "column_of",
    "foreign",
    "is_known",
    "is_note",
    "is_other",
    "match",
    "unit_in",
    "usual_sigma",
]

LOADS = ("lam_l", "lam_r", "fx", "fz", "tau", "extra_mass", "tilt")
"""Loads of a row: tendon forces, dead wrench at Q, and what is changed on the test bed."""
PAIR = ("l", "r")
"""Names of the two tendons of a neck."""
CHANNELS = ("x", "z", "theta")
"""Channels of a pose."""
CHANNEL_KEYS = ("x_m", "z_m", "theta_rad")
"""The same with their units, as files and JSON have them."""
CAMERA_SIGMA = (1e-4, 1e-4, 1e-3)
"""[m, m, rad] noise of a camera of which nothing is known; of a length as of a place."""

_LONGEST_LABEL = 100  # labels live in one fixed-width array: a single huge one would cost its length in every row

_LARGEST = {"m": 1e3, "rad": 1e3, "N": 1e6, "Nm": 1e6, "s": 1e12, "kg": 1e6}
"""Largest size of a value by its SI unit, far beyond any neck: what is larger is a slip, and its square no number."""


@dataclass(frozen=True, slots=True)
class Column:
    """One quantity a file may give, row by row.

    Attributes
    ----------
    name : the quantity, a field of `Measurements`; in a file a unit suffix follows, e.g. ``x_mm``
    units : the suffixes and their factors, SI first; empty for text
    meaning : one line
    absent : what every row gets when the file has no such column; nan also lets single cells be blank
    lower : closed lower bound of a value
    """

    name: str
    units: Units
    meaning: str
    absent: float = math.nan
    lower: float = -math.inf

    @property
    def names(self) -> list[str]:
        """Names of the column in a file, SI first."""
        return [f"{self.name}_{unit}" for unit in self.units] or [self.name]

    @property
    def largest(self) -> float:
        """Largest size of a value, in SI."""
        return _LARGEST[next(iter(self.units))]

    @property
    def allowed(self) -> str:
        """Allowed content of a cell, in words."""
        bound = "" if self.lower == -math.inf else f" >= {self.lower:g}"
        return f"a finite number{bound}{', or a blank' if math.isnan(self.absent) else ''}"

    def numbers(
        self, cells: Sequence[object], unit: str, scale: float = 1.0
    ) -> tuple[NDArray[np.float64], dict[int, str]]:
        """Return the values in SI, (n,), nan where blank, and for each bad cell what is wrong with it.

        A value is `scale` times what the cell says. Times of day and dates become seconds since the first.
        """
        if self.name == "t" and unit == "s" and any(map(is_time, cells)):
            return seconds(cells)
        times, per = self.units[unit]
        values, bad = np.full(len(cells), math.nan), {}
        for i, cell in enumerate(cells):
            if is_blank(cell):
                if not math.isnan(self.absent):
                    bad[i] = f"blank (allowed is {self.allowed}; write {self.absent:g} for none)"
                continue
            value = scale * number(cell) * times / per
            if self.lower <= value <= self.largest and value >= -self.largest:
                values[i] = value
            elif self.largest < abs(value) < math.inf and value >= self.lower:
                bad[i] = f"{shown(cell)} (allowed is a size of at most {self.largest * per / times:g} {unit})"
            else:
                by = "" if scale == 1.0 else f" times {scale:g}"
                comma = isinstance(cell, str) and DECIMAL_COMMA.fullmatch(cell.strip())
                cure = "; decimals are written with a point" if comma else ""
                bad[i] = f"{shown(cell)}{by} (allowed is {self.allowed}{cure})"
        return values, bad

    def labels(self, cells: Sequence[object]) -> tuple[NDArray[np.str_], dict[int, str]]:
        """Return the cells as text, (n,), empty where blank, and for each bad cell what is wrong with it."""
        values, bad = [""] * len(cells), {}
        for i, cell in enumerate(cells):
            if cell is None or cell == "" or (isinstance(cell, str) and not cell.strip()):
                continue
            text = label(cell)
            if text.isprintable() and 0 < len(text) <= _LONGEST_LABEL:
                values[i] = text
            else:
                bad[i] = f"{shown(cell)} (allowed is printable text of up to {_LONGEST_LABEL} characters, or a number)"
        return np.array(values, dtype=np.str_), bad


def _declared(*columns: Column) -> Mapping[str, Column]:
    return {column.name: column for column in columns}


COLUMNS = _declared(
    Column("lam_l", FORCE, "left tendon's force as read", 0.0, 0.0),
    Column("lam_r", FORCE, "right tendon's force as read", 0.0, 0.0),
    Column("fx", FORCE, "external dead force at Q along x", 0.0),
    Column("fz", FORCE, "external dead force at Q along z", 0.0),
    Column("tau", COUPLE, "external couple at Q", 0.0),
    Column("x", LENGTH, "measured place of Q along x"),
    Column("z", LENGTH, "measured place of Q along z"),
    Column("theta", ANGLE, "measured angle of the head"),
    Column("t", TIME, "time stamp"),
    Column("dwell", TIME, "time the load was held before reading", lower=0.0),
    Column("extra_mass", MASS, "mass added at the head's center of mass", 0.0, 0.0),
    Column("tilt", ANGLE, "gravity turned in the plane, its direction -(cos, sin) in (x, z)", 0.0),
    Column("sigma_x", LENGTH, "known noise of x, one standard deviation", lower=0.0),
    Column("sigma_z", LENGTH, "known noise of z, one standard deviation", lower=0.0),
    Column("sigma_theta", ANGLE, "known noise of theta, one standard deviation", lower=0.0),
    Column("sigma_lam", FORCE, "known noise of both force readings, one standard deviation", lower=0.0),
    Column("experiment", TEXT, "what was done, e.g. tendon, shear, compression, tilt"),
    Column("pose_id", TEXT, "rows with the same text repeat one commanded load"),
    Column("session", TEXT, "the session a row was taken in, text or number"),
)
"""Every column by its quantity, in the order of the fields of `Measurements`."""

_ALSO_CALLED = {"time": "t", "angle": "theta", "rotation": "theta", "mass": "extra_mass", "side": "fz", "torque": "tau"}
_IGNORE = "start its name with note_ to have it ignored, or have it named by ecm-fast import"

_NAMED = re.compile(r"(lam|len)_([A-Za-z][A-Za-z0-9_-]*)_([A-Za-z]+)")
_BRACKETS = re.compile(r"(.*\w)\s*[\[(]([^\[\]()]+)[\])]")
_MARKER = re.compile(r"((?:sigma_)?)([A-Za-z][A-Za-z0-9_-]*)_(x|z|theta)_([A-Za-z]+)")

_SUBJECTS = (*LOADS, *CHANNELS)
"""A file without any of these says nothing about the neck."""


def channel_key(channel: str) -> str:
    """Return a channel with its unit, as files and JSON have it: ``x_m``, ``M1_theta_rad``."""
    return f"{channel}_{'rad' if _is_angle(channel) else 'm'}"


def usual_sigma(channels: Iterable[str]) -> NDArray[np.float64]:
    """Return the noise of channels of which nothing is known, (c,) [m, rad], see `CAMERA_SIGMA`."""
    return np.array([CAMERA_SIGMA[2 if _is_angle(channel) else 0] for channel in channels])


def _is_angle(channel: str) -> bool:
    return channel.split("_")[-1] == "theta" and not channel.startswith("len_")


def is_note(name: str) -> bool:
    """Tell whether a column is the user's own remark, which nobody reads."""
    return name.lower().startswith("note")


def is_known(name: str) -> bool:
    """Tell whether a name is that of a column, with a unit of it, or of a tendon or marker."""
    try:
        column_of(name)
    except InputError:
        return False
    return True


def is_other(name: str) -> bool:
    """Tell whether a column says by its unit that it is no load and no pose, as ``temp_C``, and is nothing of ours."""
    apart = _BRACKETS.fullmatch(name)
    unit = apart[2].strip() if apart else name.rpartition("_")[2]
    ours = any(name == known or name.startswith(f"{known}_") for known in COLUMNS)
    return unit in OTHER and not ours and not is_known(name) and not foreign(name)


def unit_in(name: str) -> str:
    """Return the unit that a name gives in brackets or after its last ``_``, nothing where it gives none."""
    apart = _BRACKETS.fullmatch(name)
    return unit_of(apart[2] if apart else name.rpartition("_")[2] if "_" in name else "")


def match(names: Iterable[str]) -> list[tuple[Column, str]]:
    """Return the column and the unit suffix of every name.

    Raises
    ------
    InputError : a name is unknown, has no unit or a foreign one, is there twice, or nothing useful is there.
    """
    found: dict[str, str] = {}
    matched, wrong = list[tuple[Column, str]](), list[str]()
    for place, name in enumerate(names, start=1):
        try:
            column, unit = column_of(name, place)
        except InputError as error:
            wrong.append(str(error))
            continue
        if column.name in found:
            other = found[column.name]
            twice = f"column {name!r} is there twice" if other == name else f"columns {other} and {name} give the same"
            raise InputError(f"{twice}; keep one")
        found[column.name] = name
        matched.append((column, unit))
    if wrong:
        raise InputError("; ".join([*(text.removesuffix(f"; {_IGNORE}") for text in wrong[:-1]), wrong[-1]]))
    if not any(name in found for name in _SUBJECTS) and all(column.name in COLUMNS for column, _ in matched):
        needed = ", ".join(COLUMNS[name].names[0] for name in _SUBJECTS)
        raise InputError(f"gives no load and no pose; at least one of the columns {needed} is needed")
    return matched


def column_of(name: str, place: int = 1) -> tuple[Column, str]:
    """Return the column that a name means, and its unit suffix.

    Raises
    ------
    InputError : the name is unknown, or has no unit or a foreign one.
    """
    if not name:
        raise InputError(f"column {place} has no name; name it or delete it")
    if (apart := _BRACKETS.fullmatch(name)) and (unit := unit_of(apart[2])):
        name = f"{apart[1]}_{unit}"
    if not any(name in column.names for column in COLUMNS.values()) and (named := _named(name)):
        return named
    # The longest quantity that fits: sigma_x_mm is sigma_x in mm.
    fitting = [column for column in COLUMNS.values() if name == column.name or name.startswith(f"{column.name}_")]
    column = max(fitting, key=lambda column: len(column.name), default=None)
    unit = name[len(column.name) + 1 :] if column else ""
    if column and name in column.names:
        return column, unit
    if column and unit_of(unit) in column.units:
        return column, unit_of(unit)
    if column and column.units:
        wrong = f"{shown(unit)} is not a unit of {column.name}" if unit else "the unit is missing"
        raise InputError(f"column {shown(name)}: {wrong}; allowed are {', '.join(column.names)}, or {_IGNORE}")
    known = ", ".join(column.names[0] for column in COLUMNS.values())
    hint = foreign(name) or f" (known are {known}; of a robot lam_NAME_N, len_NAME_m, MARKER_x_m)"
    raise InputError(f"unknown column {shown(name)}{hint}; {_IGNORE}")


def _named(name: str) -> tuple[Column, str] | None:
    """Return the column of a named tendon or marker, and its unit suffix; None where the name is of no such form."""
    if found := _NAMED.fullmatch(name):
        kind, which, unit = found.groups()
        units, what = (FORCE, "force as read") if kind == "lam" else (LENGTH, "free length")
        return (
            (Column(f"{kind}_{which}", units, f"tendon {which}'s {what}", lower=0.0), unit) if unit in units else None
        )
    if found := _MARKER.fullmatch(name):
        sigma, which, channel, unit = found.groups()
        units = ANGLE if channel == "theta" else LENGTH
        what = f"{'known noise' if sigma else 'measured value'} of marker {which}'s {channel}"
        column = Column(f"{sigma}{which}_{channel}", units, what, lower=0.0 if sigma else -math.inf)
        return (column, unit) if unit in units else None
    return None


def foreign(name: str) -> str:
    """Return a hint for a column of a tendon or marker that the mechanism has not."""
    kind = kind_of(name.rpartition("_")[2])  # a length is no misspelled force
    every = [
        f"{column.name}_{unit}" if unit else column.name
        for column in COLUMNS.values()
        for unit in column.units or ("",)
        if not kind or kind_of(unit) == kind
    ]
    meant = next((allowed for allowed in every if allowed.lower() == name.lower()), name[:60])
    return _tendon(name) or _alike(name) or did_you_mean(meant, every)


def _alike(name: str) -> str:
    """Return a hint where a name has a word that people use for a column, and a unit of it."""
    *words, unit = name.split("_")
    for word in map(str.lower, words):
        if word == "sigma":
            known = [column.names[0] for column in COLUMNS.values() if column.name.startswith("sigma_")]
            return f" (known are {', '.join(known)})"
        meant = COLUMNS.get(_ALSO_CALLED.get(word, ""))
        if meant and unit in meant.units:
            return f" (did you mean '{meant.name}_{unit}'?)"
    return ""


def _tendon(name: str) -> str:
    """Return a hint where a name speaks of a left or a right force."""
    words = name.lower().split("_")
    side = next((side for side in ("left", "right") if side in words), "")
    units = {unit.lower() for column in COLUMNS.values() for unit in column.units}
    if not side or (words[-1] in units and words[-1] not in map(str.lower, FORCE)):
        return ""
    return f" (did you mean 'lam_{side[0]}_N'?)"
