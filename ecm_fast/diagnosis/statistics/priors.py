"""Prior distributions of parameters."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["ROUGHLY", "SIZE_SPREAD", "Priors", "size_factor"]

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

    def extended(self, center: Sequence[float], std: Sequence[float]) -> "Priors":
        """Return the priors with those of further parameters."""
        return Priors(
            np.concatenate([self.center, center]),
            np.concatenate([self.std, std]),
            np.concatenate([self.rough, np.zeros(len(center), dtype=bool)]),
        )


Mask = NDArray[np.bool_]

SIZE_SPREAD = 1.2
"""Standard deviation, in typical sizes, of the normal prior about zero that fits work with."""
_FACTOR = 0.5
"""Standard deviation of a size's logarithm about that of the typical one: five of six are within a factor of two."""
_ANY = 0.1
"""Share of the sizes of which no more is known than the normal prior says."""
_AT = np.linspace(-6.0, 6.0, 61)  # standard deviations of what the data leave open
_LOG_WEIGHT = -0.5 * _AT**2 - np.log(np.exp(-0.5 * _AT**2).sum())  # of a normal density there, of sum 1


def size_factor(size: Array, std: Array, one_sided: Mask) -> Array:
    """Return what twice the log evidence gains because sizes are mostly typical, not normal about zero.

    The prior is a log-normal about the typical size, of either sign or positive, mixed with a little of the normal
    prior; the gain is its mean ratio to that one over what the data leave open.

    Parameters
    ----------
    size, std : (k,) what fits with the normal prior leave open, in its standard deviations
    one_sided : (k,) which sizes can only be positive
    """
    from scipy.special import log_ndtr, logsumexp

    either = np.where(one_sided, np.log(2.0), 0.0)
    at = size[:, None] + std[:, None] * _AT
    allowed = np.where(one_sided[:, None], at > 0.0, at != 0.0)
    ratio = np.where(allowed, _log_ratio(np.where(allowed, np.abs(at), 1.0)), -np.inf)
    typical = logsumexp(ratio + _LOG_WEIGHT, axis=1)
    normal = np.where(one_sided, log_ndtr(size / std), 0.0)
    return np.asarray(2.0 * (either + np.logaddexp(np.log1p(-_ANY) + typical, np.log(_ANY) + normal)))


def _log_ratio(size: Array) -> Array:
    """Return the logarithm of the log-normal density of a size > 0, of either sign, over that of the normal prior."""
    off = np.log(SIZE_SPREAD * size) / _FACTOR
    return np.asarray(0.5 * (size**2 - off**2) - np.log(2.0 * _FACTOR * size))
