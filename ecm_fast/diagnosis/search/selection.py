"""Model selection: no effect, one or two; a linear ranking of all, then full fits of the best."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...identification.noise import ReadingNoise
from ..problem.linearization import Linearization
from ..problem.problem import Problem
from ..results.diagnosis import LackOfFit, Model
from .calibration import calibrate
from .fit import Fit, refit
from .initial_values import initial_values
from .odds import alternative_caveat
from .outliers import drop_single_row_alarms, excess_noise

__all__ = [
    "FAILS",
    "LIMITS",
    "NO_GAIN",
    "OUTCOMES",
    "PASSES",
    "UNTRIED",
    "WORTH",
    "Fits",
    "Selection",
    "Trial",
    "fit_models",
    "fit_pairs",
    "leaves_most",
    "onward",
    "refused",
    "search",
    "search_from",
    "second_effect",
    "trial",
]

Array = NDArray[np.float64]
Fits = tuple[
    Linearization, Fit, list[Fit]
]  # the view at the best explanation, the fit without effects there, and theirs

LIMITS = {1: 5.0, 2: 9.2}
"""Evidence that a model of so many effects may lack to the best one and still be told from it by nobody.

A given wrong rival leads the truth by that much with a chance of at most Phi(-sqrt(limit)), 1.3 % of one effect's."""
_PLAUSIBLE = 6.0
"""Typical sizes beyond which a name is refused: a neck 0.13 rad bent by itself, a tendon 18 mm off its place."""
_VISIBLE, _LEFT_OVER = 2.0, 0.5
"""Times the noise from which on a misfit is far beyond it, and the share of its square that an answer may leave."""
_LEFT, _SINGLES, _PAIRS = 30.0, 12, 30
"""Evidence behind the best up to which models are fitted in full, and the fewest of one effect and of two."""
_ROUGH = 0.3
"""Share of the best evidence by which the linear ranking may be wrong."""
_PASSES = 3  # at most, of ranking by the linear fit and fitting in full
WORTH = 9.2
"""Evidence that a second name must add, whether or not a test still sees something beside the first."""
_SPEAKS = 2.0  # evidence of a factor of e^2 = 7: as good as none is below it
_HOPELESS = 100.0  # chi2 behind the last fit: it will not come back
_AGAIN, _GAIN = 3, 0.5  # new starts at most, and the least chi2 that makes another one worth it


@dataclass(frozen=True, eq=False)
class Selection:
    """Result of the search.

    Attributes
    ----------
    baseline, view : the linear model without effects, and with those found
    fits : by number of effects, the best first
    models : the same for readers
    gates : in the order of the tests
    effects : how many were found
    outside : whether something is left that no admissible model explains
    doubts : what to know
    closest : the view at what comes nearest, where that does not explain
    """

    baseline: Linearization
    view: Linearization
    null: Fit
    fits: dict[int, list[Fit]]
    gates: tuple[LackOfFit, ...]
    effects: int
    outside: bool
    doubts: tuple[str, ...]
    closest: Linearization | None = None

    @property
    def scale(self) -> Array:
        """Noise seen over noise assumed, by channel, where the model comes nearest to the data."""
        return (self.closest or self.view).cleaned.scale

    @property
    def best(self) -> Fit:
        """The fit that is reported."""
        return self.fits[self.effects][0] if self.effects else self.null

    @property
    def closest_fit(self) -> Fit | None:
        """The explanation that comes nearest, whether or not it explains."""
        fits = next((self.fits[size] for size in sorted(self.fits, reverse=True) if self.fits[size]), [])
        return fits[0] if fits else None

    @property
    def runners_up(self) -> tuple[Fit, ...]:
        """Explanations by as many effects as were found that can be meant, too, the best first."""
        fits = self.fits[self.effects][1:] if self.effects else []
        return tuple(fit for fit in fits if not refused(fit, self.view))

    def names(self, fit: Fit) -> tuple[str, ...]:
        """Return the names of what a fit has in the model."""
        return tuple(self.view.problem.candidates[i].name for i in fit.model)

    def models(self) -> tuple[Model, ...]:
        """Return all explanations tried, those of the number reported first."""
        order = [self.effects, *(size for size in self.fits if size != self.effects)]
        return tuple(model for size in order if size for model in self._models(size))

    def _models(self, size: int) -> Iterable[Model]:
        fits, candidates = self.fits.get(size, []), self.view.problem.candidates
        known = [fit.evidence for fit in fits if not refused(fit, self.view)] or [fit.evidence for fit in fits]
        best = max(known, default=-np.inf)
        for fit in fits:
            reason = refused(fit, self.view)
            behind = best - fit.evidence
            sizes = tuple(fit.by_key()[candidates[i].keys[0]] for i in fit.model)
            names = self.names(fit)
            inside = size == (self.effects or size) and not reason and behind < LIMITS[size]
            yield Model(
                names, sizes, fit.evidence - self.null.evidence, self.null.total - fit.total, behind, inside, reason
            )


