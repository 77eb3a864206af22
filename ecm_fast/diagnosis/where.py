"""Where the calibrated model disagrees: which part, which channel, which loads; and the wrench that would close it."""

import numpy as np
from numpy.typing import NDArray

from ..identification_rows import State
from ..loads import MIN_TOLERANCE, QUADRATIC
from ..readings import MeasuringChain
from .problem import Problem
from .result import Where
from .view import View

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


def where(view: View) -> Where:
    """Return where the calibrated model, without any effect, disagrees."""
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
    return Where(
        components=dict(sorted(parts.items(), key=lambda entry: -entry[1])),
        channels=dict(zip(("x", "z", "theta"), shares.tolist(), strict=True)),
        mirror=dict(sorted(mirror.items(), key=lambda entry: -entry[1])),
        region=_region(view),
    )


_LOCAL = 0.9
_QUANTILES = (0.1, 0.25, 0.5)


def _region(view: View) -> str:
    """Return the smallest half space of loads that holds the disagreement, empty where none does."""
    data = view.problem.data
    lam = np.concatenate([part.lam for part in data])[view.rows]
    excess = (view.raw**2 - view.used).sum(axis=1)
    total = float(excess.sum())
    if total < 10.0 * np.sqrt(2.0 * view.used.sum()):
        return ""
    coordinates = {
        "lam_l + lam_r": lam.sum(axis=1),
        "lam_l - lam_r": lam[:, 0] - lam[:, 1],
        "|lam_l - lam_r|": np.abs(lam[:, 0] - lam[:, 1]),
    }
    for share in _QUANTILES:
        for name, values in coordinates.items():
            for sign, word in ((1.0, ">"), (-1.0, "<")):
                if name.startswith("|") and sign < 0.0:
                    continue
                level = float(np.quantile(sign * values, 1.0 - share))
                inside = sign * values >= level
                if float(excess[inside].sum()) > _LOCAL * total and inside.mean() < share + 0.1:
                    return f"{name} {word} {sign * level:.3g} N"
    return ""
