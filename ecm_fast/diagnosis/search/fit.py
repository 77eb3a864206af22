"""The full nonlinear fit of one explanation together with the calibration."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...identification.least_squares import Minimum, minimize
from ...identification.rows import State
from ..problem.linearization import Linearization
from ..problem.problem import Problem
from ..problem.stiffness_scale import Scales
from ..statistics.priors import size_factor
from .law_variants import FRAME, bent, zeroing

__all__ = ["Fit", "refit"]

Array = NDArray[np.float64]

_NEAR = 0.05  # standard deviations
_FEW, _MOST = 4, 12  # solutions of all rows; where these do not do, the law is not smooth in a further parameter
_FAR = 8.0  # prior standard deviations that a start may be away from none
_NEARER = (0.5, 0.25)  # shares of the way from the view to a start where the neck has no stable equilibrium, tried next


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted explanation.

    Attributes
    ----------
    model : places of its candidates
    keys : of what was fitted: calibrated parameters, then the effects'
    values : (p,) in that order
    covariance : (p, p)
    total : weighted sum of squares, priors included
    settled : whether that is the minimum
    build : dimensions by key, as the fit has them within their tolerances
    share : by which the laws of its effects were allowed to differ from the catalogue's; none where they were not
    bent : by which they do, as a share of the effects
    words : what the largest part of that goes with
    evidence : less that of the fit without effects gives twice the logarithm of their ratio
    """

    model: tuple[int, ...]
    keys: tuple[str, ...]
    values: Array
    covariance: Array = field(repr=False)
    total: float
    evidence: float
    settled: bool
    build: Mapping[str, float] = field(default_factory=dict)
    share: float | None = None
    bent: float = 0.0
    words: str = ""

    @property
    def varied(self) -> bool:
        """Whether the law of its effect differs from the catalogue's, or the camera was zeroed at rest."""
        return self.bent > 0.0 or (self.share is not None and not set(FRAME).isdisjoint(self.build))

    def by_key(self) -> dict[str, float]:
        """Return the values by key."""
        return dict(zip(self.keys, self.values.tolist(), strict=True))

    def as_built(self) -> dict[str, float]:
        """Return the values by key of all that the fit moves in the mechanism, dimensions among it."""
        return {**self.by_key(), **self.build}

    def state(self, problem: Problem) -> State:
        """Return all rows of a problem as this explanation has them."""
        values = self.as_built()
        return problem.state(tuple(values), values)


def refit(view: Linearization, model: tuple[int, ...], start: Mapping[str, float], limit: float = np.inf) -> Fit:
    """Fit an explanation to the cleaned residuals of a view.

    Parameters
    ----------
    view : whose weights and cleaned residuals count
    model : places of the candidates
    start : values by key, where the mechanism's own will not do
    limit : sum of squares that the first few steps must come below for more to be taken
    """
    problem = view.problem
    members = [problem.candidates[i] for i in model]
    solver = problem.solver(problem.keys_of(model), view.rows)
    problem.progress.step(len(view.rows), " and ".join(member.name for member in members) or "no effect")
    p = len(solver.names)
    calibrated = len(problem.keys)
    prior = problem.prior.extended(
        [value for member in members for value in member.start], [std for member in members for std in member.spread]
    )
    lower, upper = solver.bounds()
    plain = problem.start(solver.names)
    first = np.array([start.get(key, float(value)) for key, value in zip(solver.names, plain, strict=True)])
    reach = _FAR * prior.std[calibrated:]
    first[calibrated:] = np.clip(
        first[calibrated:], prior.center[calibrated:] - reach, prior.center[calibrated:] + reach
    )
    hidden = view.hidden_of(model, dict(zip(solver.names, first.tolist(), strict=True)))
    shift, shifts = view.flat(hidden), hidden.shape[2]
    by_shift = np.eye(shifts, p + shifts, p)
    whitening, pose = view.whitening, view.state.pose[view.rows]

    scales, tried = Scales.from_start(solver.names, plain), 0
    least = np.inf

    def residuals(all_moved: Array) -> tuple[Array, Array] | None:
        nonlocal tried, least
        tried += 1
        values, slope = scales.values(all_moved[:p]), scales.slope(all_moved[:p])
        state = solver.at(values) if tried <= (_MOST if least < limit else _FEW) else None
        if state is None or not state.stable.all():
            return None
        moved = (whitening @ (pose - state.pose)[:, :, None])[:, :, 0]
        off = view.flat(view.cleaned.residual + moved) - shift @ all_moved[p:]
        by = -np.hstack([view.flat(whitening @ np.ascontiguousarray(state.by)), shift])
        from_prior, by_prior = prior.rows(values)
        least = min(least, float(off @ off))
        by = np.vstack([by, np.pad(by_prior, ((0, 0), (0, shifts))), by_shift])
        return np.concatenate([off, from_prior, all_moved[p:]]), by * np.concatenate([slope, np.ones(shifts)])

    wide = np.full(shifts, np.inf)
    at_view = np.array([view.values.get(key, float(value)) for key, value in zip(solver.names, plain, strict=True)])
    no_effect = np.concatenate([at_view[:calibrated], plain[calibrated:]])
    for values in (first, *(at_view + share * (first - at_view) for share in _NEARER), no_effect):
        begin, tried = np.concatenate([scales.moved(np.clip(values, lower, upper)), np.zeros(shifts)]), 0
        if residuals(begin) is not None:
            break
    else:
        return Fit(model, tuple(solver.names), no_effect, np.full((p, p), np.inf), np.inf, -np.inf, settled=False)
    lower, upper = scales.bounds(lower, upper)
    found = minimize(residuals, begin, np.concatenate([lower, -wide]), np.concatenate([upper, wide]), near=_NEAR)
    laws = shifts - view.weights.shift.shape[2] - view.weights.build.shape[2]
    return _judged(found, view, model, tuple(solver.names), scales, laws)


