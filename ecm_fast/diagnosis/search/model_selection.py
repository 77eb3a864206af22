"""Model selection: no effect, one or two, as the tests say of the best explanation by each number."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..problem.law_tolerance import SHARES
from ..problem.linearization import Linearization
from ..problem.problem import Problem
from ..results.diagnosis import LackOfFit
from .calibration import calibrate
from .fit import Fit, refit
from .initial_values import initial_values
from .law_variants import zeroed
from .odds import alternative_caveat
from .outliers import drop_single_row_alarms, excess_noise
from .ranked_fits import Fits, best_of, fit_alone, fit_models, fit_pairs, fit_singles, least_evidence
from .result import LIMITS, Selection, implausible, leaves_most

__all__ = [
    "FAILS",
    "NO_GAIN",
    "OUTCOMES",
    "PASSES",
    "UNTRIED",
    "WORTH",
    "Trial",
    "gain_of_two",
    "search",
    "search_from",
    "second_effect",
    "select",
    "trial",
]

WORTH = 9.2
"""Evidence that a second name must add, whether or not a test still sees something beside the first."""
VARIED = 3.2
"""Evidence that a law as in the catalogue is ahead of one that differs, before the data speak: five to one."""
MOST_BENT = 0.15
"""Share of an effect by which its law may differ and still be its law: outside the catalogue it takes 28 % and more."""
LARGE = 2.5
"""Typical sizes from which on an effect may stand for another one of another law."""
_NEAR = 10.0  # evidence behind the best by which an effect of a zeroed camera is worth a fit
APART = 6.0
"""Evidence by which two effects must be ahead of a third one with another law: twenty to one."""
MENDS = 0.1
"""Share of an effect's sigmas that a second name may only mend in its law."""
_SPEAKS = 2.0  # evidence of a factor of e^2 = 7: as good as none is below it


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
    first = fit_singles(start.problem, start, start.noise, start, {})
    return select(baseline, start, gates, first, alpha, max_effects, seed)


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


