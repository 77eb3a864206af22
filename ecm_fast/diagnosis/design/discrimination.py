"""Discrimination between rival explanations: their separation, and the gain of each further load."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data.measurements import Measurements
from ...identification.identify import fit_parameters
from ...identification.noise import DECLARED, ReadingNoise
from ...identification.rows import FitRows, FitSet, State, common_mesh
from ...mechanism.catalogue import CATALOGUE
from ...mechanism.mechanism import Mechanism
from ...mechanism.parameters import find, index
from ...mechanism.vector import pack
from ..results.next_loads import ENOUGH, NextLoads, Suggestion
from .load_pool import Pool
from .rivals import STIFFNESSES, Rival

__all__ = ["DiscriminationDesign"]

Array = NDArray[np.float64]

_LARGEST = 1e8  # squared sigmas: stands for infinity where ratios are formed
_LEAST_GAIN = 1e-6  # gain of the criterion below which another reading is wasted
_HOPE = 3.0
"""Explanations that all the time on the best load leaves closer than this are one for the search."""
_RIGID = 1e3
"""Largest ratio of two fits of a stiffness: beyond it the section is as good as rigid."""
_LONGER = (2, 4, 8, 16, 32)
"""Times the time there is that are tried where it will not do."""


class DiscriminationDesign:
    """Ordered pairs of rivals, all or those with the first one, and what each load of the pool adds to their distances.

    The second one of a pair is refitted in full to what the first one says of all loads that are measured or chosen;
    only the step to a load that is not chosen yet is linear.
    """

    def __init__(
        self,
        rivals: Sequence[Rival],
        data: Sequence[Measurements],
        pool: Pool,
        noise: tuple[Array, float],
        priors: Mapping[str, tuple[float, float]],
        *,
        first_alone: bool = False,
    ) -> None:
        self.rivals, self.pool, self.priors = rivals, pool, priors
        self.sigma, self.force = noise
        self.data = [*data]
        every = [(i, j) for i in range(len(rivals)) for j in range(len(rivals)) if i != j]
        self.pairs = [pair for pair in every if 0 in pair] if first_alone else every
        self.blank = pool.data
        self.options = [_at(rival.mechanism, (), [self.blank]) for rival in rivals]
        self.feasible = np.logical_and.reduce([state.stable for state in self.options])
        self.adapted = [self.rivals[j].mechanism.replace(**_stiffness(rivals[i], rivals[j])) for i, j in self.pairs]
        self.terms = [self._terms(pair) for pair in range(len(self.pairs))]
        self.open = np.ones(len(self.pairs), dtype=bool)

    def _terms(self, pair: int) -> tuple[Array, Array, Array]:
        """Refit a pair's rival; return c, b and G of its sum of squares c - 2 b p + p G p: now, then for each load."""
        i, j = self.pairs[pair]
        true, rival = self.rivals[i], self.rivals[j]
        predicted = [_predicted(true.mechanism, part, self.sigma) for part in self.data]
        fit = fit_parameters([FitSet(self.adapted[pair], part) for part in predicted], rival.free, priors=self.priors,
                             force_sigma=self.force)  # fmt: skip
        self.adapted[pair] = fit.mechanism
        c, b, gram = self._sums(predicted, fit.mechanism, rival.free)
        total = c.sum(axis=0, keepdims=True), b.sum(axis=0), gram.sum(axis=0)
        for place, name in enumerate(rival.free):
            if name in self.priors:
                value, std = self.priors[name]
                by = find(name).typical / std
                off = (value - pack(fit.mechanism)[index(name)]) / std
                total[2][place, place] += by**2
                total[1][place] += by * off
                total[0][0] += off**2
        free = _predicted(true.mechanism, self.blank, self.sigma)
        after = self._sums([free], fit.mechanism, rival.free)
        b, gram = (np.concatenate([one[None], other]) for one, other in zip(total[1:], after[1:], strict=True))
        return np.concatenate([total[0], after[0]]), b, gram

    def _sums(
        self, predicted: Sequence[Measurements], mechanism: Mechanism, free: tuple[str, ...]
    ) -> tuple[Array, Array, Array]:
        """Return c (n,), b (n, p) and G (n, p, p) of what one explanation says and another one fits."""
        sets = [FitSet(mechanism, part) for part in predicted]
        rows = FitRows(sets, free, common_mesh(sets)[0])
        state = rows.at(pack(mechanism)[rows.places])
        used = rows.wanted & state.stable[:, None]
        noise = ReadingNoise(
            np.tile(self.sigma, (rows.n, 1)), np.full(rows.n, self.force), np.full((rows.n, 3), DECLARED)
        )
        whitening = noise.whitening(noise.sigma, state, used)
        off = (whitening @ np.nan_to_num(rows.residual(state))[:, :, None])[:, :, 0]
        by = whitening @ (np.nan_to_num(state.by) * [find(name).typical for name in free])
        return (off**2).sum(axis=1), np.einsum("nci,nc->ni", by, off), np.einsum("nci,ncj->nij", by, by)

    def now(self) -> Array:
        """Return the squared distances of the pairs, (pairs,)."""
        return np.array([float(_left(c[0], b[0], gram[0])) for c, b, gram in self.terms])

    def then(self, repeats: int) -> Array:
        """Return the squared distances once a load of the pool is read too, (pairs, n)."""
        return np.array([_left(*(one[0] + repeats * one[1:] for one in term)) for term in self.terms])

    def run(self, minutes: float, repeats: int) -> NextLoads:
        """Take the load that buys most per minute until the time is used, or all are apart."""
        hopeful = self._hopeful(minutes)
        self.open = hopeful if hopeful.any() else ~hopeful
        before, add_on = self.now(), np.array(self.pool.add_on)
        separation = np.sqrt(self.then(repeats)[self.open].min(axis=0, initial=_LARGEST))
        alone = {
            name: float(separation[(add_on == name) & self.feasible].max(initial=0.0)) for name in dict.fromkeys(add_on)
        }
        mounted, spent, taken, now = {"nothing"}, 0.0, list[int](), before
        while self.open.any() and now[self.open].min() < ENOUGH**2:
            cost = np.array([self.pool.minutes(i, mounted, repeats) for i in range(len(add_on))])
            allowed = self.feasible & (cost <= minutes - spent)
            gain = (_confusion(now[self.open, None]) - _confusion(self.then(repeats)[self.open])) / cost
            best = int(np.argmax(np.where(allowed, gain, -np.inf)))
            if not allowed[best] or gain[best] <= _LEAST_GAIN:
                break
            self._measure(best, repeats)
            now, spent = self.now(), spent + float(cost[best])
            mounted.add(self.pool.add_on[best])
            taken.append(best)
        names = tuple(rival.name for rival in self.rivals)
        twins = tuple((names[i], names[j]) for (i, j), good in zip(self.pairs, self.open, strict=True)
                      if not good and i < j)  # fmt: skip
        short = not hopeful.any() and now.min() < _HOPE**2
        notes = (*_notes(self.rivals), *((self._longer(minutes),) if short else ()))
        plan = tuple(self._plan(taken, repeats))
        return NextLoads(names, self._square(before), self._square(now), plan, alone, twins, notes)

    def _plan(self, taken: Sequence[int], repeats: int) -> Iterator[Suggestion]:
        """Yield what was taken, each load once, with what it and those before it promise."""
        later, mounted = Counter(taken), {"nothing"}
        for load, times in Counter(taken).items():
            del later[load]
            without = [[one[0] - repeats * sum(n * one[1 + i] for i, n in later.items()) for one in term]
                       for term in self.terms]  # fmt: skip
            separation = np.where(self.open, np.sqrt([float(_left(*one)) for one in without]), np.inf)
            i, j = self.pairs[int(np.argmin(separation))]
            cost = self.pool.minutes(load, mounted, repeats * times)
            mounted.add(self.pool.add_on[load])
            yield Suggestion(self.pool.named(load), self.pool.add_on[load], repeats * times, cost,
                             float(separation.min()), (self.rivals[i].name, self.rivals[j].name))  # fmt: skip

    def _hopeful(self, minutes: float) -> NDArray[np.bool_]:
        """Return which pairs any load of the pool could split if all the time were spent on it, (pairs,)."""
        cost = np.array([[self.pool.minutes(i, {"nothing"}, n) for n in (0, 1)] for i in range(len(self.pool.add_on))])
        readings = np.maximum((minutes - cost[:, 0]) / (cost[:, 1] - cost[:, 0]), 0.0) * self.feasible
        best = np.array([
            float(_left(*(one[0] + readings.reshape(-1, *[1] * (one.ndim - 1)) * one[1:] for one in term)).max())
            for term in self.terms
        ])  # fmt: skip
        other = {pair: k for k, pair in enumerate(self.pairs)}
        both = [min(best[k], best[other[j, i]]) for k, (i, j) in enumerate(self.pairs)]
        return np.asarray(np.array(both) >= _HOPE**2)

    def _longer(self, minutes: float) -> str:
        """Return how long it would take to tell any of the explanations apart, where the time there is will not do."""
        enough = next((minutes * times for times in _LONGER if self._hopeful(minutes * times).any()), None)
        if enough is None:
            return f"no load here brings any two of them {_HOPE:g} sigma apart, however often it is read"
        return f"{minutes:g} minutes bring no two of them {_HOPE:g} sigma apart; {enough:g} would"

    def _measure(self, load: int, repeats: int) -> None:
        """Count a load as measured; rivals that are close after it are refitted with it."""
        self.data.append(_filled(self.blank.select([load] * repeats)))
        then = self.then(repeats)[:, load]
        near = 2.0 * then[self.open].min()
        for pair, squared in enumerate(then):
            if squared <= near and self.open[pair]:
                self.terms[pair] = self._terms(pair)
            else:
                for one in self.terms[pair]:
                    one[0] += repeats * one[1 + load]

    def _square(self, squared: Array) -> Array:
        out = np.where(np.eye(len(self.rivals), dtype=bool), 0.0, np.inf)
        for (i, j), value in zip(self.pairs, squared, strict=True):
            out[i, j] = np.sqrt(value)
        return out


