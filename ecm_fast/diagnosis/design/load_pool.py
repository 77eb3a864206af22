"""The pool of further measurements: loads and add-ons that a measurement file can express, with their costs."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ...data.columns import CHANNELS, COLUMNS, LOADS
from ...data.measurements import Measurements
from ...errors import InputError, did_you_mean, shown

__all__ = ["ADD_ONS", "Pool"]

Array = NDArray[np.float64]

_TENSION = (0.0, 40.0, 80.0, 120.0, 160.0)
"""[N], the range of the paper's Fig. 4."""
_FX, _FZ, _TAU = (0.0, -150.0, -300.0), (0.0, 33.0, -33.0, 66.0, -66.0), (0.0, 6.0, -6.0)
"""[N, N, N m], inside the paper's box of wrenches, +-330 N, +-80 N, +-11 N m."""
ADD_ONS: Mapping[str, tuple[dict[str, float], float]] = {
    "nothing": ({}, 0.0),
    "wrench": ({}, 2.0),
    "mass": ({"extra_mass": 2.0}, 2.0),
    "tilt": ({"tilt": 0.5}, 3.0),
    "tilt-back": ({"tilt": -0.5}, 3.0),
}
"""Parts to be mounted, what they change, and the minutes that mounting takes once."""
_READING = 0.5
"""Minutes for one reading: change the load, hold it, read."""


@dataclass(frozen=True, eq=False)
class Pool:
    """Loads to choose from, one entry a row.

    Attributes
    ----------
    loads : (n, 7) in the order of `LOADS`
    add_on : (n,) name of what has to be mounted
    """

    loads: Array
    add_on: tuple[str, ...]

    @classmethod
    def from_add_ons(cls, add_ons: Iterable[str] = tuple(ADD_ONS), lam_max: float = 160.0) -> "Pool":
        """Return every pair of tendon forces with every add-on, and every wrench on the neck without tendons.

        Parameters
        ----------
        add_ons : what can be mounted, of `ADD_ONS`; ``nothing`` are the tendons alone
        lam_max : largest tendon force [N]

        Raises
        ------
        InputError : no such add-on.
        """
        rows: list[tuple[float, ...]] = []
        names: list[str] = []
        for name in add_ons:
            if name not in ADD_ONS:
                raise InputError(f"add-on {name!r}: allowed are {', '.join(ADD_ONS)}{did_you_mean(str(name), ADD_ONS)}")
            change = ADD_ONS[name][0]
            mass_and_tilt = (change.get("extra_mass", 0.0), change.get("tilt", 0.0))
            if name == "wrench":
                loads = [(0.0, 0.0, *wrench, *mass_and_tilt) for wrench in product(_FX, _FZ, _TAU) if any(wrench)]
            else:
                loads = [
                    (a, b, 0.0, 0.0, 0.0, *mass_and_tilt)
                    for a, b in product(_TENSION, _TENSION)
                    if max(a, b) <= lam_max
                ]
            rows += loads
            names += [name] * len(loads)
        if not rows:
            raise InputError("no add-on to choose from; allowed are " + ", ".join(ADD_ONS))
        return cls(np.array(rows), tuple(names))

    def within(self, limits: Mapping[str, float]) -> "Pool":
        """Return the loads none of which is larger than its limit, by the columns of a measurement file.

        Raises
        ------
        InputError : no such load, a limit below zero, or no load is left.
        """
        names = [COLUMNS[name].names[0] for name in LOADS]
        kept = np.ones(len(self.loads), dtype=bool)
        for name, limit in limits.items():
            if name not in names:
                raise InputError(f"limit of {shown(name)}: allowed are {', '.join(names)}{did_you_mean(name, names)}")
            if not limit >= 0.0:
                raise InputError(f"limit of {name} = {limit!r}: allowed is a number >= 0")
            kept &= np.abs(self.loads[:, names.index(name)]) <= limit
        if not self.loads[kept].any():
            raise InputError("the limits leave no load to choose from; allow more of one")
        return Pool(self.loads[kept], tuple(name for name, keep in zip(self.add_on, kept, strict=True) if keep))

    @property
    def data(self) -> Measurements:
        """The loads as measurements with blank poses."""
        columns = {COLUMNS[name].names[0]: values for name, values in zip(LOADS, self.loads.T, strict=True)}
        blank = {COLUMNS[name].names[0]: [None] * len(self.loads) for name in CHANNELS}
        return Measurements.from_columns({**columns, **blank}, source="loads to choose from")

    def minutes(self, i: int, mounted: set[str], repeats: int) -> float:
        """Return what repeated readings of one load cost, where some add-ons have been mounted for others already."""
        name = self.add_on[i]
        return repeats * _READING + (0.0 if name in mounted else ADD_ONS[name][1])

    def named(self, i: int) -> dict[str, float]:
        """Return one load by the columns of a measurement file, zeros left out, tendon forces always there."""
        return {
            COLUMNS[name].names[0]: float(value)
            for name, value in zip(LOADS, self.loads[i], strict=True)
            if value or name in ("lam_l", "lam_r")
        }
