"""Lack-of-fit tests with a given false alarm rate over all candidates."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..results.diagnosis import LackOfFit
from .evidence import EvidenceMatrix

__all__ = ["NAMED", "SMOOTH", "null_quantile", "score_test", "trend_test"]

Array = NDArray[np.float64]

NAMED, SMOOTH = 0.3, 0.1
"""Shares of the chance of a false alarm that the tests with and without names may use.

The rest is for what noise is like in truth: tails, outliers and memory are estimated from the data.
"""
_DRAWS = 10_000  # a chance of 1e-3 is then known to a third
_SEEN = 1.0
"""Sigmas of one prior standard deviation below which an effect cannot make a statistic: it would be implausible."""


def score_test(gram: EvidenceMatrix, dof: float, stage: int, alpha: float, seed: int) -> LackOfFit:
    """Return the test by the largest projected score over all candidates that could be seen."""
    from scipy.special import stdtr

    seen = gram.norm >= _SEEN
    if not seen.any():
        return LackOfFit("effects", stage, 0.0, 1.0, alpha)
    scores = gram.scores()[seen]
    sizes = np.where(gram.one_sided[seen], scores, np.abs(scores))
    largest = float(sizes.max())
    sides = np.where(gram.one_sided[seen], 1.0, 2.0)
    bound = float(sides.sum() * stdtr(dof, -largest))
    if bound < 0.1 * alpha:
        return LackOfFit("effects", stage, largest, bound, alpha)
    null = _null(gram, seen, dof, seed)
    return LackOfFit("effects", stage, largest, float((1 + (null >= largest).sum()) / (1 + null.size)), alpha)


def null_quantile(gram: EvidenceMatrix, dof: float, alpha: float, seed: int) -> float:
    """Return what the largest score exceeds with a chance of `alpha` where nothing is missing."""
    seen = gram.norm >= _SEEN
    return float(np.quantile(_null(gram, seen, dof, seed), 1.0 - alpha)) if seen.any() else np.inf


def _null(gram: EvidenceMatrix, seen: NDArray[np.bool_], dof: float, seed: int) -> Array:
    """Return draws of the largest score, (d,): Gaussian scores with the signatures' cosines, over a common scale."""
    rng = np.random.default_rng(seed)
    values, vectors = np.linalg.eigh(gram.cosine[np.ix_(seen, seen)])
    large = values > 1e-3
    root = vectors[:, large] * np.sqrt(values[large])
    root /= np.sqrt((root**2).sum(axis=1, keepdims=True))
    draws = rng.standard_normal((_DRAWS, root.shape[1])) @ root.T
    one_sided = gram.one_sided[seen]
    draws[:, ~one_sided] = np.abs(draws[:, ~one_sided])
    common = np.sqrt(rng.chisquare(dof, _DRAWS) / dof) if np.isfinite(dof) else 1.0
    return np.asarray(draws.max(axis=1) / common)


def trend_test(
    residual: Array, nuisances: Array, smooth: Sequence[Array], dofs: Sequence[float], stage: int, alpha: float
) -> LackOfFit:
    """Return the test by what smooth functions take off the residual (m,) beyond the nuisances (m, p).

    Every kind of them (m, q) is tested alone, with its own degrees of freedom behind the noise; the least likely one
    counts, for as many as there are.
    """
    from scipy.special import fdtrc

    from .robust_noise import orthonormal

    base, least, statistic = orthonormal(nuisances), 1.0, 0.0
    for columns, dof in zip(smooth, dofs, strict=True):
        beyond = orthonormal(columns - base @ (base.T @ columns))
        beyond -= base @ (base.T @ beyond)
        taken = beyond.T @ residual
        count = max(taken.size, 1)
        mean = float(taken @ taken) / count
        chance = min(len(smooth) * float(fdtrc(count, dof, mean)), 1.0)
        least, statistic = min((least, statistic), (chance, mean))
    return LackOfFit("smooth", stage, statistic, least, alpha)