def _notes(rivals: Sequence[Rival]) -> tuple[str, ...]:
    paths = [name for rival in rivals for name in rival.names if name in CATALOGUE and CATALOGUE[name].mirror == "path"]
    if not paths:
        return ()
    return (f"{', '.join(dict.fromkeys(paths))}: what came before counts; the promise is for a load as the next one",)


def _stiffness(true: Rival, rival: Rival) -> dict[str, float]:
    """Return stiffnesses from which the rival adapts: the true one's, its own where those ran away as good as rigid."""
    of_true, of_rival = pack(true.mechanism), pack(rival.mechanism)
    known = {name: (float(of_true[index(name)]), float(of_rival[index(name)])) for name in STIFFNESSES}
    return {name: other if value > _RIGID * other else value for name, (value, other) in known.items()}


def _at(mechanism: Mechanism, free: tuple[str, ...], data: Sequence[Measurements]) -> State:
    sets = [FitSet(mechanism, part) for part in data]
    rows = FitRows(sets, free, common_mesh(sets)[0])
    return rows.at(pack(mechanism)[rows.places])


def _filled(data: Measurements) -> Measurements:
    """Return rows whose poses count as measured."""
    return replace(data, x=np.zeros(data.n), z=np.zeros(data.n), theta=np.zeros(data.n))


