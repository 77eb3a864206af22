"""The error on the hold-out rows before and after an effect is added, beside the noise floor."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...identification.rows import State
from ..problem.holdout import regions
from ..problem.problem import Problem, Weights
from ..results.diagnosis import HoldoutMisfit, Rms

__all__ = ["Residuals", "gap"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_DRAWS = 400  # resamples; ends of a 90 % interval are then known to 1 % in rank
_OUTLIER, _FEW = 8.0, 0.1  # sigmas, and the share of rows up to which they are outliers and not the model's failure


@dataclass(frozen=True, eq=False)
class Residuals:
    """Residuals of some rows: measured less predicted as given, before and after, and their noise.

    Attributes
    ----------
    given, before, after : (n, 3) [m, m, rad], nan where not measured
    weights : of all rows
    scale : (3,) noise seen over noise assumed
    without : as `after`, by name, where one of two effects is left out
    """

    given: Array
    before: Array
    after: Array
    weights: Weights
    scale: Array
    without: Mapping[str, Array] = field(default_factory=dict)

    @classmethod
    def from_states(
        cls,
        problem: Problem,
        before: State,
        after: State,
        weights: Weights,
        scale: Array,
        without: Mapping[str, State] | None = None,
    ) -> "Residuals":
        """Return the residuals of all rows in these states, and of the mechanism as it is given."""
        blank = np.where(problem.wanted, problem.rows.measured, np.nan)
        given = problem.state((), {}).pose
        lacking = {name: blank - state.pose for name, state in (without or {}).items()}
        return cls(blank - given, blank - before.pose, blank - after.pose, weights, scale, lacking)

    def whitened(self, residual: Array) -> Array:
        """Return residuals in units of the noise, (n, 3), nan where there is none."""
        known = np.isfinite(residual)
        out = (self.weights.whitening @ np.where(known, residual, 0.0)[:, :, None])[:, :, 0] / self.scale
        return np.where(known, out, np.nan)

    def spread(self) -> Array:
        """Return the noise of every reading, that of the forces included, (n, 3) [m, m, rad]."""
        w = self.weights.whitening
        good = np.isfinite(self.before) & (np.abs(w).sum(axis=(1, 2)) > 0.0)[:, None]
        full = w.copy()
        full[:, range(3), range(3)] = np.where(w[:, range(3), range(3)] == 0.0, 1.0, w[:, range(3), range(3)])
        root = np.linalg.inv(full) * self.scale
        return np.where(good, np.sqrt((root**2).sum(axis=2)), np.nan)


def gap(
    problem: Problem, opened: Residuals, rows: Mask, what: str, seed: int
) -> tuple[HoldoutMisfit | None, NDArray[np.int64]]:
    """Return the error on some rows, and those of them that are outliers."""
    after = opened.whitened(opened.after)
    use = rows & np.isfinite(after).any(axis=1)
    far = use & (np.nanmax(np.where(np.isfinite(after), np.abs(after), 0.0), axis=1) > _OUTLIER)
    if far.sum() > max(_FEW * use.sum(), 1.0):
        far = np.zeros_like(far)
    use &= ~far
    if not use.any():
        return None, np.flatnonzero(far)
    blocks = _blocks(problem)[use]
    given, first, second, *fewer = (
        _rms(raw[use], opened.whitened(raw)[use], blocks, seed)
        for raw in (opened.given, opened.before, opened.after, *opened.without.values())
    )
    noise = _rms(opened.spread()[use], np.where(np.isfinite(after[use]), 1.0, np.nan), blocks, seed)
    excess = first.sigma**2 - 1.0
    closed = float(1.0 - max(second.sigma**2 - 1.0, 0.0) / excess) if excess > 0.0 else float("nan")
    without = dict(zip(opened.without, fewer, strict=True))
    return HoldoutMisfit(int(use.sum()), what, given, first, second, noise, closed, without=without), np.flatnonzero(
        far
    )


def _rms(raw: Array, white: Array, blocks: NDArray[np.int64], seed: int) -> Rms:
    """Return root mean squares, the interval from blocks of rows drawn again."""
    with np.errstate(invalid="ignore", divide="ignore"):
        size = np.sqrt(np.nansum(raw**2, axis=0) / np.isfinite(raw).sum(axis=0))
    groups = int(blocks.max()) + 1
    squares = np.bincount(blocks, np.nansum(white**2, axis=1), groups)
    counts = np.bincount(blocks, np.isfinite(white).sum(axis=1), groups)
    drawn = np.random.default_rng(seed).integers(groups, size=(_DRAWS, groups))
    means = np.sqrt(squares[drawn].sum(axis=1) / np.maximum(counts[drawn].sum(axis=1), 1.0))
    low, high = np.quantile(means, [0.05, 0.95])
    x, z, theta = size.tolist()
    return Rms(x, z, theta, float(np.sqrt(squares.sum() / counts.sum())), (float(low), float(high)))


def _blocks(problem: Problem) -> NDArray[np.int64]:
    """Return a number for each load of each region and session: rows that may share an error, (n,)."""
    region = np.concatenate([regions(part) for part in problem.data])
    label = np.concatenate([part.pose_id for part in problem.data])
    alone = np.array([f"row {i}" for i in range(label.size)])
    keys = np.rec.fromarrays([problem.run, region, np.where(label == "", alone, label)])
    return np.asarray(np.unique(keys, return_inverse=True)[1])
