"""Detectability of effects under given loads: minimum detectable sizes, and names that cannot be separated."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data.columns import CHANNELS
from ...mechanism.parameters import find
from ..problem.candidates import lacking
from ..problem.linearization import Linearization
from ..problem.problem import Problem
from ..problem.stiffness_scale import STIFFNESS_KEYS
from ..results.diagnosis import Detectability
from ..statistics.lack_of_fit import NAMED, null_quantile
from ..statistics.priors import SIZE_SPREAD
from .load_pool import Pool

__all__ = ["GROUPS", "MATERIAL_TESTS", "detectabilities", "distances", "informative_loads"]

Array = NDArray[np.float64]

_FOUND = 1.2816
"""Standard deviations by which nine in ten are above."""
_TOLD = 4.0  # sigmas between two explanations from which on one wins 98 times in 100
_PLAUSIBLE = 10.0  # typical sizes beyond which no rival is credible
_SEEN = 2.0
"""Typical sizes up to which an effect that would be found counts as visible."""
_ABSORBED = 0.5  # share of a signature that calibration leaves, below which it counts as absorbed
_RIVALS = 5  # rivals that a table has room for


def distances(view: Linearization) -> tuple[Array, Array, Array]:
    """Return sigmas of typical sizes (k,), cosines (k, k), and sigmas from a typical size to any of another (k, k).

    A rival that would have to be implausibly large is infinitely far away.
    """
    gram = view.gram
    sigmas, cosine = gram.norm / SIZE_SPREAD, np.clip(gram.cosine, -1.0, 1.0)
    separation = sigmas[:, None] * np.sqrt(1.0 - cosine**2)
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.abs(cosine) * sigmas[:, None] / sigmas
    separation[~(needed <= _PLAUSIBLE)] = np.inf
    wrong_sign = gram.one_sided[None, :] & gram.one_sided[:, None] & (cosine < 0.0)
    separation = np.where(wrong_sign, sigmas[:, None], separation)
    np.fill_diagonal(separation, np.inf)
    return sigmas, cosine, np.asarray(separation)


def detectabilities(view: Linearization, alpha: float, seed: int) -> tuple[Detectability, ...]:
    """Return what the rows of a view can show of every candidate."""
    gram, candidates = view.gram, view.problem.candidates
    if not candidates:
        return ()
    sigmas, cosine, separation = distances(view)
    needed = null_quantile(gram, view.cleaned.trusted_dof(), NAMED * alpha, seed) + _FOUND
    seen = needed <= _SEEN * sigmas
    rival = np.where(seen[None, :], separation, np.inf)
    what, then = informative_loads(view)
    answer = []
    for i, candidate in enumerate(candidates):
        smallest = needed / sigmas[i] * candidate.typical if sigmas[i] > 0.0 else np.inf
        kept = float(gram.norm[i] / gram.raw[i]) if gram.raw[i] > 0.0 else 0.0
        needs = lacking(candidate.effect, view.problem.data)
        nearest = [int(j) for j in np.argsort(separation[i])[:_RIVALS] if np.isfinite(separation[i, j])]
        named = seen[i] and float(rival[i].min(initial=np.inf)) > _TOLD
        lost = gram.raw[i] / SIZE_SPREAD * _SEEN >= needed and kept < _ABSORBED
        visible = "named" if named else "seen" if seen[i] else "absorbed" if lost else "invisible"
        entry = candidate.effect.size
        rivals = tuple((candidates[j].name, float(cosine[i, j]), float(separation[i, j])) for j in nearest)
        size = (entry.unit, entry.typical, float(sigmas[i]), float(smallest))
        shows = needed <= _SEEN * then[i] / SIZE_SPREAD and not seen[i]
        shown_by = (what[i], float(then[i] / SIZE_SPREAD)) if shows else ("", 0.0)
        answer.append(Detectability(candidate.name, *size, kept, rivals, visible, needs, *shown_by))
    return tuple(answer)


GROUPS = {
    "more tendon loads": ("nothing",),
    "a wrench at the head, tendons off": ("wrench",),
    "2 kg more on the head": ("mass",),
    "the test bed tilted to both sides": ("tilt", "tilt-back"),
}
"""Next experiments, by the add-ons of `pool.ADD_ONS`: the loads of one kind are measured once each."""

MATERIAL_TESTS = "tests of the material, given as --prior for EA, GA and EI"
"""The same without a load: the scatter of such tests is taken to be what is typical of a stiffness."""


def informative_loads(view: Linearization) -> tuple[tuple[str, ...], Array]:
    """Return what would show most of each candidate, (k,), and the sigmas that a prior deviation of it then has, (k,).

    The loads at hand count along; nuisances, calibration above all, are fitted to both.
    """
    problem, pool = view.problem, Pool.from_add_ons()
    pool_problem = _problem(view, pool)
    sizes = [candidate.keys[0] for candidate in problem.candidates]
    solver = pool_problem.solver(list(dict.fromkeys([*sizes, *problem.tolerances])))
    at = [view.values.get(key, float(value)) for key, value in
          zip(solver.names, pool_problem.start(solver.names), strict=True)]  # fmt: skip
    state = solver.at(np.array(at))
    weights = pool_problem.weights(pool_problem.noise(state), state, solver.names)
    by = np.where(state.stable[:, None, None], np.nan_to_num(weights.whitening @ state.by), 0.0)
    calibrated, free, readings = len(problem.keys), view.free.shape[1], 3 * len(view.rows)
    spread = np.array([candidate.spread[0] for candidate in problem.candidates])
    columns = np.zeros((*by.shape[:2], free + len(spread)))
    columns[:, :, :calibrated] = by[:, :, :calibrated]
    hidden = calibrated + view.weights.shift.shape[2]
    columns[:, :, hidden:free] = np.nan_to_num(weights.build)
    place = {key: i for i, key in enumerate(solver.names)}
    columns[:, :, free:] = by[:, :, [place[candidate.keys[0]] for candidate in problem.candidates]] * spread
    priors = np.zeros((len(view.free) - readings, len(spread)))
    information = np.hstack([view.free, np.vstack([view.flat(view.sizes), priors])])
    ways = {name: columns[np.isin(pool.add_on, add_ons)] for name, add_ons in GROUPS.items()}
    if (tests := _material_tests(problem)).size:
        ways[MATERIAL_TESTS] = np.pad(tests, ((0, 0), (0, columns.shape[2] - calibrated)))
    found = np.array([_sigmas(information, columns_of, free) for columns_of in ways.values()])
    best = np.argmax(found, axis=0)
    return tuple(np.array(list(ways))[best].tolist()), found.max(axis=0)


def _material_tests(problem: Problem) -> Array:
    """Return rows (q, p) of tests of every stiffness, where the problem does not know them yet."""
    rows = np.zeros((len(STIFFNESS_KEYS), len(problem.keys)))
    for row, key in zip(rows, STIFFNESS_KEYS, strict=True):
        place, entry = problem.keys.index(key), find(key)
        scatter = entry.typical / entry.default * problem.start([key])[0]
        row[place] = problem.prior.rough[place] / scatter
    return rows[rows.any(axis=1)]


def _problem(view: Linearization, pool: Pool) -> Problem:
    """Return the loads of a pool as measurements with the noise of a view."""
    problem, loads = view.problem, pool.data
    read, columns = view.weights.sigma[view.rows], dict[str, Any]()
    for i, name in enumerate(CHANNELS):
        seen = view.used[:, i]
        columns[name] = np.full(loads.n, 0.0 if seen.any() else np.nan)
        sigma = view.cleaned.scale[i] * np.median(read[seen, i]) if seen.any() else np.nan
        columns[f"sigma_{name}"] = np.full(loads.n, sigma)
    loads_with_noise = replace(loads, **columns)
    return Problem(problem.mechanism, [loads_with_noise], problem.candidates, dict.fromkeys(problem.keys, np.inf), {},
                   force_sigma=float(np.median(view.noise.force)), seed=0)  # fmt: skip


def _sigmas(information: Array, added: Array, free: int) -> Array:
    """Return the norms of what the first `free` columns leave of the others, (k,)."""
    columns = np.vstack([information, added.reshape(-1, information.shape[1])])
    size = np.sqrt((columns[:, :free] ** 2).sum(axis=0))
    q, _ = np.linalg.qr(columns[:, :free][:, size > 0.0] / size[size > 0.0])
    kept = columns[:, free:] - q @ (q.T @ columns[:, free:])
    return np.asarray(np.sqrt((kept**2).sum(axis=0)))