def _predicted(mechanism: Mechanism, data: Measurements, sigma: Array) -> Measurements:
    """Return what an explanation says of the loads of measurements, without noise, where these have readings."""
    pose = _at(mechanism, (), [data]).pose
    kept = data.measured if data.measured.any() else np.ones((data.n, 3), dtype=bool)
    x, z, theta = np.where(kept, pose, np.nan).T.copy()
    known = [np.full(data.n, value) for value in sigma]
    return replace(data, x=x, z=z, theta=theta, sigma_x=known[0], sigma_z=known[1], sigma_theta=known[2])


def _left(c: Any, b: Array, gram: Array) -> Array:
    """Return what the rival cannot follow, c - b G^-1 b, for one or many; never less than nothing."""
    size = np.sqrt(np.maximum(np.einsum("...ii->...i", gram), 1e-300))
    unit = gram / size[..., :, None] / size[..., None, :]
    step = (np.linalg.pinv(unit, rcond=1e-10, hermitian=True) @ (b / size)[..., None])[..., 0]
    left: Array = np.clip(c - (b / size * step).sum(axis=-1), 0.0, _LARGEST)
    return left


def _confusion(squared: Array) -> Array:
    """Return the logarithm of the summed odds of all wrong rivals, exp(-d^2/2) each, over the first axis."""
    lowest = squared.min(axis=0)
    total: Array = np.log(np.exp(-0.5 * (squared - lowest)).sum(axis=0)) - 0.5 * lowest
    return total
