"""How far what is hidden in simulated poses is from everything that could be taken for it."""

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from ..data import Measurements
from ..mechanism import Mechanism
from . import further
from .calibration import calibrate
from .refit import Fit, refit
from .study import Study
from .view import View

__all__ = ["Standing", "standing"]

_AGAIN = 6
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


def standing(mechanism: Mechanism, data: Measurements, hidden: Collection[str] = (), rivals: int = 8) -> Standing:
    """Return how far poses without noise are from the nearest explanation by another effect than those `hidden`.

    So many `rivals`, those that come nearest in the linear model, are fitted in full with EA, GA and EI, to the rows
    that a diagnosis would see; what the fit leaves is the distance, whatever its size.
    """
    problem = Study(mechanism, data).problem()
    problem.candidates = tuple(replace(entry, spread=(_ANY * entry.typical, *entry.spread[1:])) for entry in
                               problem.candidates)  # fmt: skip
    values, noise = calibrate(problem)
    view = View.at(problem, values, (), noise, known=True)
    null = refit(view, (), values)
    view = View.at(problem, {**values, **further.starts(view)}, (), noise, known=True)
    evidence = np.where(view.gram.norm > 0.0, view.gram.singles()[0], -np.inf)
    near = [int(i) for i in np.argsort(-evidence) if problem.candidates[i].name not in hidden][:rivals]
    left = [(null.total, ""), *((_left(view, _settled(view, i)), problem.candidates[i].name) for i in near)]
    least, rival = min(left)
    return Standing(float(np.sqrt(max(null.total, 0.0))), float(np.sqrt(max(least, 0.0))), rival)


def _settled(view: View, i: int) -> Fit:
    """Return the fit of one effect, taken up until it is at its minimum."""
    fit = refit(view, (i,), view.linear_start((i,)))
    for _ in range(_AGAIN):
        if fit.settled or not np.isfinite(fit.total):
            break
        fit = refit(view, (i,), fit.by_key())
    return fit


def _left(view: View, fit: Fit) -> float:
    """Return the sum of squares without what the effect's own prior adds to it."""
    candidate, values = view.problem.candidates[fit.model[0]], fit.by_key()
    own = zip(candidate.keys, candidate.start, candidate.spread, strict=True)
    return fit.total - sum(((values[key] - start) / spread) ** 2 for key, start, spread in own)
