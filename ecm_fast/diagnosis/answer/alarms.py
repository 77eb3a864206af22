"""Parameters that calibration drives to where the material tests, or the material, do not allow them."""

from collections.abc import Iterator

import numpy as np

from ...identification.result import Estimate
from ...mechanism.parameters import find
from ...mechanism.quantity import Quantity
from ..problem.stiffness_scale import STIFFNESSES
from ..search.selection import Found

__all__ = ["alarms"]

_FAR = 3.0
_SHARE = (0.2, 0.45)
"""Where the shear over the axial stiffness of an incompressible solid section lies, (5/6 or 1)/3 with some room."""


def alarms(found: Found) -> tuple[str, ...]:
    """Return one line for every parameter that leaves its range in the calibration without effects."""
    return (*_priors(found), *_range(found))


def _priors(found: Found) -> Iterator[str]:
    fit, problem = found.null, found.view.problem
    information = np.linalg.pinv(fit.covariance, hermitian=True)
    for i in problem.prior.known[~problem.prior.rough[problem.prior.known]]:
        center, std = problem.prior.center[i], problem.prior.std[i]
        free = information.copy()
        free[i, i] -= std**-2
        with np.errstate(all="ignore"):
            own = np.linalg.pinv(free, hermitian=True)
            offset = (fit.values[i] - center) * (1.0 + own[i, i] / std**2)
            off = offset / np.sqrt(own[i, i] + std**2)
        if abs(off) > _FAR:
            yield _away(find(problem.keys[i]), center, std, center + offset, float(np.sqrt(own[i, i])), abs(off))


def _away(entry: Quantity, center: float, std: float, wanted: float, doubt: float, off: float) -> str:
    prior, own = (Estimate(value, sd, value, value, entry.unit) for value, sd in ((center, std), (wanted, doubt)))
    known = f"{off:.1f} standard deviations, of fit and test together, from {prior.rounded}"
    least = max(entry.lower, 0.0)
    if wanted <= least and entry.key in STIFFNESSES:
        return f"without any effect no physical {entry.name} fits the data: they want it to be none, {known}"
    return f"without any effect the data want {entry.name} = {own.rounded}, {known}"


def _range(found: Found) -> Iterator[str]:
    fit = found.best
    place = {key: i for i, key in enumerate(fit.keys)}
    ea, ga = place[STIFFNESSES[0]], place[STIFFNESSES[1]]
    share = fit.values[ga] / fit.values[ea]
    relative = np.sqrt(fit.covariance[ea, ea]) / fit.values[ea] + np.sqrt(fit.covariance[ga, ga]) / fit.values[ga]
    low, high = _SHARE
    if not low - _FAR * share * relative <= share <= high + _FAR * share * relative:
        yield (f"GA/EA = {share:.3g} is outside of {low:g} to {high:g}, where a solid section of rubber lies: the "
               f"calibration makes up for something that is missing")  # fmt: skip
