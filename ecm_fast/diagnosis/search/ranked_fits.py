"""Full fits of the explanations that the linear model ranks first: by one effect, and by two."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...identification.noise import ReadingNoise
from ..problem.law_tolerance import SHARES
from ..problem.linearization import Linearization
from ..problem.problem import Problem
from .fit import Fit, refit
from .law_variants import zeroed
from .result import implausible

__all__ = ["Fits", "fit_alone", "fit_models", "fit_pairs", "fit_singles", "least_evidence"]

Array = NDArray[np.float64]
Fits = tuple[Linearization, Fit, list[Fit]]
"""The view at the best explanation, the fit without effects there, and all fits, the best first."""

_LEFT, _SINGLES, _PAIRS = 30.0, 12, 30
"""Evidence behind the best up to which models are fitted in full, and the fewest of one effect and of two."""
_VARIED_PASSES, _TOPS = 2, 3  # passes of laws that may differ, and fits for which every share is tried
_ZEROED = 4  # effects of a camera that was zeroed at rest, tried in full
_ROUGH = 0.3
"""Share of the best evidence by which the linear ranking may be wrong."""
_PASSES = 3  # at most, of ranking by the linear fit and fitting in full
_HOPELESS = 100.0  # chi2 behind the last fit: it will not come back
_AGAIN, _GAIN = 3, 0.5  # new starts at most, and the least chi2 that makes another one worth it


def fit_singles(
    problem: Problem,
    baseline: Linearization,
    noise: ReadingNoise,
    view: Linearization,
    known: dict[tuple[int, ...], Fit],
) -> Fits:
    """Return the view at the best single effect, the fit without any there, and all fits, the best first.

    The search begins at `view`, with the fits that are `known` as starts; if that is tolerant, all of it is.
    """
    best, starts, begin = None, dict(known), dict[tuple[int, ...], float]()
    if view.share is not None:
        leading = sorted(zeroed(replace(view, share=None)).items(), key=lambda item: -item[1][0])[:_ZEROED]
        begin = {(i,): size for i, (evidence, size) in leading if evidence > 0.0}
    for _ in range(_PASSES if view.share is None else _VARIED_PASSES):
        evidence, _ = view.gram.singles()
        leaders = [(int(i),) for i in _leaders(evidence, view.gram.norm > 0.0, _SINGLES)]
        again = [model for model in starts if len(model) == 1 and _near(starts, model)]
        models = dict.fromkeys([*leaders, *begin, *again])
        null = refit(view, (), baseline.values)
        fits = fit_models(view, models, starts)
        for model, size in begin.items():
            fits.append(refit(view, model, {**null.by_key(), view.problem.candidates[model[0]].keys[0]: size}))
        if view.share is not None:
            tops = best_of(fits, view)[:_TOPS]
            others = [replace(view, share=share) for share in SHARES if share != view.share]
            fits += [refit(other, fit.model, fit.by_key()) for other in others for fit in tops]
        fits = best_of(fits, view)
        starts.update({fit.model: fit for fit in fits})
        if not fits:
            return view, null, fits
        if fits[0].model == best:
            break
        best = fits[0].model
        view = Linearization.at(problem, {**baseline.values, **fits[0].by_key()}, best, noise, share=fits[0].share)
    return view, null, fits


def fit_pairs(
    problem: Problem, baseline: Linearization, single: Linearization, noise: ReadingNoise, singles: list[Fit]
) -> Fits:
    """Return the view at the best pair of effects, the fit without any there, and all fits, the best first."""
    view, best, starts = single, None, {fit.model: fit for fit in singles}
    views = [baseline, single]
    for _ in range(_PASSES):
        models: dict[tuple[int, ...], None] = {} if best is None else {best: None}
        for each in views:
            linear = each.gram.pairs()
            visible = (each.gram.norm[linear.first] > 0.0) & (each.gram.norm[linear.second] > 0.0)
            for n in _leaders(linear.evidence, visible, _PAIRS // len(views) + 3):
                models[int(linear.first[n]), int(linear.second[n])] = None
        null = refit(view, (), baseline.values)
        fits = fit_models(view, list(models), starts)
        starts.update({fit.model: fit for fit in fits})
        if not fits or fits[0].model == best:
            break
        best = fits[0].model
        view = Linearization.at(problem, {**baseline.values, **fits[0].by_key()}, best, noise)
        views = [baseline, view]
    return view, null, fits


def fit_alone(view: Linearization, pairs: list[Fit], others: list[Fit]) -> list[Fit]:
    """Return the fits with one effect of the best pair alone, and those of others again, the best first."""
    if not pairs:
        return []
    starts = {(i,): pairs[0] for i in pairs[0].model} | {fit.model: fit for fit in others}
    fits = [refit(view, model, fit.by_key()) for model, fit in starts.items()]
    return [fit for fit in _ranked(fits, view) if not implausible(fit, view)]


def fit_models(view: Linearization, models: Iterable[tuple[int, ...]], known: dict[tuple[int, ...], Fit]) -> list[Fit]:
    """Fit explanations; the best one, where it has not settled, until it does or gains no more."""
    fits, limit = list[Fit](), np.inf
    for model in models:
        fits.append(refit(view, model, _start(view, model, known), limit))
        limit = min(limit, fits[-1].total + _HOPELESS)
    fits = _ranked(fits, view)
    for _ in range(_AGAIN):
        if not fits or fits[0].settled:
            break
        again = refit(view, fits[0].model, fits[0].by_key())
        gain = fits[0].total - again.total
        fits = _ranked([again, *fits[1:]], view) if gain > 0.0 else fits
        if gain < _GAIN:
            break
    return fits


def _start(view: Linearization, model: tuple[int, ...], known: dict[tuple[int, ...], Fit]) -> dict[str, float]:
    """Return where to start: at the same fit of before, else at what the linear model says."""
    if model in known:
        return known[model].by_key()
    part = max((fit for key, fit in known.items() if set(key) < set(model)), key=lambda fit: fit.evidence, default=None)
    if part is None or not part.model:
        return view.linear_start(model)
    return {**view.linear_start(model), **part.by_key()}


def _ranked(fits: list[Fit], view: Linearization) -> list[Fit]:
    """Return the fits, the best first, those that cannot be meant last."""
    return sorted(
        (fit for fit in fits if np.isfinite(fit.total)), key=lambda fit: (bool(implausible(fit, view)), -fit.evidence)
    )


def best_of(fits: Iterable[Fit], view: Linearization) -> list[Fit]:
    """Return the best fit by each explanation, the best first."""
    best = dict[tuple[int, ...], Fit]()
    for fit in fits:
        if fit.model not in best or fit.evidence > best[fit.model].evidence:
            best[fit.model] = fit
    return _ranked(list(best.values()), view)


def _leaders(evidence: Array, allowed: NDArray[np.bool_], most: int) -> NDArray[np.int64]:
    """Return the places of the largest evidence, those far behind left out."""
    evidence = np.where(allowed, evidence, -np.inf)
    order = np.argsort(-evidence)[:most]
    if not order.size:
        return order
    return order[evidence[order] > least_evidence(float(evidence[order[0]]))]


def least_evidence(best: float) -> float:
    """Return the evidence that an explanation must have on the linear model to be worth a fit beside the best one."""
    return best - max(_LEFT, _ROUGH * best)


def _near(known: dict[tuple[int, ...], Fit], model: tuple[int, ...]) -> bool:
    """Whether a fit of before is worth another."""
    return known[model].evidence > max(fit.evidence for fit in known.values()) - _LEFT
