"""Caveats of an answer: doubtful stiffnesses, an untested second name, unusual sizes."""

from collections.abc import Container, Iterator, Mapping, Sequence

import numpy as np

from ...identification.result import Estimate
from ...mechanism.mechanism import Mechanism
from ...mechanism.parameters import find
from ...mechanism.quantity import Quantity
from ...mechanism.sections import STIFFNESSES
from ..problem.candidates import EffectCandidate
from ..problem.stiffness_scale import STIFFNESS_KEYS
from ..search.fit import Fit
from ..search.result import Selection

__all__ = ["alarms", "correlation_caveats", "mesh_caveats", "stiffness_caveats"]

_LOOSE = 0.15
"""Standard deviation, in shares of the value, beyond which a stiffness is hardly fixed."""
_FAR, _MUCH = 5.0, 0.2
"""Standard deviations, and shares of the value, by which a stiffness may leave the mechanism file: two batches of one
rubber differ by a tenth, and calibration is there to find by how much."""
_TOGETHER = 0.95
"""Correlation from which on data see a combination of two parameters of an effect rather than each."""
_ALARM = 3.0  # standard deviations: one alarm in 370 by chance
_SHARE = (0.2, 0.45)
"""Range of the shear over the axial stiffness of an incompressible solid section, (5/6 or 1)/3 with some room."""


def mesh_caveats(unresolved: int) -> tuple[str, ...]:
    """Return a line where the discretization of some rows is not fine enough for their noise.

    unresolved : how many rows, see `rows.common_mesh`
    """
    if not unresolved:
        return ()
    return (f"the discretization error of {unresolved} rows exceeds a tenth of their noise: what is named may be that",)


def correlation_caveats(fit: Fit, candidates: Sequence[EffectCandidate]) -> tuple[str, ...]:
    """Return a line for every effect whose size and further parameter the data do not see apart."""
    lines, std = list[str](), np.sqrt(np.diag(fit.covariance))
    for i in fit.model:
        places = [fit.keys.index(key) for key in candidates[i].keys]
        size = places[0]
        for other in places[1:]:
            correlation = float(fit.covariance[size, other] / (std[size] * std[other]))
            if abs(correlation) > _TOGETHER:
                one, two = (find(fit.keys[at]).name for at in (size, other))
                lines.append(f"{one} and {two} trade off in these data (correlation {correlation:.2f}): what both do "
                             "together is known far better than each alone")  # fmt: skip
    return tuple(lines)


def stiffness_caveats(
    calibration: Mapping[str, Estimate], mechanism: Mechanism, tested: Container[str] = ()
) -> tuple[str, ...]:
    """Return a line for every stiffness of the mechanism that a calibration leaves in doubt.

    tested : those of which material tests say what takes the place of the mechanism file's value
    """
    return tuple(_doubts(calibration, mechanism, tested))


def _doubts(calibration: Mapping[str, Estimate], mechanism: Mechanism, tested: Container[str]) -> Iterator[str]:
    for name in STIFFNESSES:
        found, stated = calibration[name], float(getattr(mechanism.beam, name))
        off, share = found.value - stated, found.std / found.value
        value = f"{stated:.4g} {found.unit}"
        if share > _LOOSE:
            yield (f"these loads fix {name} to no better than {share:.0%}: {found.rounded}, where the mechanism file "
                   f"has {value}; give what a material test says (--prior {name} VALUE STD), or measure side forces or "
                   f"other loads")  # fmt: skip
        elif name not in tested and abs(off) > max(_FAR * found.std, _MUCH * stated):
            yield (f"calibration moves {name} to {found.rounded}, {abs(off) / found.std:.0f} standard deviations "
                   f"({off / stated:+.0%}) from the {value} of the mechanism file, more than batches of a material "
                   f"differ: is it of this neck, and its dimensions too?")  # fmt: skip


def alarms(selection: Selection) -> tuple[str, ...]:
    """Return one line for every parameter that leaves its range in the calibration without effects."""
    return (*_priors(selection), *_range(selection))


def _priors(selection: Selection) -> Iterator[str]:
    fit, problem = selection.null, selection.view.problem
    information = np.linalg.pinv(fit.covariance, hermitian=True)
    for i in problem.prior.known[~problem.prior.rough[problem.prior.known]]:
        center, std = problem.prior.center[i], problem.prior.std[i]
        free = information.copy()
        free[i, i] -= std**-2
        with np.errstate(all="ignore"):
            covariance = np.linalg.pinv(free, hermitian=True)
            offset = (fit.values[i] - center) * (1.0 + covariance[i, i] / std**2)
            off = offset / np.sqrt(covariance[i, i] + std**2)
        if abs(off) > _ALARM:
            yield _away(find(problem.keys[i]), center, std, center + offset, float(np.sqrt(covariance[i, i])), abs(off))


def _away(entry: Quantity, center: float, std: float, wanted: float, doubt: float, off: float) -> str:
    prior, fitted = (Estimate(value, sd, value, value, entry.unit) for value, sd in ((center, std), (wanted, doubt)))
    known = f"{off:.1f} standard deviations, of fit and test together, from {prior.rounded}"
    least = max(entry.lower, 0.0)
    if wanted <= least and entry.key in STIFFNESS_KEYS:
        return f"without any effect no physical {entry.name} fits the data: they want it to be none, {known}"
    return f"without any effect the data want {entry.name} = {fitted.rounded}, {known}"


def _range(selection: Selection) -> Iterator[str]:
    fit = selection.best
    place = {key: i for i, key in enumerate(fit.keys)}
    ea, ga = place[STIFFNESS_KEYS[0]], place[STIFFNESS_KEYS[1]]
    share = fit.values[ga] / fit.values[ea]
    relative = np.sqrt(fit.covariance[ea, ea]) / fit.values[ea] + np.sqrt(fit.covariance[ga, ga]) / fit.values[ga]
    low, high = _SHARE
    if not low - _ALARM * share * relative <= share <= high + _ALARM * share * relative:
        yield (f"GA/EA = {share:.3g} is outside of {low:g} to {high:g}, where a solid section of rubber lies: the "
               f"calibration makes up for something that is missing")  # fmt: skip
