"""Subsampling of large data sets: a share of the rows ranks the effects, all rows decide.

What a search costs grows with the rows times the explanations that it tries, and which of these are worth a look
hardly changes beyond a thousand rows. Sizes, intervals, look-alikes and tests do change, and come from all rows.
"""

from bisect import bisect_right
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..problem.holdout import regions
from ..problem.linearization import Linearization
from ..problem.problem import Problem
from ..results.diagnosis import LackOfFit
from .fit import Fit, refit
from .model_selection import PASSES, WORTH, gain_of_two, search, search_from, second_effect, select, trial
from .odds import alternative_caveat
from .outliers import drop_single_row_alarms
from .ranked_fits import Fits, fit_models, fit_pairs
from .result import LIMITS, Selection, implausible

__all__ = ["ENOUGH", "evenly", "search_all"]

ENOUGH = 1500
"""Rows that a search goes by."""
_SURE = 0.01
"""Share of the allowed chance of a false alarm below which an alarm of these rows stands without all rows."""
_SLACK, _MOST = 10.0, 12
"""Evidence beyond the limit within which an explanation is fitted to all rows, and how many of them at most."""
_PASSES = 2  # linearizations of each explanation on all rows


def search_all(problem: Problem, alpha: float, max_effects: int, seed: int) -> Selection:
    """Search for what the measurements ask for, where there are many rows by a share of them first.

    An alarm that the share raises alone is given when it is a hundred times rarer than allowed, so that the chance of
    a false one stays what it is; any other alarm is that of all rows. What the share cannot explain, it need not.
    """
    problem.progress.begin("search")
    if problem.open.size <= ENOUGH:
        return search(problem, alpha, max_effects, seed)
    few = search(problem.by(evenly(problem, ENOUGH)), alpha, max_effects, seed)
    problem.progress.begin("all rows")
    baseline, gates, alarmed = few.baseline, few.gates[:2], bool(few.fits)
    if not alarmed or not any(gate.p < _SURE * gate.alpha for gate in gates):
        start = Linearization.at(problem, few.null.by_key(), (), baseline.noise)
        baseline, gates = drop_single_row_alarms(start, alpha, seed)
        if not alarmed or not any(gate.alarm for gate in gates):
            return search_from(baseline, alpha, max_effects, seed)
    return _confirmed(problem, few, baseline, gates, alpha, max_effects, seed) if few.effects else few


def evenly(problem: Problem, most: int) -> NDArray[np.int64]:
    """Return places of about as many open rows, as many of each session, experiment and region as there are to have.

    In each of them they are spread evenly over the order of measurement.
    """
    rows, data = problem.open, problem.data
    region = np.concatenate([regions(part) for part in data])[rows]
    experiment = np.concatenate([part.experiment for part in data])[rows]
    keys = np.rec.fromarrays([problem.run[rows], experiment, region])
    stratum, sizes = np.unique(keys, return_inverse=True, return_counts=True)[1:]
    each = max(bisect_right(range(int(sizes.max()) + 1), most, key=lambda n: int(np.minimum(sizes, n).sum())) - 1, 1)
    groups = np.split(np.argsort(stratum, kind="stable"), np.cumsum(sizes)[:-1])
    taken = [group[np.linspace(0, group.size - 1, min(group.size, each)).round().astype(int)] for group in groups]
    chosen: NDArray[np.int64] = rows[np.sort(np.concatenate(taken))]
    return chosen


