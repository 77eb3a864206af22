"""Robust noise estimates: heavy tails, outliers, scale and serial correlation.

A reading far out is winsorized: drawn in to where it carries the information that its tail leaves it, so that all that
follows is plain least squares with noise of one size.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...identification.variance_components import MEDIAN_TO_SIGMA

__all__ = ["NoiseFit", "RowOrder", "clean", "orthonormal", "removal"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_TAILS = (3.0, 5.0, 10.0, 40.0)
"""Degrees of freedom of Student's t; the last one leaves Gaussian noise all but as it is."""
_OUTLIER = 6.0  # sigmas: one reading in 5e8 of Gaussian noise
_ONE_BY_ONE, _SHARE = 2000, 400
"""Rows up to which outliers are taken away one by one; of more rows, one in so many at a time."""
_RARE = 8.0  # how much more a heavy tail counts for rare events than for the variance
_MOST = 0.1  # largest share of the rows that may be outliers
_ROUNDS = 10  # reweightings; scale and tail then stand to a per cent
_DECLARED_DOF = 10.0  # readings that a declared noise is worth: known to 22 %
_LARGEST_MEMORY, _FEWEST_PAIRS = 0.9, 20  # a correlation beyond is a trend; pairs of rows that fix it to 0.2
_WITHIN_THREE = 1.0136  # standard deviation of Gaussian noise over that of its part within three of them
_HEAVIER = 1.0
"""Gain of the log-likelihood for which a heavier tail is taken."""
_ALMOST = 1e-3  # keeps a row that alone speaks for something from being judged by rounding
_SMALL = 1e-9  # singular values below this share of the largest carry nothing


@dataclass(frozen=True, eq=False)
class RowOrder:
    """Rows in the order of measurement.

    Attributes
    ----------
    before : (n,) place of the row before in the same session, -1 for the first
    gap : (n,) how many rows ago that was, rows that do not count included
    """

    before: NDArray[np.int64]
    gap: NDArray[np.int64]

    @classmethod
    def from_runs(cls, run: NDArray[np.int64], rows: NDArray[np.int64]) -> "RowOrder":
        """Return the chain of `rows`, places that rise among all, whose sessions are numbered `run`."""
        if not rows.size:
            return cls(rows, rows)
        same = np.concatenate([[False], run[rows[1:]] == run[rows[:-1]]])
        return cls(np.where(same, np.arange(rows.size) - 1, -1), np.concatenate([[1], np.diff(rows)]))

    def innovations(self, values: Array, memory: float) -> Array:
        """Return what is new in each row, (n, ...), where noise fades by `memory` from row to row."""
        if memory == 0.0:
            return values
        fade = np.where(self.before >= 0, memory**self.gap, 0.0).reshape(-1, *[1] * (values.ndim - 1))
        return np.asarray((values - fade * values[self.before]) / np.sqrt(1.0 - fade**2))

    def slowness(self, columns: Array) -> float:
        """Return how alike neighboring rows are in columns (3 n, q), on average over their directions: at most 1."""
        basis = orthonormal(columns)
        rows, later = basis.reshape(self.before.size, 3, -1), np.flatnonzero(self.before >= 0)
        return float((rows[later] * rows[self.before[later]]).sum() / max(basis.shape[1], 1))


@dataclass(frozen=True, eq=False)
class NoiseFit:
    """Winsorized residuals.

    Attributes
    ----------
    residual : (n, 3) whitened
    scale : (3,) size of their noise
    memory, memory_std : correlation of neighboring rows, and how well it is known
    tail : reciprocal degrees of freedom of Student's t that the readings follow
    dof : degrees of freedom behind `scale`
    outlier : (n,) rows that should not count
    """

    residual: Array = field(repr=False)
    scale: Array
    memory: float
    memory_std: float
    tail: float
    dof: float
    outlier: Mask

    def trusted_dof(self, slowness: float = 1.0) -> float:
        """Degrees of freedom for rare events: what winsorized tails, and a memory half known, leave of them.

        What changes slowly from row to row has noise of a variance of (1 + r)/(1 - r) where rows remember by r; what
        is as much up as down, of slowness 0, does not mind.
        """
        slow = 2.0 * (slowness * self.memory_std / (1.0 - self.memory**2)) ** 2
        speaks = self.memory**2 / (self.memory**2 + self.memory_std**2) if self.memory > 0.0 else 0.0
        unknown = (1.0 + _RARE * self.tail) / self.dof + slow * speaks
        return 1.0 / unknown if unknown > 0.0 else np.inf


