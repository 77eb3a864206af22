"""Separation of a hidden effect from every explanation that could be taken for it."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ecm_fast.data.measurements import Measurements
from ecm_fast.diagnosis.problem.linearization import Linearization
from ecm_fast.diagnosis.search.calibration import calibrate
from ecm_fast.diagnosis.search.fit import Fit, refit
from ecm_fast.diagnosis.search.initial_values import initial_values
from ecm_fast.mechanism.mechanism import Mechanism
from ecm_fast.studies.diagnosis import Study

__all__ = ["Standing", "beside", "standing"]

Priors = Mapping[str, tuple[float, float]]

_AGAIN = 6
_TIMES = (1.0 / 16.0, 0.25, 4.0)
"""Multiples of its usual value at which a further parameter may begin."""
_ANY = 1e3
"""Typical sizes up to which a rival may be as large as it likes."""


@dataclass(frozen=True)
class Standing:
    """Distances in standard deviations of the noise that the measurements declare.

    Attributes
    ----------
    sigmas : from the mechanism with no effect, EA, GA and EI fitted
    apart : from the nearest single effect of any size, or from none if that is nearer
    rival : its name, empty for none
    """

    sigmas: float
    apart: float
    rival: str


def standing(
    mechanism: Mechanism,
    data: Measurements,
    hidden: Collection[str] = (),
    rivals: int = 8,
    priors: Priors | None = None,
) -> Standing:
    """Return how far poses without noise are from the nearest explanation by another effect than those `hidden`.

    So many `rivals`, those that come nearest in the linear model, are fitted in full with EA, GA and EI, to the rows
    that a diagnosis would see, also from where their further parameters are far from usual; what the best fit, `priors`
    of EA, GA and EI included, leaves is the distance, whatever its size.
    """
    view, null = _of_any_size(mechanism, data, priors)
    candidates, views = view.problem.candidates, [view, *_elsewhere(view)] if rivals else [view]
    evidence = np.array([np.where(at.gram.norm > 0.0, at.gram.singles()[0], -np.inf) for at in views])
    near = [int(i) for i in np.argsort(-evidence.max(axis=0)) if candidates[i].name not in hidden][:rivals]
    begin = {(i, n) for i in near for n in (0, int(np.argmax(evidence[:, i])))}
    left = [(_left(view, _settled(view, i, views[n])), candidates[i].name) for i, n in sorted(begin)]
    least, rival = min([(null.total, ""), *left])
    return Standing(float(np.sqrt(max(null.total, 0.0))), float(np.sqrt(max(least, 0.0))), rival)


def beside(
    mechanism: Mechanism, data: Measurements, hidden: Collection[str], priors: Priors | None = None
) -> dict[str, float]:
    """Return how far each of two hidden effects stands out where the other one, of any size, is in the model [sigma].

    data : poses without noise that hold both
    """
    view, _ = _of_any_size(mechanism, data, priors)
    place = {candidate.name: i for i, candidate in enumerate(view.problem.candidates)}
    one, other = hidden
    return {name: float(np.sqrt(max(_left(view, _settled(view, place[rest], view)), 0.0)))
            for name, rest in ((one, other), (other, one))}  # fmt: skip


def _of_any_size(mechanism: Mechanism, data: Measurements, priors: Priors | None) -> tuple[Linearization, Fit]:
    """Return the view in which effects may be as large as they like, and the fit without any."""
    problem = Study(mechanism, data, priors=priors or {}).problem()
    problem.drift, problem.tolerances = 0.0, {}
    problem.candidates = tuple(replace(entry, spread=(_ANY * entry.typical, *entry.spread[1:])) for entry in
                               problem.candidates)  # fmt: skip
    values, noise = calibrate(problem)
    view = Linearization.at(problem, values, (), noise, known=True)
    null = refit(view, (), values)
    return Linearization.at(problem, {**values, **initial_values(view)}, (), noise, known=True), null


def _elsewhere(view: Linearization) -> list[Linearization]:
    """Return views with the further parameters of effects far from where one expects them."""
    further = [entry for c in view.problem.candidates for entry in
               zip(c.keys[1:], c.start[1:], c.lower[1:], c.upper[1:], strict=True)]  # fmt: skip
    found = []
    for by in _TIMES:
        moved = {key: float(np.clip(by * value, lower, upper)) for key, value, lower, upper in further}
        found.append(Linearization.at(view.problem, {**view.values, **moved}, (), view.noise, known=True))
    return found


def _settled(view: Linearization, i: int, begin: Linearization) -> Fit:
    """Return the fit of one effect, taken up until it is at its minimum, from where another view says."""
    fit = refit(view, (i,), begin.linear_start((i,)))
    for _ in range(_AGAIN):
        if fit.settled or not np.isfinite(fit.total):
            break
        fit = refit(view, (i,), fit.by_key())
    return fit


def _left(view: Linearization, fit: Fit) -> float:
    """Return the sum of squares without what the effect's own prior adds to it."""
    candidate, values = view.problem.candidates[fit.model[0]], fit.by_key()
    own = zip(candidate.keys, candidate.start, candidate.spread, strict=True)
    return fit.total - sum(((values[key] - start) / spread) ** 2 for key, start, spread in own)