def select(
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
    more = max_effects >= 2 and (one.outcome == FAILS or second_effect(one.view) > WORTH)
    varied = _varied(baseline, start, one, alpha, seed) if more or _in_doubt(one) else None
    two, alone = _two(baseline, start, one, varied, alpha, seed) if more and varied else (None, list[Fit]())
    answer = OUTCOMES[one.outcome, two.outcome if two else UNTRIED]
    if varied and one.outcome == PASSES and answer == "one":
        one = replace(one, fits=_with_varied(one, varied))
        one = varied if varied.outcome == PASSES and one.fits[0].varied else one
    if varied and varied.outcome == PASSES and one.outcome == FAILS and answer != "two":
        gates, one, two, answer = (*gates, *one.gates), varied, None, "one"
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


def trial(ranked: Fits, baseline: Linearization, alpha: float, seed: int) -> Trial:
    """Test the best of some explanations; rows on which an alarm rests alone are left out."""
    view, null, fits = ranked
    reduced, gates = drop_single_row_alarms(view, alpha, seed)
    if reduced is not view:
        known = {fit.model: fit for fit in fits}
        null, fits = refit(reduced, (), null.by_key()), fit_models(reduced, list(known), known)
    good = _admissible(fits, null, reduced, baseline) and not any(gate.alarm for gate in gates)
    return Trial(reduced, null, fits, gates, PASSES if good else FAILS)


def _in_doubt(one: Trial) -> bool:
    """Whether an explanation by one effect leaves room for another one whose law differs from the catalogue's."""
    if one.outcome == FAILS or not one.fits:
        return True
    (place,), candidates = one.fits[0].model, one.view.problem.candidates
    candidate = candidates[place]
    size = one.fits[0].by_key()[candidate.keys[0]] - candidate.start[0]
    best = max((evidence for evidence, _ in zeroed(one.view).values()), default=-np.inf)
    return abs(size) > LARGE * candidate.typical or best > one.view.gram.singles()[0][place] - _NEAR


def _varied(baseline: Linearization, start: Linearization, one: Trial, alpha: float, seed: int) -> Trial:
    """Try one effect whose law may differ from the catalogue's."""
    known = {fit.model: fit for fit in one.fits}
    ranked = fit_singles(baseline.problem, start, baseline.noise, replace(one.view, share=SHARES[0]), known)
    return trial(ranked, baseline, alpha, seed)


def _with_varied(one: Trial, varied: Trial) -> list[Fit]:
    """Return the fits of laws as in the catalogue with those, at odds, whose law may differ, the best first."""
    best = max((fit.evidence for fit in varied.fits), default=0.0)
    near = [fit for fit in varied.fits if fit.evidence > best - LIMITS[1] - VARIED and fit.bent < MOST_BENT]
    more = [refit(replace(one.view, share=fit.share), fit.model, fit.by_key()) for fit in near]
    at_odds = [replace(fit, evidence=fit.evidence - (VARIED if fit.share else 0.0)) for fit in more]
    return best_of([*one.fits, *at_odds], one.view)


def _two(
    baseline: Linearization, start: Linearization, one: Trial, varied: Trial, alpha: float, seed: int
) -> tuple[Trial, list[Fit]]:
    """Try two effects; return the trial, and the fits of its best two and, if that passes, the best one, each alone."""
    begin = initial_values(one.view, least_evidence(float(one.view.rest[2].singles()[0].max(initial=-np.inf))))
    views = _with_initial_values(start, begin), _with_initial_values(one.view, begin)
    view, null, fits = fit_pairs(baseline.problem, *views, baseline.noise, one.fits)
    alone = fit_alone(view, fits, one.fits[:1] if one.outcome == PASSES else [])
    law = varied.fits[0] if varied.outcome == PASSES else None
    gain = gain_of_two(view, null, fits, alone, law)
    if gain <= WORTH or implausible(fits[0], view):
        return Trial(view, null, fits, (), NO_GAIN, gain), alone
    return replace(trial((view, null, fits), baseline, alpha, seed), gain=gain), alone


def gain_of_two(view: Linearization, null: Fit, pairs: Sequence[Fit], alone: Sequence[Fit], law: Fit | None) -> float:
    """Return the evidence that two effects have over fewer; a second name is given from `WORTH` on.

    Parameters
    ----------
    view, null, pairs : the view at the best two, the fit without effects there, and all fits of two, the best first
    alone : fits of one effect there
    law : the fit of one effect that passes the tests with a law that differs, if any does: two must be ahead of that,
        and a second name beside its own say more than what it mends in its law
    """
    fewer = max((fit.evidence for fit in (null, *alone)), default=0.0)
    if law is not None and law.varied:
        again = refit(replace(view, share=law.share), law.model, law.by_key())
        mends = pairs and set(again.model) < set(pairs[0].model)
        least = MENDS**2 * (null.total - again.total) if mends else APART
        fewer = max(fewer, again.evidence + least - WORTH)
    return pairs[0].evidence - fewer if pairs else 0.0


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
    found = fit_singles(baseline.problem, start, baseline.noise, two.view, known)
    again = trial(found, baseline, alpha, seed)
    return replace(again, gates=(*one.gates, *again.gates))


def second_effect(view: Linearization) -> float:
    """Return the evidence, on the linear model, that the best two effects have more than the best one."""
    return float(view.gram.pairs().evidence.max(initial=-np.inf) - view.gram.singles()[0].max(initial=-np.inf))


def _with_initial_values(view: Linearization, begin: dict[str, float]) -> Linearization:
    """Return a view with further parameters of effects where they begin."""
    return Linearization.at(view.problem, {**view.values, **begin}, view.model, view.noise) if begin else view


def _admissible(fits: list[Fit], null: Fit, view: Linearization, baseline: Linearization) -> bool:
    if not fits or implausible(fits[0], view) or leaves_most(view, baseline):
        return False
    return fits[0].bent <= MOST_BENT and fits[0].evidence - null.evidence > _SPEAKS