def refused(fit: Fit, view: Linearization) -> str:
    """Return why an explanation cannot be meant, empty if it can."""
    values = fit.by_key()
    for i in fit.model:
        candidate = view.problem.candidates[i]
        size = (values[candidate.keys[0]] - candidate.start[0]) / candidate.typical
        if abs(size) > _PLAUSIBLE:
            return f"{candidate.name} would need {abs(size):.0f} times its typical size"
        if candidate.one_sided and size <= 0.0:
            return f"{candidate.name} would have to be negative"
    return ""


def search(problem: Problem, alpha: float, max_effects: int, seed: int) -> Selection:
    """Search for what the measurements ask for."""
    values, noise = calibrate(problem)
    return search_from(Linearization.at(problem, values, (), noise), alpha, max_effects, seed)


def search_from(baseline: Linearization, alpha: float, max_effects: int, seed: int) -> Selection:
    """Search from the calibrated model without effects."""
    baseline, gates = drop_single_row_alarms(baseline, alpha, seed)
    if not any(gate.alarm for gate in gates) or max_effects < 1:
        louder, null = excess_noise(baseline), refit(baseline, (), baseline.values)
        return Selection(baseline, baseline, null, {}, gates, 0, bool(louder), louder)
    start = _with_initial_values(baseline, initial_values(baseline))
    first = _singles(start.problem, start, start.noise, start, {})
    return onward(baseline, start, gates, first, alpha, max_effects, seed)


UNTRIED, NO_GAIN, FAILS, PASSES = "untried", "no gain", "fails", "passes"
OUTCOMES = {
    # one effect, two effects: answer
    (PASSES, UNTRIED): "one",
    (PASSES, NO_GAIN): "one",
    (PASSES, FAILS): "one",
    (PASSES, PASSES): "two",
    (FAILS, UNTRIED): "none",
    (FAILS, NO_GAIN): "another one",  # which the search for two may have come upon
    (FAILS, FAILS): "none",
    (FAILS, PASSES): "two",
}
"""The answer by what the tests say of the best explanation by one effect, and by two.

Two are tried where one fails, and where one passes but the evidence is for two: as the better part of two a wrong name
may pass all tests."""


@dataclass(frozen=True, eq=False)
class Trial:
    """Explanations by one number of effects, and what the tests say of the best.

    Attributes
    ----------
    view, null, fits : the view at the best, the fit without effects there, and all fits, the best first
    gates : tests for more than the best has
    outcome : passes, fails, or no gain over fewer effects
    gain : evidence of the best over that of fewer effects
    """

    view: Linearization
    null: Fit
    fits: list[Fit]
    gates: tuple[LackOfFit, ...] = ()
    outcome: str = UNTRIED
    gain: float = 0.0


