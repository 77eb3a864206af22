"""Linearization of the problem at one parameter vector: cleaned residuals and the signatures of all effects."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...errors import NotConverged
from ...identification.noise import DECLARED, ReadingNoise
from ...identification.rows import State
from ..results.diagnosis import LackOfFit
from ..statistics.evidence import EvidenceMatrix
from ..statistics.lack_of_fit import NAMED, SMOOTH, score_test, trend_test
from ..statistics.robust_noise import NoiseFit, RowOrder, clean, orthonormal
from .candidates import EffectCandidate
from .law_tolerance import POSITION_ANGLE, law_columns, modulations
from .problem import Problem, Weights
from .stiffness_scale import STIFFNESS_KEYS
from .trends import smooth_columns

__all__ = ["Linearization"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_SATURATED = 3.0
"""Directions in which effects of this many prior standard deviations are below the noise count as noise."""
_FAR = 2.0  # prior standard deviations that the linear model is trusted
_SHARE = 6  # readings for every direction of effects that noise is measured beside


@dataclass(frozen=True, eq=False)
class Linearization:
    """The linear model around `values` of calibrated parameters and of the effects in `model`.

    Attributes
    ----------
    problem : what is looked at
    model : places of the candidates that are in the model
    values : by key, of all that was fitted
    state : poses and derivatives by `keys`, nan in rows that are locked or without a measured pose
    keys : calibrated parameters, sizes of all candidates, further parameters of the model's and of those in `values`,
        other dimensions that have a tolerance
    noise, weights : what is known before the fit, and what follows from it here
    rows : places of the rows that count
    chain : their order
    cleaned : their residuals, winsorized, outliers left out
    smooth : functions (all rows, q) that a disagreement without a name may follow, and of which kind each one is
    share : by which the laws of the model's effects may differ from the catalogue's, see `law_tolerance`; none where
        they are taken as they are
    """

    problem: Problem
    model: tuple[int, ...]
    values: Mapping[str, float]
    state: State
    keys: tuple[str, ...]
    noise: ReadingNoise
    weights: Weights
    rows: NDArray[np.int64]
    chain: RowOrder
    cleaned: NoiseFit
    outliers: NDArray[np.int64]
    smooth: tuple[Array, NDArray[np.int64]] = field(repr=False)
    share: float | None = None

    @classmethod
    def at(
        cls,
        problem: Problem,
        values: Mapping[str, float],
        model: tuple[int, ...],
        noise: ReadingNoise,
        *,
        known: bool = False,
        share: float | None = None,
    ) -> "Linearization":
        """Look at the rows that are not locked from `values`; with `known` noise the residuals tell nothing of it."""
        more = [
            key
            for i, candidate in enumerate(problem.candidates)
            for key in candidate.keys[1:]
            if i in model or key in values
        ]
        sizes = [candidate.keys[0] for candidate in problem.candidates]
        toleranced = [key for key in problem.tolerances if key not in sizes]
        solver = problem.solver((*sizes, *more, *toleranced), problem.open)
        at = problem.start(solver.names)
        at = np.array([values.get(key, float(value)) for key, value in zip(solver.names, at, strict=True)])
        problem.progress.step(problem.open.size, "derivatives by all effects")
        state = solver.at(at).among(problem.rows.n, problem.open)
        if not state.stable.any():
            raise NotConverged("no row has a stable equilibrium on this mechanism")
        weights, rows = problem.weights(noise, state, solver.names), np.flatnonzero(state.stable)
        smooth = smooth_columns(problem.data, state.stable)
        draft = cls(problem, model, values, state, solver.names, noise, weights, rows, problem.chain(rows),
                    _NOTHING, rows[:0], smooth, share)  # fmt: skip
        cleaned = draft._as_declared() if known else draft._clean()
        if cleaned.outlier.any():
            kept = ~cleaned.outlier
            lost, rows = rows[~kept], rows[kept]
            cleaned = replace(cleaned, residual=cleaned.residual[kept], outlier=cleaned.outlier[kept])
            return replace(draft, rows=rows, chain=problem.chain(rows), cleaned=cleaned, outliers=lost)
        return replace(draft, cleaned=cleaned)

    @cached_property
    def raw(self) -> Array:
        """Measured less predicted, whitened, (n, 3)."""
        off = np.where(self.used, (self.problem.rows.measured - self.state.pose)[self.rows], 0.0)
        return np.asarray((self.whitening @ off[:, :, None])[:, :, 0])

    @cached_property
    def left(self) -> Array:
        """Residual `raw` beyond what the laws of the model's effects may differ by, (n, 3)."""
        laws = self.laws_of(self.model, self.values)
        columns = laws.reshape(3 * len(self.rows), laws.shape[2])
        amplitudes = np.linalg.solve(columns.T @ columns + np.eye(columns.shape[1]), columns.T @ self.raw.ravel())
        return self.raw - laws @ amplitudes

    @cached_property
    def used(self) -> Mask:
        """Whether each reading of the rows that count is there, (n, 3)."""
        return np.asarray(self.problem.wanted[self.rows])

    @cached_property
    def whitening(self) -> Array:
        """Whitening of the rows that count, (n, 3, 3)."""
        return self.weights.whitening[self.rows]

    @cached_property
    def by(self) -> Array:
        """Whitened derivatives by `keys`, (n, 3, k)."""
        return np.asarray(self.whitening @ self.state.by[self.rows])

    @property
    def toleranced(self) -> tuple[str, ...]:
        """Keys of the dimensions that have a tolerance, in the order of `Weights.build`."""
        return tuple(key for key in self.problem.tolerances if key in self.keys)

    @property
    def place(self) -> dict[str, int]:
        """Column of `by` by key."""
        return {key: i for i, key in enumerate(self.keys)}

    # Free are, in order: calibrated parameters, what is hidden, sizes of the model, their further ones

    @cached_property
    def hidden(self) -> Array:
        """One standard deviation of what instruments and the build hide, whitened, (n, 3, s)."""
        return self.hidden_of(self.model, self.values)

    def hidden_of(self, model: tuple[int, ...], values: Mapping[str, float]) -> Array:
        """Return what is hidden where the effects of a model have these values by key, whitened, (n, 3, s)."""
        laws, build = self.laws_of(model, values), self.weights.build[self.rows]
        return np.concatenate([self.weights.shift[self.rows], laws, build], axis=2)

    def laws_of(self, model: tuple[int, ...], values: Mapping[str, float]) -> Array:
        """Return one standard deviation of what the laws of a model's effects may differ by, whitened, (n, 3, q)."""
        columns = [self.weights.shift[self.rows][:, :, :0]]
        if self.share is None:
            return columns[0]
        functions = modulations(self.problem.data, self.state.pose)[self.rows]
        for candidate in map(self.candidate, model):
            size = values.get(candidate.keys[0], candidate.start[0]) - candidate.start[0]
            change = np.nan_to_num(size * self.state.by[self.rows][:, :, self.place[candidate.keys[0]]])
            if self.share > 0.0:
                columns.append(law_columns(change, functions, self.whitening, self.share))
            if candidate.effect.enters == "camera":
                columns.append(self.whitening @ (size * self.at_rest(candidate.keys[0])[:, None] * POSITION_ANGLE))
        return np.concatenate(columns, axis=2)

    def at_rest(self, key: str) -> Array:
        """Return the derivative of the readings of the unloaded neck by a parameter, (3,)."""
        return np.asarray(self.problem.rest[self.problem.rest_keys[key]])

    @cached_property
    def nuisances(self) -> tuple[Array, Array, Array]:
        """Effect of calibration: columns (n, 3, p), and its priors' rows (q, p) with their residuals (q,)."""
        problem, size = self.problem, len(self.problem.keys)
        columns = np.concatenate([self.by[:, :, :size], self.hidden], axis=2)
        now = [self.values.get(key, float(value)) for key, value in
               zip(problem.keys, problem.start(problem.keys), strict=True)]  # fmt: skip
        off, slope = problem.prior.rows(np.array(now))
        shifts = columns.shape[2] - size
        rows = np.vstack([np.pad(slope, ((0, 0), (0, shifts))), np.eye(shifts, size + shifts, size)])
        return columns, rows, np.concatenate([-off, np.zeros(shifts)])

    @cached_property
    def sizes(self) -> Array:
        """Signatures of all candidates, one prior standard deviation large, (n, 3, k)."""
        place, candidates = self.place, self.problem.candidates
        columns = [place[candidate.keys[0]] for candidate in candidates]
        out = self.by[:, :, columns] * np.array([candidate.spread[0] for candidate in candidates])
        return np.where(np.isfinite(out), out, 0.0)

    @cached_property
    def further(self) -> Array:
        """Signatures of the further parameters of the effects in the model, (n, 3, j), in prior deviations."""
        place = self.place
        pairs = [
            (key, std)
            for i in self.model
            for key, std in zip(self.candidate(i).keys[1:], self.candidate(i).spread[1:], strict=True)
        ]
        return np.asarray(self.by[:, :, [place[key] for key, _ in pairs]] * np.array([std for _, std in pairs]))

    def candidate(self, i: int) -> EffectCandidate:
        """Return the candidate at a place."""
        return self.problem.candidates[i]

    @cached_property
    def one_sided(self) -> Mask:
        """Whether each candidate can only grow, (k,)."""
        return np.array([candidate.one_sided for candidate in self.problem.candidates], dtype=bool)

    @cached_property
    def center(self) -> Array:
        """Sizes of the effects in the model, in prior standard deviations, (k,)."""
        out = np.zeros(len(self.problem.candidates))
        for i in self.model:
            candidate = self.candidate(i)
            value = self.values.get(candidate.keys[0], candidate.start[0])
            out[i] = (value - candidate.start[0]) / candidate.spread[0]
        return out

    def _as_declared(self) -> NoiseFit:
        return NoiseFit(self.raw, np.ones(3), 0.0, 0.0, 0.0, np.inf, np.zeros(len(self.rows), dtype=bool))

    def _clean(self) -> NoiseFit:
        laws = self.laws_of(self.model, self.values)
        columns = [self.by[:, :, : len(self.problem.keys)], self.weights.shift[self.rows], laws]
        readings = int(self.used.sum())
        span = np.concatenate([*columns, self.sizes[:, :, list(self.model)], self.further], axis=2)
        base = orthonormal(span.reshape(3 * len(self.rows), -1))
        effects = self.sizes.reshape(len(base), -1)
        effects = effects - base @ (base.T @ effects)
        values, vectors = np.linalg.eigh(effects.T @ effects)
        order = np.argsort(-values)[: max(readings // _SHARE, 1)]
        order = order[values[order] * _SATURATED**2 > 1.0]
        directions = effects @ vectors[:, order] / np.sqrt(values[order])
        smooth = _by_channel(self.smooth[0][self.rows])
        basis = np.concatenate([base, directions, smooth], axis=1).reshape(len(self.rows), 3, -1)
        declared = (self.noise.origin[self.rows] == DECLARED).any(axis=0)
        return clean(self.raw, self.used, basis, self.chain, declared)

    # Scaled, made independent from row to row, flat: what all statistics are made of

    def flat(self, values: Array) -> Array:
        """Return whitened values (n, 3, ...) with noise of one size and without memory, (3 n, ...)."""
        axes = (1,) * (values.ndim - 2)
        scaled = values / self.cleaned.scale.reshape(1, 3, *axes)
        scaled = np.where(self.used.reshape(len(self.rows), 3, *axes), scaled, 0.0)
        return self.chain.innovations(scaled, self.cleaned.memory).reshape(3 * len(self.rows), *values.shape[2:])

    @cached_property
    def residual(self) -> Array:
        """Cleaned residual, then those of the priors, (m,)."""
        return np.concatenate([self.flat(self.cleaned.residual), self.nuisances[2]])

    @cached_property
    def free(self) -> Array:
        """Nuisances, with their priors' rows, (m, p)."""
        columns, rows, _ = self.nuisances
        return np.vstack([self.flat(columns), rows])

    @cached_property
    def gram(self) -> EvidenceMatrix:
        """All candidates, calibration taken off."""
        signatures = np.vstack([self.flat(self.sizes), np.zeros((len(self.nuisances[1]), self.sizes.shape[2]))])
        return EvidenceMatrix.from_residual(self.residual, self.free, signatures, self.one_sided, self.center)

    @cached_property
    def rest(self) -> tuple[Array, Array, EvidenceMatrix]:
        """Residual, what is free, and the candidates, once the effects of the model are free too."""
        if not self.model:
            return self.residual, self.free, self.gram
        j = self.further.shape[2]
        effects = np.concatenate([self.sizes[:, :, list(self.model)], self.further], axis=2)
        below = len(self.nuisances[1])
        k = effects.shape[2]
        columns = np.vstack([self.flat(effects), np.zeros((below, k)), np.eye(k)[-j:] if j else np.zeros((0, k))])
        pad = len(columns) - len(self.free)
        free = np.hstack([np.vstack([self.free, np.zeros((pad, self.free.shape[1]))]), columns])
        offsets = [
            (candidate.start[n] - self.values.get(key, candidate.start[n])) / candidate.spread[n]
            for candidate in map(self.candidate, self.model)
            for n, key in enumerate(candidate.keys)
            if n
        ]
        residual = np.concatenate([self.residual, offsets])
        signatures = np.vstack([self.flat(self.sizes), np.zeros((below + pad, self.sizes.shape[2]))])
        return (
            residual,
            free,
            EvidenceMatrix.from_residual(residual, free, signatures, self.one_sided, 0.0 * self.center),
        )

    def gates(self, alpha: float, seed: int) -> tuple[LackOfFit, LackOfFit]:
        """Return both tests for more than the model has."""
        residual, free, gram = self.rest
        smooth, kinds = self.smoothed(), np.repeat(self.smooth[1], 3)
        below = ((0, len(residual) - len(smooth)), (0, 0))
        by_kind = [smooth[:, kinds == kind] for kind in np.unique(kinds)]
        dofs = [self.cleaned.trusted_dof(self.chain.slowness(columns)) for columns in by_kind]
        columns, stage = [np.pad(kind, below) for kind in by_kind], len(self.model)
        return (
            score_test(gram, self.cleaned.trusted_dof(), stage, NAMED * alpha, seed),
            trend_test(residual, free, columns, dofs, stage, SMOOTH * alpha),
        )

    @cached_property
    def _solved(self) -> Array:
        """Pseudo-inverse of what is free, (p, m)."""
        scale = np.sqrt((self.free**2).sum(axis=0))
        scale[scale == 0.0] = 1.0
        return np.asarray(np.linalg.pinv(self.free / scale, rcond=1e-9) / scale[:, None])

    def linear_start(self, model: tuple[int, ...]) -> dict[str, float]:
        """Return calibrated parameters, and the sizes of a model's effects, where the linear model has them."""
        places, problem = list(model), self.problem
        inner = self.gram.gram[np.ix_(places, places)] + np.eye(len(places))
        sizes = np.clip(np.linalg.solve(inner, self.gram.at_zero()[places]), -_FAR, _FAR)
        sizes = np.where(self.one_sided[places], np.maximum(sizes, 0.1), sizes)
        change = -self.center
        change[places] += sizes
        count = 3 * len(self.rows)
        off = self.residual.copy()
        off[:count] -= self.flat(self.sizes) @ change
        moves = self._solved @ off
        start = dict(self.values)
        for key, move in zip(problem.keys, moves.tolist(), strict=False):
            now = self.values[key]
            start[key] = now / max(1.0 - move / now, 0.2) if key in STIFFNESS_KEYS else now + move
        for i, size in zip(places, sizes.tolist(), strict=True):
            start[self.candidate(i).keys[0]] = self.candidate(i).start[0] + size * self.candidate(i).spread[0]
        return start

    def smoothed(self) -> Array:
        """Return smooth functions for each channel, (3 n, 3 q)."""
        return self.flat(_by_channel(self.smooth[0][self.rows]).reshape(len(self.rows), 3, -1))


def _by_channel(columns: Array) -> Array:
    """Return columns (n, q) once for each channel, (3 n, 3 q)."""
    return np.asarray(np.kron(columns, np.eye(3)))


_NOTHING = NoiseFit(np.zeros((0, 3)), np.ones(3), 0.0, 0.0, 0.0, 1.0, np.zeros(0, dtype=bool))
