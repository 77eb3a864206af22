"""Where an effect's further parameter, such as the angle of a stop, begins: where the data first say that it is."""

import numpy as np
from numpy.typing import NDArray

from .linear import Gram
from .view import View

__all__ = ["starts"]

Array = NDArray[np.float64]

_STEPS = (-2.0, -1.0, 1.0, 2.0)
"""Prior standard deviations from the usual value: beyond its corner a law shows a fit nothing of itself."""


def starts(view: View) -> dict[str, float]:
    """Return the values, by key, that say more than the usual ones: of the first further parameter of every effect."""
    problem = view.problem
    places = [i for i, candidate in enumerate(problem.candidates) if len(candidate.keys) > 1]
    if not places:
        return {}
    chosen = [problem.candidates[i] for i in places]
    solver = problem.solver([key for candidate in chosen for key in candidate.keys[:2]], view.rows)
    column = {key: n for n, key in enumerate(solver.names)}
    at = np.array([view.values.get(key, float(own)) for key, own in
                   zip(solver.names, problem.start(solver.names), strict=True)])  # fmt: skip
    best, found = view.gram.singles()[0][places], dict[str, float]()
    for step in _STEPS:
        tried = [float(np.clip(c.start[1] + step * c.spread[1], c.lower[1], c.upper[1])) for c in chosen]
        at[[column[c.keys[1]] for c in chosen]] = tried
        by = solver.at(at).by[:, :, [column[c.keys[0]] for c in chosen]]
        signatures = view.flat(view.whitening @ by * np.array([c.spread[0] for c in chosen]))
        evidence, _ = _gram(view, signatures, places).singles()
        for n in np.flatnonzero(evidence > best):
            found[chosen[n].keys[1]], best[n] = tried[n], evidence[n]
    return found


def _gram(view: View, signatures: Array, places: list[int]) -> Gram:
    below = np.zeros((len(view.residual) - len(signatures), len(places)))
    return Gram.of(view.residual, view.free, np.vstack([signatures, below]), view.one_sided[places],
                   np.zeros(len(places)))  # fmt: skip