def clean(residual: Array, used: Mask, basis: Array, chain: RowOrder, declared: Mask) -> NoiseFit:
    """Draw in residuals.

    Parameters
    ----------
    residual, used : (n, 3) whitened residuals, and which of them were measured
    basis : (n, 3, q) all that effects, calibration and smooth functions could make of them
    chain : the rows' order
    declared : (3,) channels whose noise is declared: that is worth some degrees of freedom
    """
    q = orthonormal(basis.reshape(used.size, -1) * used.reshape(-1, 1))
    good, q = _without_outliers(residual, used, q)
    fit, scale, nu = _student(residual, good, q)
    off = residual - fit
    outlier: Mask = np.asarray(used.any(axis=1) & ~good.any(axis=1))
    u = off / scale
    winsorized = np.where(good, scale * u * (nu + 3.0) / (nu + u**2), 0.0)  # psi over its mean slope, (nu+1)/(nu+3)
    scale, dof = _scale(winsorized, good, q, declared)
    memory = _memory(winsorized / scale, good, q, chain)
    return NoiseFit(np.where(good, fit + winsorized, 0.0), scale, *memory, 1.0 / nu, dof, outlier)


def orthonormal(columns: Array) -> Array:
    """Return an orthonormal basis (m, r) of the span of columns (m, q)."""
    size = np.sqrt((columns**2).sum(axis=0))
    columns = columns[:, size > 0.0] / size[size > 0.0]
    if not columns.shape[1]:
        return np.zeros((len(columns), 0))
    values, vectors = np.linalg.eigh(columns.T @ columns)
    seen = values > _SMALL * values[-1]
    found = (columns @ vectors[:, seen]) / np.sqrt(values[seen])
    return np.linalg.qr(found)[0]


def _without_outliers(residual: Array, used: Mask, q: Array) -> tuple[Mask, Array]:
    """Return which readings are left, (n, 3), and their basis, when rows far out are taken away one by one.

    A row is judged by what its removal takes off the sum of squares: a row that alone speaks for something would
    otherwise draw the fit to itself and hide. Of very many rows a few at a time are taken, none of which moves the fit.
    """
    good, left = used.copy(), int(_MOST * len(residual))
    together = len(residual) // _SHARE if len(residual) > _ONE_BY_ONE else 1
    while left > 0:
        flat = np.where(good, residual, 0.0).ravel()
        lost = q.shape[1] / max(int(good.sum()), 1)
        off = np.where(good, (flat - q @ (q.T @ flat)).reshape(-1, 3), 0.0)
        scale = _spread(off / np.sqrt(max(1.0 - lost, 0.1)), good)
        gain = removal(off, q, scale)
        worst = np.argsort(-gain)[: min(together, left)] if together > 1 else np.argmax(gain, keepdims=True)
        worst = worst[gain[worst] >= _OUTLIER**2]
        if not worst.size:
            break
        good[worst], left = False, left - worst.size
        q = orthonormal(q * good.reshape(-1, 1))
    return good, q


def removal(residual: Array, q: Array, scale: Array | float = 1.0, below: int = 0) -> Array:
    """Return what the removal of each row takes off the sum of squares that a basis (3 n, q) leaves, (n,).

    scale : of the noise by channel, where that is not 1
    below : how many residuals of priors stand below those of the rows
    """
    count = residual.size - below
    off = (residual.ravel() - q @ (q.T @ residual.ravel()))[:count].reshape(-1, 3)
    rows = q[:count].reshape(-1, 3, q.shape[1])
    left = (1.0 + _ALMOST) * np.eye(3) - rows @ rows.transpose(0, 2, 1)
    return np.asarray((off * np.linalg.solve(left, off[:, :, None])[:, :, 0] / scale**2).sum(axis=1))


def _student(residual: Array, good: Mask, q: Array) -> tuple[Array, Array, float]:
    """Return fit (n, 3), scale (3,) and degrees of freedom of Student's t, by reweighting.

    The tail is estimated from plain least squares: a robust fit of many columns makes any residual look heavy-tailed.
    """
    mask, flat = good.ravel(), np.where(good, residual, 0.0).ravel()
    inflate = np.sqrt(max(mask.sum(), 1) / max(mask.sum() - q.shape[1], 1))
    fit = q @ (q.T @ flat)
    off = inflate * np.where(good, (flat - fit).reshape(-1, 3), 0.0)
    nu, scale = _tail(off, good, _spread(off, good))
    for _ in range(_ROUNDS if nu < _TAILS[-1] else 1):
        weight = np.where(good, (nu + 1.0) / (nu + (off / scale) ** 2), 0.0)
        half = np.sqrt(weight).ravel()
        fit = q @ np.linalg.lstsq(half[:, None] * q, half * flat, rcond=None)[0] if q.shape[1] else fit
        off = inflate * np.where(good, (flat - fit).reshape(-1, 3), 0.0)
        before, scale = scale, _widths(off, good, scale, nu)
        if np.allclose(scale, before, rtol=1e-3):
            break
    return fit.reshape(-1, 3), scale, nu


