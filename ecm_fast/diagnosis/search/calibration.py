"""Calibration without any effect: the baseline that every effect has to beat."""

import numpy as np
from numpy.typing import NDArray

from ...errors import NotConverged
from ...identification.least_squares import Loss, minimize
from ...identification.noise import ReadingNoise
from ...identification.rows import FitRows, State
from ..problem.problem import Problem
from ..problem.stiffness_scale import Scales

__all__ = ["calibrate"]

Array = NDArray[np.float64]

_NEAR = 0.1  # share of the range: how far the first step may go
_ROUNDS = 4  # rounds of calibration and noise; three are usual
_SAME = 0.05  # per cent: parameters that moved less are those of the round before


def calibrate(problem: Problem) -> tuple[dict[str, float], ReadingNoise]:
    """Return the calibrated parameters by key, and what is known of the noise.

    Raises
    ------
    NotConverged : the mechanism has no stable equilibrium under any of the loads.
    """
    rows = problem.solver((), problem.open)
    lower, upper = rows.bounds()
    values = np.clip(problem.start(problem.keys), lower, upper)
    noise = problem.noise(problem.rows.at(values))
    state = rows.at(values)
    for _ in range(_ROUNDS):
        if not state.stable.any():
            raise NotConverged(f"{problem.data[0].source}: no row has a stable equilibrium on this mechanism")
        before = values
        problem.progress.step(problem.open.size, "calibration")
        values = _fit(problem, rows, noise, state, values, (lower, upper))
        state = rows.at(values)
        if np.all(np.abs(values - before) <= _SAME * 1e-2 * np.maximum(np.abs(values), 1e-9)):
            break
    return dict(zip(problem.keys, values.tolist(), strict=True)), noise


def _fit(
    problem: Problem, rows: FitRows, noise: ReadingNoise, state: State, start: Array, bounds: tuple[Array, Array]
) -> Array:
    use, places = state.stable, problem.open[state.stable]
    weights = problem.weights(noise, state.among(problem.rows.n, problem.open))
    used, whitening, measured = problem.wanted[places], weights.whitening[places], problem.rows.measured[places]

    scales = Scales.from_start(problem.keys, problem.start(problem.keys))

    def residuals(moved: Array) -> tuple[Array, Array] | None:
        values, slope = scales.values(moved), scales.slope(moved)
        moved_state = rows.at(values)
        if not moved_state.stable[use].all():
            return None
        off = np.where(used, measured - moved_state.pose[use], 0.0)
        by = -(whitening @ moved_state.by[use]).reshape(-1, len(values))
        by_priors, by_prior = problem.prior.rows(values)
        return np.concatenate([(whitening @ off[:, :, None]).ravel(), by_priors]), np.vstack([by, by_prior]) * slope

    first, limits = scales.moved(start), scales.bounds(*bounds)
    return scales.values(
        minimize(residuals, first, *limits, Loss("huber", 1.5), problem.prior.known.size, near=_NEAR).values
    )
