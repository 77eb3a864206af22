"""Initial values of nonlinear parameters of an effect, such as the angle of a stop, by a scan of the data."""

import numpy as np
from numpy.typing import NDArray

from ..problem.linearization import Linearization
from ..statistics.evidence import EvidenceMatrix

__all__ = ["initial_values", "largest_evidence"]

Array = NDArray[np.float64]

_STEPS = (-2.0, -1.0, 1.0, 2.0)
"""Prior standard deviations from the usual value: beyond its corner a law shows a fit nothing of itself."""


def initial_values(view: Linearization, least: float = -np.inf) -> dict[str, float]:
    """Return the values, by key, that say more than the usual ones: of the first further parameter of every effect.

    least : evidence on top of the model that an effect must have to be worth it
    """
    return {key: value for key, (value, evidence) in _scanned(view).items() if evidence > least}


def largest_evidence(view: Linearization) -> float:
    """Return the largest evidence of an effect on top of the model, wherever its further parameter begins."""
    usual = float(view.rest[2].singles()[0].max(initial=0.0))
    return max([usual, *(evidence for _, evidence in _scanned(view).values())])


def _scanned(view: Linearization) -> dict[str, tuple[float, float]]:
    """Return the values, by key, that say more than the usual ones, each with the evidence there.

    Effects of the model keep what was fitted.
    """
    problem, (residual, free, gram) = view.problem, view.rest
    places = [i for i, candidate in enumerate(problem.candidates) if len(candidate.keys) > 1 and i not in view.model]
    if not places:
        return {}
    chosen = [problem.candidates[i] for i in places]
    keys = [key for candidate in chosen for key in candidate.keys[:2]]
    solver = problem.solver([*problem.keys_of(view.model), *keys], view.rows)
    column = {key: n for n, key in enumerate(solver.names)}
    at = np.array([view.values.get(key, float(value)) for key, value in
                   zip(solver.names, problem.start(solver.names), strict=True)])  # fmt: skip
    best, found = gram.singles()[0][places], dict[str, tuple[float, float]]()
    for step in _STEPS:
        tried = [float(np.clip(c.start[1] + step * c.spread[1], c.lower[1], c.upper[1])) for c in chosen]
        at[[column[c.keys[1]] for c in chosen]] = tried
        by = solver.at(at).by[:, :, [column[c.keys[0]] for c in chosen]]
        signatures = view.flat(view.whitening @ by * np.array([c.spread[0] for c in chosen]))
        below = np.zeros((len(residual) - len(signatures), len(places)))
        signatures, none = np.vstack([signatures, below]), np.zeros(len(places))
        evidence, _ = EvidenceMatrix.from_residual(residual, free, signatures, view.one_sided[places], none).singles()
        for n in np.flatnonzero(evidence > best):
            best[n] = evidence[n]
            found[chosen[n].keys[1]] = tried[n], float(evidence[n])
    return found