def _spread(off: Array, good: Mask) -> Array:
    """Return a first scale by channel: the root mean square of what is within three of it, from the median on."""
    found = np.ones(3)
    for channel in np.flatnonzero(good.any(axis=0)):
        size = np.abs(off[good[:, channel], channel])
        scale = MEDIAN_TO_SIGMA * float(np.median(size))
        for _ in range(3):
            inside = size[size <= 3.0 * scale]
            scale = _WITHIN_THREE * float(np.sqrt(np.mean(inside**2))) if inside.size else scale
        found[channel] = scale
    return np.maximum(found, 1e-6)


def _widths(off: Array, good: Mask, scale: Array, nu: float) -> Array:
    """Return the next scale by channel of Student's t."""
    weight = np.where(good, (nu + 1.0) / (nu + (off / scale) ** 2), 0.0)
    count = good.sum(axis=0)
    found = np.sqrt((weight * off**2).sum(axis=0) / np.maximum(count, 1))
    return np.where(count > 0, np.maximum(found, 1e-6), 1.0)


def _tail(off: Array, good: Mask, scale: Array) -> tuple[float, Array]:
    """Return the likeliest of the tails, with its scale."""
    best = (-np.inf, _TAILS[-1], scale)
    for nu in _TAILS[::-1]:
        width = scale
        for _ in range(5):
            width = _widths(off, good, width, nu)
        density = -np.log(width) - 0.5 * (nu + 1.0) * np.log1p((off / width) ** 2 / nu) + _NORM[nu]
        gain = float(density[good].sum()) - best[0]
        if gain > (_HEAVIER if nu < _TAILS[-1] else 0.0):
            best = (best[0] + gain if np.isfinite(best[0]) else float(density[good].sum()), nu, width)
    return best[1], best[2]


def _norm(nu: float) -> float:
    from math import lgamma, log, pi

    return lgamma(0.5 * (nu + 1.0)) - lgamma(0.5 * nu) - 0.5 * log(nu * pi)


_NORM = {nu: _norm(nu) for nu in _TAILS}


def _scale(winsorized: Array, good: Mask, q: Array, declared: Mask) -> tuple[Array, float]:
    """Return the size of the noise by channel, (3,), and the degrees of freedom behind it."""
    lost = (q**2).sum(axis=1).reshape(-1, 3)
    dof = np.array([float((1.0 - lost[good[:, c], c]).sum()) for c in range(3)])
    known = np.where(declared, _DECLARED_DOF, 0.0)
    squares = np.where(good, winsorized**2, 0.0).sum(axis=0)
    total = known + dof
    pooled = float((known + squares).sum() / max(total.sum(), 1e-9)) if total.sum() > 0.0 else 1.0
    share = total / (total + 4.0)  # what little a channel knows leans on the others
    mean = np.where(total > 0.0, (known + squares) / np.maximum(total, 1e-9), pooled)
    return np.sqrt(np.maximum(share * mean + (1.0 - share) * pooled, 1e-12)), max(float(total.sum()), 1.0)


def _memory(unit: Array, good: Mask, q: Array, chain: RowOrder) -> tuple[float, float]:
    """Return the correlation of neighboring rows, none below 0, and its standard deviation.

    By moments: with M what the fit leaves of the noise and A half of one for neighbors, e'Ae / e'e is in the mean
    (tr MA + 2 r tr MAMA) / (tr M + 2 r tr MA) for a small correlation r.
    """
    later = np.flatnonzero((chain.before >= 0) & (chain.gap == 1))
    earlier = chain.before[later]
    both = good[later] & good[earlier]
    if int(both.sum()) < _FEWEST_PAIRS:
        return 0.0, 0.0
    rows = q.reshape(*unit.shape, -1)
    neighbors = np.zeros_like(rows)
    neighbors[later] += 0.5 * rows[earlier] * both[:, :, None]
    neighbors[earlier] += 0.5 * rows[later] * both[:, :, None]
    flat, fitted = neighbors.reshape(unit.size, -1), q.T @ neighbors.reshape(unit.size, -1)
    first = -float(np.trace(fitted))
    second = 0.5 * float(both.sum()) - 2.0 * float((flat**2).sum()) + float((fitted**2).sum())
    squares, dof = float((unit[good] ** 2).sum()), float(good.sum()) - q.shape[1]
    ratio = float((unit[later] * unit[earlier] * both).sum()) / max(squares, 1e-300)
    slope = 2.0 * (second - ratio * first)
    if second <= 0.0 or slope <= 0.0:
        return 0.0, 0.0
    found = (ratio * dof - first) / slope
    return float(np.clip(found, 0.0, _LARGEST_MEMORY)), float(1.0 / np.sqrt(2.0 * second))
