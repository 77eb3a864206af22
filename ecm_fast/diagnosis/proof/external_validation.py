"""External validation: whether an effect carries over to experiments that were not fitted.

Both models predict such an experiment as they stand. Where the one with what was found misses it, but would not if the
fitted parameters moved within their doubt, the experiment asks for another calibration before it asks for another
effect.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...identification.noise import RESIDUAL
from ...identification.rows import State
from ..problem.problem import Problem
from ..results.diagnosis import Noise
from ..results.external_validation import Transfer, allowed
from ..search.fit import Fit
from ..search.result import Selection
from .holdout_error import Residuals, gap

__all__ = ["transfer"]

Array = NDArray[np.float64]

_RIVALS = 5  # runners-up that are tried on the test file


def transfer(test: Problem, selection: Selection, noise: Noise, seed: int) -> Transfer | None:
    """Return the residuals on an experiment that was never fitted; None where no reading of it can be used.

    Parameters
    ----------
    test : the problem of that experiment alone
    found : in the data that were fitted
    noise : of these data
    seed : of the blocks that are drawn again
    """
    before, after = (fit.state(test) for fit in (selection.null, selection.best))
    known = test.noise(test.rows.at(test.start(test.keys)))
    sigma = np.where(known.origin == RESIDUAL, np.asarray(noise.sigma), known.sigma)  # else it would fit by definition
    known = replace(known, sigma=np.where(sigma > 0.0, sigma, known.sigma))
    opened = Residuals.from_states(test, before, after, test.weights(known, after), np.maximum(selection.scale, 1.0))
    part = test.data[0]
    shown_gap, far = gap(test, opened, np.ones(part.n, dtype=bool), part.source, seed)
    if shown_gap is None:
        return None
    whitened = opened.whitened(opened.after)
    whitened[far] = np.nan
    adapted, count = _adapted(opened, after, selection.best, whitened), int(np.isfinite(whitened).sum())
    return Transfer(
        **vars(shown_gap),
        allowed=allowed(count),
        adapted=adapted,
        left_out=int(far.size),
        rivals=tuple(_rivals(test, selection, opened, far)),
    )


def _rivals(
    test: Problem, selection: Selection, opened: Residuals, far: NDArray[np.int64]
) -> Iterator[tuple[str, float]]:
    """Yield the next best explanations and what they leave of the experiment [sigma]."""
    for fit in selection.runners_up[:_RIVALS]:
        whitened = opened.whitened(test.rows.measured - fit.state(test).pose)
        whitened[far] = np.nan
        yield " with ".join(selection.names(fit)), float(np.sqrt(np.nanmean(whitened**2)))


def _adapted(opened: Residuals, after: State, fit: Fit, whitened: Array) -> float:
    """Return the root mean square [sigma] that is left where the fitted parameters move within their doubt.

    Its square times the number of readings is the smallest |r - J d|^2 + d^T C^-1 d, chi squared where all is right.
    """
    use = np.isfinite(whitened)
    by = (opened.weights.whitening @ np.nan_to_num(after.by[:, :, : len(fit.keys)])) / opened.scale[:, None]
    jacobian, residual = by[use], whitened[use]
    value, vector = np.linalg.eigh(fit.covariance)
    root = jacobian @ (vector * np.sqrt(np.maximum(value, 0.0)))
    step = np.linalg.solve(np.eye(root.shape[1]) + root.T @ root, root.T @ residual)
    return float(np.sqrt((residual @ residual - (root.T @ residual) @ step) / residual.size))
