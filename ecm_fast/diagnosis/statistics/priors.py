"""What is known of parameters before the data speak."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["ROUGHLY", "Priors"]

Array = NDArray[np.float64]

ROUGHLY = 0.5
"""Standard deviation of the logarithm of a stiffness of which nothing is known but its order of magnitude."""


@dataclass(frozen=True, eq=False)
class Priors:
    """Independent normal priors.

    Attributes
    ----------
    center, std : (p,), std inf where nothing is known
    rough : (p,) whether the logarithm is meant, over that of `center`
    """

    center: Array
    std: Array
    rough: NDArray[np.bool_]

    @property
    def known(self) -> NDArray[np.int64]:
        """Places of the parameters of which something is known."""
        return np.flatnonzero(np.isfinite(self.std))

    def rows(self, values: Array) -> tuple[Array, Array]:
        """Return residuals (q,) in standard deviations, and their derivatives (q, p)."""
        at = self.known
        rough, center, std = self.rough[at], self.center[at], self.std[at]
        safe = np.where(rough, values[at], 1.0)
        off = np.where(rough, np.log(safe / np.where(rough, center, 1.0)), values[at] - center) / std
        slope = np.zeros((at.size, values.size))
        slope[np.arange(at.size), at] = 1.0 / (std * safe)
        return off, slope

    def and_of(self, center: Sequence[float], std: Sequence[float]) -> "Priors":
        """Return the priors with those of further parameters."""
        return Priors(
            np.concatenate([self.center, center]),
            np.concatenate([self.std, std]),
            np.concatenate([self.rough, np.zeros(len(center), dtype=bool)]),
        )