def _confirmed(
    problem: Problem,
    few: Selection,
    baseline: Linearization,
    gates: tuple[LackOfFit, ...],
    alpha: float,
    max_effects: int,
    seed: int,
) -> Selection:
    """Return what all rows say of the explanations that a share of them leaves."""
    singles = _near(few.fits[1], few.view, LIMITS[1])
    if few.effects == 2:
        near = _near(few.fits[2], few.view, LIMITS[2])
        two = _of_two(baseline, gates, _to_all(problem, baseline, few, near), singles[:1], alpha, seed)
        if two.effects or not singles:
            return two
        one = select(baseline, baseline, gates, _to_all(problem, baseline, few, singles), alpha, 1, seed)
        return one if one.effects else two
    found = _to_all(problem, baseline, few, singles)
    one = select(baseline, baseline, gates, found, alpha, 1, seed)
    asked = max_effects > 1 and found[2] and (not one.effects or second_effect(found[0]) > WORTH)
    pairs = _pairs_of(few, found) if asked else []
    if not pairs:
        return one
    enough = one.names(one.best)[0] if one.effects else ""
    law = one.best if one.effects and one.best.varied else None
    two = _of_two(baseline, one.gates, _to_all(problem, baseline, few, pairs), found[2][:1], alpha, seed, enough, law)
    return two if two.effects or not one.effects else one


def _near(fits: Sequence[Fit], view: Linearization, limit: float) -> list[Fit]:
    """Return the fits that may still be within a limit of the best one when all rows have spoken, the best first."""
    meant = [fit for fit in fits if not implausible(fit, view)]
    return [fit for fit in meant if fit.evidence > meant[0].evidence - limit - _SLACK][:_MOST]


def _to_all(problem: Problem, baseline: Linearization, few: Selection, near: list[Fit]) -> Fits:
    """Fit explanations to all rows, from where they are; the view is that at the best of them."""
    best, sizes = near[0], {candidate.keys[0] for candidate in problem.candidates}
    known = {key: value for key, value in few.view.values.items() if key not in sizes}  # another name may be best here
    for _ in range(_PASSES):
        view = Linearization.at(problem, {**known, **best.by_key()}, best.model, baseline.noise)
        fits = fit_models(view, [fit.model for fit in near], {fit.model: fit for fit in near})
        near = _near(fits, view, LIMITS[len(best.model)])
        if not near or near[0].model == best.model:
            break
        best = near[0]
    return view, refit(view, (), few.null.by_key()), fits


def _pairs_of(few: Selection, ranked: Fits) -> list[Fit]:
    """Return pairs to try where one effect is not enough for all rows, the most promising first.

    A second effect that a share of the rows does not show is small, and the linear model of all rows ranks it; pairs
    without the first one are those that the share finds no worse.
    """
    view, _, fits = ranked
    first, pairs = fits[0].model[0], view.gram.pairs()
    with_first = (pairs.first == first) | (pairs.second == first)
    seen = with_first & (view.gram.norm[pairs.first] > 0.0) & (view.gram.norm[pairs.second] > 0.0)
    evidence = np.where(seen, pairs.evidence, -np.inf)
    order = np.argsort(-evidence)[:_MOST]
    models = [(int(pairs.first[n]), int(pairs.second[n])) for n in order
              if evidence[n] > evidence[order[0]] - LIMITS[2] - _SLACK]  # fmt: skip
    _, _, rough = fit_pairs(few.view.problem, few.baseline, few.view, few.view.noise, few.fits[1])
    others = [fit for fit in _near(rough, few.view, LIMITS[2]) if first not in fit.model]
    return [*fit_models(few.view, models, {fit.model: fit for fit in (*fits, *rough)}), *others]


def _of_two(
    baseline: Linearization,
    gates: tuple[LackOfFit, ...],
    ranked: Fits,
    singles: Sequence[Fit],
    alpha: float,
    seed: int,
    enough: str = "",
    law: Fit | None = None,
) -> Selection:
    """Return whether two effects are enough, and better than the `singles`.

    enough : name of one that passes the tests alone
    law : fit of one whose law may differ, where that is the one
    """
    two = trial(ranked, baseline, alpha, seed)
    alone = [refit(two.view, fit.model, fit.by_key()) for fit in singles]
    fits, gates = {1: alone, 2: two.fits}, (*gates, *two.gates)
    gain = gain_of_two(two.view, two.null, two.fits, alone, law)
    if gain > WORTH and two.outcome == PASSES:
        doubts = (alternative_caveat(enough, gain),) if enough else ()
        return Selection(baseline, two.view, two.null, fits, gates, 2, False, doubts)
    return Selection(baseline, baseline, refit(baseline, (), baseline.values), fits, gates, 0, True, (), two.view)
