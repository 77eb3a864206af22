"""How large an effect is before the data speak: as is typical, most often within a factor of two."""

import numpy as np
from numpy.typing import NDArray

__all__ = ["SIZE_SPREAD", "size_factor"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

SIZE_SPREAD = 1.2
"""Standard deviation, in typical sizes, of the normal prior about zero that fits work with."""
_FACTOR = 0.5
"""Standard deviation of a size's logarithm about that of the typical one: five of six are within a factor of two."""
_ANY = 0.1
"""Share of the sizes of which no more is known than the normal prior says."""
_AT = np.linspace(-6.0, 6.0, 61)  # standard deviations of what the data leave open
_LOG_WEIGHT = -0.5 * _AT**2 - np.log(np.exp(-0.5 * _AT**2).sum())


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
