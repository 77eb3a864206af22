"""Where the calibrated model disagrees: which part, which channel, which loads; and the wrench that would close it."""

import numpy as np
from numpy.typing import NDArray

from ...identification.rows import State
from ...models.instruments.measuring_chain import MeasuringChain
from ...models.loads import MIN_TOLERANCE, QUADRATIC
from ..problem.linearization import View
from ..problem.problem import Problem
from ..results.diagnosis import Where
from .region import scan

__all__ = ["compliances", "where", "wrenches"]

Array = NDArray[np.float64]


def compliances(problem: Problem, state: State) -> Array:
    """Return the pose's derivatives by the wrench at Q, (n, 3, 3), at the state's calibrated parameters."""
    parts = []
    for entry in problem.sets:
        par = problem.par.copy()
        par[problem.rows.places] = state.values[: len(problem.keys)]
        found = MeasuringChain(problem.mesh, entry.data).sensitivities((), par, MIN_TOLERANCE / QUADRATIC)
        parts.append(found.compliance)
    return np.concatenate(parts)


def wrenches(residual: Array, compliance: Array) -> Array:
    """Return the wrench at Q that moves the tip by residuals (n, 3), nan where these are not whole."""
    good = np.isfinite(residual).all(axis=1) & np.isfinite(compliance).all(axis=(1, 2))
    out = np.full_like(residual, np.nan)
    out[good] = np.linalg.solve(compliance[good], residual[good][:, :, None])[:, :, 0]
    return out


def where(view: View, seed: int) -> Where:
    """Return where the calibrated model, without any effect, disagrees; `seed` is of the scan's draws."""
    gram, candidates = view.gram, view.problem.candidates
    taken = gram.scores() ** 2
    most = max(float(taken.max(initial=0.0)), 1e-300)
    parts: dict[str, float] = {}
    mirror: dict[str, float] = {}
    for candidate, value in zip(candidates, taken.tolist(), strict=True):
        for table, name in ((parts, candidate.effect.enters), (mirror, candidate.effect.mirror)):
            table[name] = max(table.get(name, 0.0), value / most)
    excess = np.maximum((view.raw**2).sum(axis=0) - view.used.sum(axis=0), 0.0)
    shares = excess / max(float(excess.sum()), 1e-300)
    lam = np.concatenate([part.lam for part in view.problem.data])[view.rows]
    region, chance = scan(lam, (view.raw**2).sum(axis=1), view.used.sum(axis=1).astype(np.float64), seed)
    return Where(
        components=dict(sorted(parts.items(), key=lambda entry: -entry[1])),
        channels=dict(zip(("x", "z", "theta"), shares.tolist(), strict=True)),
        mirror=dict(sorted(mirror.items(), key=lambda entry: -entry[1])),
        region=region,
        chance=chance,
    )
