"""Stiffnesses as compliances 1/EA, 1/GA and 1/EI, in which poses are almost linear."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...mechanism.sections import STIFFNESSES

__all__ = ["STIFFNESS_KEYS", "Scales"]

Array = NDArray[np.float64]

STIFFNESS_KEYS = tuple(f"beam.{name}" for name in STIFFNESSES)
_STIFFEST = 1e-3
"""Smallest compliance, in those of the start: stiffer than that, nothing differs from rigid."""


@dataclass(frozen=True, eq=False)
class Scales:
    """Parameters as a fit moves them: a stiffness k by k0/k, all others as they are.

    Attributes
    ----------
    stiff : (p,) which ones are stiffnesses
    unit : (p,) their k0, else 1
    """

    stiff: NDArray[np.bool_]
    unit: Array

    @classmethod
    def from_start(cls, keys: Sequence[str], start: Array) -> "Scales":
        """Return the scales of parameters by key, with their values at the start."""
        stiff = np.isin(keys, STIFFNESS_KEYS)
        return cls(stiff, np.where(stiff, start, 1.0))

    def moved(self, values: Array) -> Array:
        """Return what the fit moves, (p,), from values."""
        return np.where(self.stiff, self.unit / np.where(self.stiff, values, 1.0), values)

    def values(self, moved: Array) -> Array:
        """Return values (p,) from what the fit moves."""
        return np.where(self.stiff, self.unit / np.where(self.stiff, moved, 1.0), moved)

    def slope(self, moved: Array) -> Array:
        """Return the derivatives of the values by what is moved, (p,)."""
        return np.where(self.stiff, -self.unit / np.where(self.stiff, moved, 1.0) ** 2, 1.0)

    def bounds(self, lower: Array, upper: Array) -> tuple[Array, Array]:
        """Return the bounds of what is moved."""
        low = np.where(self.stiff, np.maximum(self.unit / np.maximum(upper, 1e-300), _STIFFEST), lower)
        return low, np.where(self.stiff, self.unit / np.maximum(lower, 1e-300), upper)
