"""What loads can show of the catalogue: sizes that would be found, and names that would not be told apart."""

import numpy as np
from numpy.typing import NDArray

from ..problem.candidates import lacking
from ..problem.linearization import View
from ..results.diagnosis import Sight
from ..statistics.lack_of_fit import NAMED, null_quantile
from ..statistics.size_prior import SIZE_SPREAD
from .elsewhere import elsewhere

__all__ = ["distances", "sights"]

Array = NDArray[np.float64]

_FOUND = 1.2816
"""Standard deviations by which nine in ten are above."""
_TOLD = 4.0
_PLAUSIBLE = 10.0
_SEEN = 2.0
"""Typical sizes up to which an effect that would be found counts as visible."""
_ABSORBED = 0.5
_RIVALS = 5


def distances(view: View) -> tuple[Array, Array, Array]:
    """Return sigmas of typical sizes (k,), cosines (k, k), and sigmas from a typical size to any of another (k, k).

    A rival that would have to be implausibly large is infinitely far away.
    """
    gram = view.gram
    sigmas, cosine = gram.norm / SIZE_SPREAD, np.clip(gram.cosine, -1.0, 1.0)
    apart = sigmas[:, None] * np.sqrt(1.0 - cosine**2)
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.abs(cosine) * sigmas[:, None] / sigmas
    apart[~(needed <= _PLAUSIBLE)] = np.inf
    wrong_sign = gram.one_sided[None, :] & gram.one_sided[:, None] & (cosine < 0.0)
    apart = np.where(wrong_sign, sigmas[:, None], apart)
    np.fill_diagonal(apart, np.inf)
    return sigmas, cosine, np.asarray(apart)


def sights(view: View, alpha: float, seed: int) -> tuple[Sight, ...]:
    """Return what the rows of a view can show of every candidate."""
    gram, candidates = view.gram, view.problem.candidates
    if not candidates:
        return ()
    sigmas, cosine, apart = distances(view)
    needed = null_quantile(gram, view.cleaned.trusted_dof(), NAMED * alpha, seed) + _FOUND
    seen = needed <= _SEEN * sigmas
    rival = np.where(seen[None, :], apart, np.inf)
    what, then = elsewhere(view)
    answer = []
    for i, candidate in enumerate(candidates):
        smallest = needed / sigmas[i] * candidate.typical if sigmas[i] > 0.0 else np.inf
        kept = float(gram.norm[i] / gram.raw[i]) if gram.raw[i] > 0.0 else 0.0
        needs = lacking(candidate.effect, view.problem.data)
        nearest = [int(j) for j in np.argsort(apart[i])[:_RIVALS] if np.isfinite(apart[i, j])]
        named = seen[i] and float(rival[i].min(initial=np.inf)) > _TOLD
        lost = gram.raw[i] / SIZE_SPREAD * _SEEN >= needed and kept < _ABSORBED
        visible = "named" if named else "seen" if seen[i] else "absorbed" if lost else "invisible"
        entry = candidate.effect.size
        rivals = tuple((candidates[j].name, float(cosine[i, j]), float(apart[i, j])) for j in nearest)
        size = (entry.unit, entry.typical, float(sigmas[i]), float(smallest))
        shows = needed <= _SEEN * then[i] / SIZE_SPREAD and not seen[i]
        shown_by = (what[i], float(then[i] / SIZE_SPREAD)) if shows else ("", 0.0)
        answer.append(Sight(candidate.name, *size, kept, rivals, visible, needs, *shown_by))
    return tuple(answer)
