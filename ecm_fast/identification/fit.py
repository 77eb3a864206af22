"""One weighted fit: rows, priors and loss to values with intervals."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..data.columns import usual_sigma
from ..errors import InputError
from ..mechanism.parameters import find, index
from ..mechanism.sections import STIFFNESSES
from ..mechanism.vector import pack
from ..models.equilibrium import Status
from .least_squares import NEAR, Loss, Minimum, visible
from .noise import RESIDUAL, ReadingNoise
from .result import Estimate, Identification, Objective
from .rows import FitRows, State
from .starts import starts
from .variance_components import VarianceComponents
from .warnings import far_off, in_words

__all__ = ["WeightedFit", "t_quantile"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_ROUNDS = 12  # at most, of weights and minimum in turn
_NEAR_ENOUGH = 0.1  # standard deviations: where the weights change anyway, a better minimum is not worth its solves
_SAME_WEIGHTS = 1e-3  # relative change of the weights that counts as none
_FEWEST_ROWS, _FEWEST_DOF = 3, 1.0  # that an interval is taken from where the fit itself tells the noise
_LOST = 1e3  # standard deviation over the value of a stiffness from which on its flexibility is as good as none
_HIDDEN = 0.05  # share of a direction that is not seen, from which on a parameter is part of it


class WeightedFit:
    """One fit: rows, priors (k, 3) of place, value and standard deviation, loss."""

    def __init__(self, rows: FitRows, prior: Array, loss: Loss, level: float, force_sigma: float | None) -> None:
        self.rows, self.prior, self.loss, self.level, self.force_sigma = rows, prior, loss, level, force_sigma
        self.lower, self.upper = rows.bounds()
        self.used, self.barred = rows.wanted, np.zeros(rows.n, dtype=bool)

    def best(self) -> Identification:
        """Fit from the mechanism's values, and where that leaves a doubt from others, of which the best fit counts.

        Raises
        ------
        InputError : no start has enough rows with a stable equilibrium; of the mechanism's own start.
        """
        start = np.clip(pack(self.rows.sets[0].mechanism)[self.rows.places], self.lower, self.upper)
        refused, found = None, []
        try:
            found.append(self.run(start))
        except InputError as error:
            refused = error
        if not found or _doubtful(found[0], self.rows.measured):
            for other in starts(self.rows, self._objective, start):
                with suppress(InputError):
                    found.append(self.run(other))
        if not found and refused is not None:
            raise refused
        best = max(found, key=self._merit)
        return replace(best, solves=self.rows.solves)

    def _merit(self, fit: Identification) -> tuple[bool, int, float]:
        """Return how good a fit is: whether it settled, how many readings it counts, how near it comes to them."""
        sigma = np.where(np.isnan(self.rows.declared), usual_sigma(self.rows.channels), self.rows.declared)
        place, center, spread = self.prior[:, 0].astype(int), self.prior[:, 1], self.prior[:, 2]
        with np.errstate(over="ignore"):  # a noise declared as next to nothing: infinitely far off
            off = self.loss.total((fit.residual / sigma)[fit.used])
            off += float((((fit.values[place] - center) / spread) ** 2).sum())
        return fit.settled, int(fit.used.sum()), -off

    def run(self, start: Array) -> Identification:
        """Fit until neither the weights nor the rows that can be used change."""
        rows, robust, values = self.rows, self.loss.name != "linear", start
        self.barred = np.zeros(rows.n, dtype=bool)
        state = rows.at(values)
        self._use(state)
        noise, weights, settled, near = ReadingNoise.from_rows(rows, state, self.force_sigma), None, False, _NEAR_ENOUGH
        for _ in range(_ROUNDS):
            spread = noise.components(rows, state, self.used, self._known(values), robust=robust)
            sigma = noise.sigma if spread is None else spread.sigma
            before, weights = weights, noise.whitening(sigma, state, self.used)
            if before is not None and near == NEAR and _same(before, weights):
                settled = minimum.settled  # noqa: F821  bound in the first round
                break
            objective = self._objective(weights, self.used)
            near = NEAR if before is not None or noise.fixed(self.used) else _NEAR_ENOUGH
            minimum = objective.minimum(values, near)
            values = minimum.values
            state = rows.at(values)
            if minimum.blocked is not None:  # rows that lose their equilibrium on the way keep all others from the best
                self.barred |= self.used.any(axis=1) & ~rows.at(minimum.blocked).stable
            self._use(state)
        return self._result(objective, minimum, state, noise, spread, settled)

    def _known(self, values: Array) -> tuple[Array, Array]:
        """Return normal matrix (p, p) and right-hand side (p,) of the priors at these values."""
        normal, side = np.zeros((values.size, values.size)), np.zeros(values.size)
        for place, center, std in self.prior:
            i = int(place)
            normal[i, i] += std**-2.0
            side[i] += (center - values[i]) / std**2
        return normal, side

    def _use(self, state: State) -> None:
        """Count the rows that are at a stable equilibrium now."""
        self.used = self.rows.wanted & (state.stable & ~self.barred)[:, None]
        count, unknown = int(self.used.sum()) + len(self.prior), len(self.rows.names)
        if count < unknown:
            lost = int((self.rows.wanted.any(axis=1) & ~(state.stable & ~self.barred)).sum())
            why = f" ({lost} rows have no stable equilibrium)" if lost else ""
            raise InputError(f"{count} readings and priors{why} do not determine {unknown} parameters; "
                             f"at least {unknown} are needed")  # fmt: skip

    def _objective(self, weights: Array, used: Mask) -> Objective:
        """Return the sum of squares with given weights: the readings in use, (n, c), then the priors."""
        rows, rows_in_use = self.rows, used.any(axis=1)
        p = len(rows.names)
        place, center, spread = self.prior[:, 0].astype(int), self.prior[:, 1], self.prior[:, 2]
        by_prior = np.eye(p)[place] / spread[:, None]

        def residuals(values: Array) -> tuple[Array, Array] | None:
            state = rows.at(values)
            if not state.stable[rows_in_use].all():
                return None
            off = (weights @ np.where(used, rows.residual(state), 0.0)[:, :, None]).ravel()
            by = -(weights @ (state.by if rows_in_use.all() else np.nan_to_num(state.by))).reshape(-1, p)
            if not len(place):
                return off, by
            return np.concatenate([off, (values[place] - center) / spread]), np.concatenate([by, by_prior])

        return Objective(residuals, self.lower, self.upper, self.loss, len(place))

    def _result(
        self,
        objective: Objective,
        minimum: Minimum,
        state: State,
        noise: ReadingNoise,
        spread: VarianceComponents | None,
        settled: bool,
    ) -> Identification:
        rows, values, count = self.rows, minimum.values, int(self.used.sum())
        data_rows = minimum.residual.size - objective.plain
        stiffness, scale = self._scale(values)
        singular, directions = visible(minimum.jacobian[:data_rows], scale)
        curvature = self._covariance(minimum, scale, objective.plain)
        covariance, freedom = curvature, np.full(len(values), noise.dof)
        dof = count - len(values) + objective.plain
        if spread is not None:
            freedom = np.minimum(freedom, spread.dof)
            if self.loss.name == "linear":
                covariance = np.where(np.isinf(curvature), curvature, spread.covariance)
            rows_told = int((self.used & (noise.origin == RESIDUAL)).any(axis=1).sum())
            untold = np.full(len(values), rows_told < _FEWEST_ROWS or dof < 1) | ~(freedom >= _FEWEST_DOF)
            untold |= ~(np.diag(covariance) > 0.0)
            covariance[untold, untold] = np.inf
        std = np.sqrt(np.diag(covariance))
        reach = np.array([t_quantile(self.level, float(nu)) for nu in freedom])
        ends = np.clip(_interval(values, reach * std, stiffness), self.lower, self.upper)
        low, high = np.where(np.isfinite(std), ends, [[-np.inf], [np.inf]])
        with np.errstate(invalid="ignore"):
            widened = std / np.sqrt(np.diag(curvature))
            lost = stiffness & (std > _LOST * values)
            covariance[lost, lost], std[lost] = np.inf, np.inf
            correlation = np.where(np.isfinite(np.outer(std, std)), covariance / np.outer(std, std), np.nan)
        estimates = {
            name: Estimate(
                float(values[i]), float(std[i]), float(low[i]), float(high[i]), find(name).unit, float(freedom[i])
            )
            for i, name in enumerate(rows.names)
        }
        chi2 = float((minimum.residual[:data_rows] ** 2).sum())
        changes = dict(zip(rows.names, values.tolist(), strict=True))
        result = Identification(
            parameters=estimates,
            covariance=covariance,
            correlation=correlation,
            channels=rows.channels,
            residual=rows.residual(state),
            used=self.used,
            sigma=np.where(self.used, noise.sigma if spread is None else spread.sigma, np.nan),
            noise=_origins(rows.channels, noise.origin, self.used),
            left_out=tuple(self._left_out(state)),
            chi2=chi2,
            dof=dof,
            mechanisms=tuple(entry.mechanism.replace(**changes) for entry in rows.sets),
            warnings=(),
            settled=settled,
            solves=rows.solves,
            level=self.level,
            _reach=reach * widened,
            _objective=objective,
        )
        return in_words(result, self.prior, (singular, directions), rows.measured, known=spread is None)

    def _scale(self, values: Array) -> tuple[Mask, Array]:
        """Return which parameters are stiffnesses, (p,), and the sizes of changes that count as one, (p,).

        Of a stiffness beyond its start that of its flexibility counts: from some size on, larger is the same.
        """
        stiffness = np.isin(self.rows.places, [index(name) for name in STIFFNESSES])
        size = np.maximum(np.abs(values), [find(name).typical for name in self.rows.names])
        start = np.where(stiffness, pack(self.rows.sets[0].mechanism)[self.rows.places], 1.0)
        return stiffness, np.where(stiffness, size * np.maximum(values / start, 1.0), size)

    def _covariance(self, minimum: Minimum, scale: Array, plain: int) -> Array:
        """Return the covariance of the parameters, (p, p), inf for those that nothing sees.

        For a robust loss that of an M-estimator: the curvature's inverse on both sides of the gradients' covariance.
        """
        jacobian, residual = minimum.jacobian * scale, minimum.residual
        robust = residual.size - plain
        curvature, spread = np.ones(residual.size), np.ones(residual.size)
        if self.loss.name != "linear":
            curvature[:robust] = self.loss.curvature(residual[:robust])
            spread[:robust] = (self.loss.weight(residual[:robust]) * residual[:robust]) ** 2
        singular, directions = visible(np.sqrt(curvature)[:, None] * jacobian, np.ones(scale.size))
        seen = singular > max(1e-7 * float(singular[0]), 1e-12)
        inverse = (directions[seen].T / singular[seen] ** 2) @ directions[seen]
        covariance = inverse
        if self.loss.name != "linear":
            covariance = inverse @ (jacobian.T * spread @ jacobian) @ inverse
        covariance = covariance * np.outer(scale, scale)
        hidden = (np.abs(directions[~seen]) > _HIDDEN).any(axis=0)
        covariance[hidden, hidden] = np.inf
        return np.asarray(covariance)

    def _left_out(self, state: State) -> Iterator[tuple[str, str]]:
        for i in np.flatnonzero(self.rows.wanted.any(axis=1) & ~self.used.any(axis=1)):
            status = Status(int(state.status[i])).name.lower().replace("_", " ")
            yield self.rows.where(int(i)), status if not state.stable[i] else "no stable equilibrium at a better fit"


def _doubtful(fit: Identification, measured: Array) -> bool:
    """Whether a better minimum is worth a search: rows left out, a fit that did not converge, or readings far off."""
    return bool(fit.left_out) or not fit.settled or bool(far_off(fit, measured))


def _interval(values: Array, reach: Array, stiffness: Mask) -> Array:
    """Return the ends of intervals, (2, p), that reach equally far to both sides: of stiffnesses in 1/value.

    Poses are nearly linear in the flexibilities 1/EA, 1/GA and 1/EI, however well these are known.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        share = reach / values
        low = np.where(stiffness, values / (1.0 + share), values - reach)
        high = np.where(stiffness, np.where(share < 1.0, values / (1.0 - share), np.inf), values + reach)
    return np.stack([low, high])


def _same(before: Array, after: Array) -> bool:
    return bool(np.abs(after - before).max() <= _SAME_WEIGHTS * np.abs(after).max())


def t_quantile(level: float, dof: float) -> float:
    """Return how many standard deviations an interval reaches to each side: Student's t, Gaussian for dof = inf."""
    from scipy.special import ndtri, stdtrit

    p = 0.5 * (1.0 + level)
    return float(ndtri(p) if np.isinf(dof) else stdtrit(dof, p))


def _origins(channels: Sequence[str], origin: NDArray[np.str_], used: Mask) -> dict[str, str]:
    """Return by channel where the standard deviations of its readings come from."""
    found = {name: sorted(set(origin[used[:, i], i].tolist())) for i, name in enumerate(channels)}
    return {name: " and ".join(kinds) for name, kinds in found.items() if kinds}
