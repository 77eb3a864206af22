"""Model discrepancy: a smooth wrench at the tip that no parameter of the model explains."""

import numpy as np
from numpy.typing import NDArray

from ..problem.linearization import Linearization
from ..problem.problem import Problem
from ..problem.trends import coordinates
from ..results.diagnosis import Remainder
from ..statistics.robust_noise import orthonormal
from .holdout_error import Residuals

__all__ = ["remainder"]

Array = NDArray[np.float64]

_LENGTHS = (0.25, 0.5, 1.0, 2.0)  # correlation lengths tried, in ranges of the loads
_NOISES = (0.03, 0.1, 0.3, 1.0, 3.0)  # noises tried, in standard deviations of what is left
_ROWS = 1500
"""Rows that a smooth function goes through at most, evenly over the order of measurement."""


def remainder(
    problem: Problem, view: Linearization, opened: Residuals, compliance: Array, locked: NDArray[np.bool_]
) -> Remainder:
    """Return what is left around a view as a Gaussian process over the loads.

    Its lengths and size are those of the largest likelihood; what parameters of the model could make is taken off
    first, so that it never competes with them.
    """
    place = coordinates(problem.data)
    white = opened.whitened(opened.after)
    fit = np.zeros(len(place), dtype=bool)
    fit[view.rows] = view.used.all(axis=1)
    columns = np.concatenate([view.nuisances[0], view.sizes[:, :, list(view.model)], view.further], axis=2)
    whole = view.used.all(axis=1)
    scaled = columns[whole] / opened.scale[:, None]
    base = orthonormal(scaled.reshape(3 * len(scaled), columns.shape[2]))  # no row may be whole
    flat = white[fit].ravel()
    off = (flat - base @ (base.T @ flat)).reshape(-1, 3)
    some = np.unique(np.linspace(0, len(off) - 1, min(len(off), _ROWS)).round().astype(int))
    fitted = _process(place[fit][some], off[some], place)
    to_pose = np.linalg.pinv(opened.weights.whitening)
    pose = (to_pose @ (fitted * opened.scale)[:, :, None])[:, :, 0]
    good = np.isfinite(compliance).all(axis=(1, 2))
    wrench = np.full_like(pose, np.nan)
    wrench[good] = np.linalg.solve(compliance[good], pose[good][:, :, None])[:, :, 0]
    test = locked & np.isfinite(white).all(axis=1)
    before = float((white[test] ** 2).sum()) - 3.0 * test.sum()
    after = float(((white[test] - fitted[test]) ** 2).sum()) - 3.0 * test.sum()
    closed = 1.0 - max(after, 0.0) / before if before > 0.0 else np.nan
    group, cosine = _resembles(view)
    return Remainder(wrench, float(max(closed, 0.0)), group, cosine)


def _process(place: Array, values: Array, wanted: Array) -> Array:
    """Return a Gaussian process through noisy values (n, 3), at other places, channel by channel."""
    out = np.zeros((len(wanted), 3))
    if len(place) < 4:
        return out
    for channel in range(3):
        best, chosen = -np.inf, (1.0, 1.0)
        y = values[:, channel]
        for length in _LENGTHS:
            spectrum, basis = np.linalg.eigh(_kernel(place, place, length))
            turned = (basis.T @ y) ** 2
            for size in _NOISES:
                variance = size * np.maximum(spectrum, 0.0) * len(y) / 10.0 + 1.0
                likelihood = -0.5 * float((turned / variance).sum() + np.log(variance).sum())
                if likelihood > best:
                    best, chosen = likelihood, (length, size * len(y) / 10.0)
        length, size = chosen
        inner = size * _kernel(place, place, length) + np.eye(len(y))
        out[:, channel] = size * _kernel(wanted, place, length) @ np.linalg.solve(inner, y)
    return out


def _kernel(a: Array, b: Array, length: float) -> Array:
    squares = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2.0 * a @ b.T
    return np.asarray(np.exp(-0.5 * np.maximum(squares, 0.0) / length**2))


def _resembles(view: Linearization) -> tuple[str, float]:
    """Return the group of the effect whose signature is nearest to the residual, and their cosine."""
    gram = view.rest[2]
    norm = gram.norm
    size = np.sqrt(max(gram.left, 1e-300))
    cosine = np.abs(np.divide(gram.score, norm * size, out=np.zeros_like(norm), where=norm > 0.0))
    nearest = int(np.argmax(cosine))
    return view.problem.candidates[nearest].effect.group, float(min(cosine[nearest], 1.0))