def onward(
    baseline: Linearization,
    start: Linearization,
    gates: tuple[LackOfFit, ...],
    first: Fits,
    alpha: float,
    max_effects: int,
    seed: int,
) -> Selection:
    """Go on from the single effects; the answer is that of `OUTCOMES`.

    The search began at `start`, the baseline with further parameters of effects where they begin.
    """
    one = trial(first, baseline, alpha, seed)
    two, alone = None, list[Fit]()
    if max_effects >= 2 and (one.outcome == FAILS or second_effect(one.view) > WORTH):
        two, alone = _two(baseline, start, one, alpha, seed)
    answer = OUTCOMES[one.outcome, two.outcome if two else UNTRIED]
    if answer == "another one" and two:
        again = _another(baseline, start, one, two, alone, alpha, seed)
        one, two = (again, None) if again else (one, two)
        answer = "one" if one.outcome == PASSES else "none"
    fits = {1: one.fits} | ({2: two.fits} if two else {})
    gates = (*gates, *one.gates)
    if answer == "one":
        return Selection(baseline, one.view, one.null, fits, gates, 1, False, ())
    gates = (*gates, *(two.gates if two else ()))
    if answer == "two" and two:
        name = baseline.problem.candidates[one.fits[0].model[0]].name
        doubts = (alternative_caveat(name, two.gain),) if one.outcome == PASSES else ()
        return Selection(baseline, two.view, two.null, fits, gates, 2, False, doubts)
    closest = two.view if two and two.outcome == FAILS else one.view
    return Selection(baseline, baseline, refit(baseline, (), baseline.values), fits, gates, 0, True, (), closest)


def trial(found: Fits, baseline: Linearization, alpha: float, seed: int) -> Trial:
    """Test the best of some explanations; rows on which an alarm rests alone are left out."""
    view, null, fits = found
    reduced, gates = drop_single_row_alarms(view, alpha, seed)
    if reduced is not view:
        known = {fit.model: fit for fit in fits}
        null, fits = refit(reduced, (), null.by_key()), fit_models(reduced, list(known), known)
    good = _admissible(fits, null, reduced, baseline) and not any(gate.alarm for gate in gates)
    return Trial(reduced, null, fits, gates, PASSES if good else FAILS)


def _two(baseline: Linearization, start: Linearization, one: Trial, alpha: float, seed: int) -> tuple[Trial, list[Fit]]:
    """Try two effects; return the trial, and the fits of its best two and, if that passes, the best one, each alone."""
    begin = initial_values(one.view, _least(float(one.view.rest[2].singles()[0].max(initial=-np.inf))))
    views = _with_initial_values(start, begin), _with_initial_values(one.view, begin)
    view, null, fits = fit_pairs(baseline.problem, *views, baseline.noise, one.fits)
    alone = _alone(view, fits, one.fits[:1] if one.outcome == PASSES else [])
    single = max((fit.evidence for fit in alone), default=null.evidence)
    gain = fits[0].evidence - single if fits else 0.0
    if gain <= WORTH or refused(fits[0], view):
        return Trial(view, null, fits, (), NO_GAIN, gain), alone
    return replace(trial((view, null, fits), baseline, alpha, seed), gain=gain), alone


def _another(
    baseline: Linearization,
    start: Linearization,
    one: Trial,
    two: Trial,
    alone: list[Fit],
    alpha: float,
    seed: int,
) -> Trial | None:
    """Try the single effect that the search for two found to be better; None where it found none."""
    better = [fit for fit in alone[:1] if fit.evidence - two.null.evidence > _SPEAKS]
    if not better or better[0].model == one.fits[0].model:
        return None
    known = {fit.model: fit for fit in (*one.fits, *alone)}
    found = _singles(baseline.problem, start, baseline.noise, two.view, known)
    again = trial(found, baseline, alpha, seed)
    return replace(again, gates=(*one.gates, *again.gates))


def second_effect(view: Linearization) -> float:
    """Return the evidence, on the linear model, that the best two effects have more than the best one."""
    return float(view.gram.pairs().evidence.max(initial=-np.inf) - view.gram.singles()[0].max(initial=-np.inf))


def _with_initial_values(view: Linearization, begin: dict[str, float]) -> Linearization:
    """Return a view with further parameters of effects where they begin."""
    return Linearization.at(view.problem, {**view.values, **begin}, view.model, view.noise) if begin else view


