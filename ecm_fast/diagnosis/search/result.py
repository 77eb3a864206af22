"""Result of the search, and the rule by which an explanation is implausible."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..problem.linearization import Linearization
from ..results.diagnosis import LackOfFit, Model
from .fit import Fit

__all__ = ["LIMITS", "Selection", "implausible", "leaves_most"]

Array = NDArray[np.float64]

LIMITS = {1: 5.0, 2: 9.2}
"""Evidence that a model of so many effects may lack to the best one and still be indistinguishable from it.

A given wrong rival leads the truth by that much with a chance of at most Phi(-sqrt(limit)), 1.3 % of one effect's."""
_PLAUSIBLE = 6.0
"""Typical sizes beyond which a name is refused: a neck 0.13 rad bent by itself, a tendon 18 mm off its place."""
_VISIBLE, _LEFT_OVER = 2.0, 0.5
"""Times the noise from which on a misfit is far beyond it, and the share of its square that an answer may leave."""


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
        return tuple(fit for fit in fits if not implausible(fit, self.view))

    def names(self, fit: Fit) -> tuple[str, ...]:
        """Return the names of what a fit has in the model."""
        return tuple(self.view.problem.candidates[i].name for i in fit.model)

    def models(self) -> tuple[Model, ...]:
        """Return all explanations tried, those of the number reported first."""
        order = [self.effects, *(size for size in self.fits if size != self.effects)]
        return tuple(model for size in order if size for model in self._models(size))

    def _models(self, size: int) -> Iterable[Model]:
        fits, candidates = self.fits.get(size, []), self.view.problem.candidates
        known = [fit.evidence for fit in fits if not implausible(fit, self.view)] or [fit.evidence for fit in fits]
        best = max(known, default=-np.inf)
        for fit in fits:
            reason = implausible(fit, self.view)
            behind = best - fit.evidence
            sizes = tuple(fit.by_key()[candidates[i].keys[0]] for i in fit.model)
            names = self.names(fit)
            inside = size == (self.effects or size) and not reason and behind < LIMITS[size]
            yield Model(
                names, sizes, fit.evidence - self.null.evidence, self.null.total - fit.total, behind, inside, reason
            )


def implausible(fit: Fit, view: Linearization) -> str:
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


def leaves_most(view: Linearization, baseline: Linearization) -> bool:
    """Whether an explanation leaves most of a misfit that is far beyond the noise as it is known."""
    before, after = (float(np.mean(each.left[each.used] ** 2)) for each in (baseline, view))
    return before > _VISIBLE**2 and after > _LEFT_OVER * before