def _judged(
    minimum: Minimum, view: Linearization, model: tuple[int, ...], keys: tuple[str, ...], scales: Scales, laws: int
) -> Fit:
    """Return the fit with its evidence, Laplace's approximation: the calibrated parameters' own share cancels."""
    p, calibrated, members = len(keys), len(view.problem.keys), [view.problem.candidates[i] for i in model]
    scale = np.sqrt((minimum.jacobian**2).sum(axis=0))
    scale[scale == 0.0] = 1.0
    normal = (minimum.jacobian / scale).T @ (minimum.jacobian / scale)
    values, vectors = np.linalg.eigh(normal)
    covariance = (vectors / np.maximum(values, 1e-12)) @ vectors.T / np.outer(scale, scale)
    spread = np.array([std for member in members for std in member.spread])
    posterior = covariance[calibrated:p, calibrated:p] / np.outer(spread, spread)
    evidence = -minimum.total
    if posterior.size:
        first = p + view.weights.shift.shape[2]
        own = [*range(calibrated, p), *range(first, first + laws)]
        unit = np.concatenate([spread, np.ones(laws)])
        evidence += float(np.linalg.slogdet(covariance[np.ix_(own, own)] / np.outer(unit, unit))[1])
        sizes = np.cumsum([0, *(len(member.keys) for member in members)])[:-1]
        start = np.array([value for member in members for value in member.start])
        size = ((minimum.values[calibrated:p] - start) / spread)[sizes]
        std = np.sqrt(np.diag(posterior))[sizes]
        evidence += float(size_factor(size, std, np.array([member.one_sided for member in members])).sum())
    slope = scales.slope(minimum.values[:p])
    covariance = covariance[:p, :p] * np.outer(slope, slope)
    fitted, build = _with_build(scales.values(minimum.values[:p]), keys, view, minimum.values[p:])
    amplitudes = minimum.values[p + view.weights.shift.shape[2] :][:laws]
    at = dict(zip(keys, fitted.tolist(), strict=True))
    build |= zeroing(view, model, at, amplitudes)
    share, words = bent(view, model, at, amplitudes)
    return Fit(model, keys, fitted, covariance, minimum.total, evidence, minimum.settled, build, view.share,
               share, words)  # fmt: skip


def _with_build(
    values: Array, keys: tuple[str, ...], view: Linearization, hidden: Array
) -> tuple[Array, dict[str, float]]:
    """Return the fitted values, and the dimensions that are none of them, with what hides in the build added."""
    problem, toleranced = view.problem, view.toleranced
    moves = hidden[hidden.size - len(toleranced) :] * [problem.tolerances[key] for key in toleranced]
    for key, move in zip(toleranced, moves.tolist(), strict=True):
        if key in keys:
            values[keys.index(key)] += move
    moved = zip(toleranced, (problem.start(toleranced) + moves).tolist(), strict=True)
    return values, {key: value for key, value in moved if key not in keys}