def _admissible(fits: list[Fit], null: Fit, view: Linearization, baseline: Linearization) -> bool:
    if not fits or refused(fits[0], view) or fits[0].evidence - null.evidence <= _SPEAKS:
        return False
    return not leaves_most(view, baseline)


def leaves_most(view: Linearization, baseline: Linearization) -> bool:
    """Whether an explanation leaves most of a misfit that is far beyond the noise as it is known."""
    before, after = (float(np.mean(each.raw[each.used] ** 2)) for each in (baseline, view))
    return before > _VISIBLE**2 and after > _LEFT_OVER * before


def _alone(view: Linearization, pairs: list[Fit], others: list[Fit]) -> list[Fit]:
    """Return the fits with one effect of the best pair alone, and those of others again, the best first."""
    if not pairs:
        return []
    starts = {(i,): pairs[0] for i in pairs[0].model} | {fit.model: fit for fit in others}
    fits = [refit(view, model, fit.by_key()) for model, fit in starts.items()]
    return [fit for fit in _ranked(fits, view) if not refused(fit, view)]


def _singles(
    problem: Problem,
    baseline: Linearization,
    noise: ReadingNoise,
    view: Linearization,
    known: dict[tuple[int, ...], Fit],
) -> tuple[Linearization, Fit, list[Fit]]:
    """Return the view at the best single effect, the fit without any there, and all fits, the best first.

    The search begins at `view`, with the fits that are `known` as starts.
    """
    best, starts = None, dict(known)
    for _ in range(_PASSES):
        evidence, _ = view.gram.singles()
        models = [(int(i),) for i in _leaders(evidence, view.gram.norm > 0.0, _SINGLES)]
        models = list(
            dict.fromkeys([*models, *(model for model in starts if len(model) == 1 and _near(starts, model))])
        )
        null = refit(view, (), baseline.values)
        fits = fit_models(view, models, starts)
        starts.update({fit.model: fit for fit in fits})
        if not fits:
            return view, null, fits
        if fits[0].model == best:
            break
        best = fits[0].model
        view = Linearization.at(problem, {**baseline.values, **fits[0].by_key()}, best, noise)
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


def _near(known: dict[tuple[int, ...], Fit], model: tuple[int, ...]) -> bool:
    """Whether a fit of before is worth another."""
    return known[model].evidence > max(fit.evidence for fit in known.values()) - _LEFT


def _leaders(evidence: Array, allowed: NDArray[np.bool_], most: int) -> NDArray[np.int64]:
    """Return the places of the largest evidence, those far behind left out."""
    evidence = np.where(allowed, evidence, -np.inf)
    order = np.argsort(-evidence)[:most]
    if not order.size:
        return order
    return order[evidence[order] > _least(float(evidence[order[0]]))]


def _least(best: float) -> float:
    """Return the evidence that an explanation must have on the linear model to be worth a fit beside the best one."""
    return best - max(_LEFT, _ROUGH * best)


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
        more = refit(view, fits[0].model, fits[0].by_key())
        gain = fits[0].total - more.total
        fits = _ranked([more, *fits[1:]], view) if gain > 0.0 else fits
        if gain < _GAIN:
            break
    return fits


def _ranked(fits: list[Fit], view: Linearization) -> list[Fit]:
    """Return the fits, the best first, those that cannot be meant last."""
    return sorted(
        (fit for fit in fits if np.isfinite(fit.total)), key=lambda fit: (bool(refused(fit, view)), -fit.evidence)
    )


def _start(view: Linearization, model: tuple[int, ...], known: dict[tuple[int, ...], Fit]) -> dict[str, float]:
    """Return where to start: at the same fit of before, else at what the linear model says."""
    if model in known:
        return known[model].by_key()
    part = max((fit for key, fit in known.items() if set(key) < set(model)), key=lambda fit: fit.evidence, default=None)
    if part is None or not part.model:
        return view.linear_start(model)
    return {**view.linear_start(model), **part.by_key()}
