"""Warnings of a fit, each with its number."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..data.columns import channel_key, usual_sigma
from .noise import RESIDUAL
from .result import Identification

__all__ = ["in_words"]

Array = NDArray[np.float64]

_UNSEEN = 1.0  # standard deviation of a combination, in units of the parameters' own size
_PART = 0.1  # smallest part of a combination that is worth naming
# correlation, standard deviations from a prior, and chance of a misfit from which on a user should know
_CORRELATED, _DRIFTED, _IMPLAUSIBLE = 0.99, 3.0, 1e-3
_NEAR_BOUND = 1e-9  # relative: rounding of a value that was clipped to its bound
_FEW_ROWS, _FAR, _LARGE = 3, 10.0, 0.1  # rms over that of a camera, and over what the readings vary by
_FEW_DOF = 5.0  # where Student's t makes a 90 % interval a quarter wider than known noise does


def in_words(
    fit: Identification, prior: Array, seen: tuple[Array, Array], measured: Array, *, known: bool
) -> Identification:
    """Return the fit with its warnings.

    Parameters
    ----------
    fit : as found
    prior : (k, 3) place, value and standard deviation
    seen : singular values and directions of what the data see, priors left out, see `least_squares.visible`
    measured : (n, c) the readings [m, rad]
    known : whether the noise is known from elsewhere than the residual
    """
    texts = [
        *_left_out(fit),
        *_untold(fit, known),
        *_unseen(fit, prior, seen),
        *_bounds(fit),
        *_drift(fit, prior),
        *_correlated(fit),
        *_misfit(fit, known),
        *_far_off(fit, measured, known),
    ]
    if not fit.settled:
        texts.append("the fit stopped before it settled: better start values or a prior may help")
    return replace(fit, warnings=tuple(texts))


def _left_out(fit: Identification) -> Iterator[str]:
    if not fit.left_out:
        return
    where, reason = fit.left_out[0]
    count, all_rows = len(fit.left_out), len(fit.left_out) + fit.rows
    yield (f"{count} of {all_rows} rows are left out, because the fitted mechanism has no stable equilibrium there; "
           f"the result speaks for the others alone; {where}: {reason}")  # fmt: skip


def _untold(fit: Identification, known: bool) -> Iterator[str]:
    if known:
        return
    cure = "declare it, in columns such as sigma_x_mm, by --noise or with_noise"
    channels = ", ".join(name for name, origin in fit.noise.items() if RESIDUAL in origin)
    untold = [name for name, reach in zip(fit.parameters, fit._reach, strict=True) if np.isinf(reach)]
    if untold:
        yield (f"no interval for {', '.join(untold)}: the noise of {channels} is not declared, and {fit.rows} rows "
               f"with {max(fit.dof, 0)} readings more than parameters are too few to tell it; {cure}")  # fmt: skip
    seen = {name: found.dof for name, found in fit.parameters.items() if np.isfinite(found.std)}
    if seen and min(seen.values()) < _FEW_DOF:
        name = min(seen, key=lambda name: seen[name])
        yield (f"the noise of {channels} is not declared and only {fit.rows} rows tell it: intervals are as wide as "
               f"Student's t makes them, with {seen[name]:.2g} degrees of freedom for {name}, and take its channels to "
               f"be about as noisy as a camera's; to know more, {cure}")  # fmt: skip


def _unseen(fit: Identification, prior: Array, seen: tuple[Array, Array]) -> Iterator[str]:
    names, (singular, directions) = list(fit.parameters), seen
    held = {int(place) for place in prior[:, 0]}
    for value, direction in zip(singular, directions, strict=True):
        if value * _UNSEEN >= 1.0 and value > 1e-7 * singular[0]:
            continue
        parts = [i for i in np.argsort(-np.abs(direction)) if abs(direction[i]) > _PART]
        ratio = f"relative singular value {value / max(float(singular[0]), 1e-300):.1g}"
        rest = "; the prior alone sets it" if held & set(parts) else "; it keeps its start value or strays"
        if len(parts) == 1:
            yield f"{names[parts[0]]} cannot be seen in the data ({ratio}){rest}"
            continue
        direction = direction * np.sign(direction[parts[0]])
        words = " ".join(f"{direction[i]:+.2f} {names[i]}" for i in parts)
        yield f"the combination {words}, each in units of its own size, cannot be seen in the data ({ratio}){rest}"


def _bounds(fit: Identification) -> Iterator[str]:
    for place, (name, estimate) in enumerate(fit.parameters.items()):
        for bound in (fit._objective.lower[place], fit._objective.upper[place]):
            if abs(estimate.value - bound) <= _NEAR_BOUND * max(abs(bound), 1e-3):
                yield f"{name} = {estimate.value:g} sits on its bound {bound:g} {estimate.unit}: it wants to go beyond"


def _drift(fit: Identification, prior: Array) -> Iterator[str]:
    names = list(fit.parameters)
    for place, center, spread in prior:
        name = names[int(place)]
        off = (fit[name].value - center) / spread
        if abs(off) > _DRIFTED:
            yield (f"{name} = {fit[name].value:.6g} drifts {off:+.1f} standard deviations away from its prior, "
                   f"{center:g} +- {spread:g} {fit[name].unit}")  # fmt: skip


def _correlated(fit: Identification) -> Iterator[str]:
    names = list(fit.parameters)
    for i, j in zip(*np.triu_indices(len(names), 1), strict=True):
        if abs(fit.correlation[i, j]) > _CORRELATED:
            size = f"{fit.correlation[i, j]:+.4f}"
            yield f"{names[i]} and {names[j]} are correlated by {size}: the data tell one from the other, not both"


def far_off(fit: Identification, measured: Array) -> dict[str, tuple[float, float]]:
    """Return by channel rms and share of the readings' spread that a fit leaves, where both are large."""
    found = {}
    for i, (name, sigma) in enumerate(zip(fit.channels, usual_sigma(fit.channels), strict=True)):
        used = fit.used[:, i]
        if int(used.sum()) < _FEW_ROWS:
            continue
        rms = float(np.sqrt(np.mean(fit.residual[used, i] ** 2)))
        spread = float(np.std(measured[used, i]))
        if rms > _FAR * sigma and rms > _LARGE * spread:
            found[name] = rms, rms / max(spread, 1e-300)
    return found


def _far_off(fit: Identification, measured: Array, known: bool) -> Iterator[str]:
    if known:
        return
    for name, (rms, share) in far_off(fit, measured).items():
        unit = channel_key(name).rpartition("_")[2]
        yield (f"the fit leaves {rms:.3g} {unit} of {name}, {share:.0%} of what it varies by: something is missing in "
               f"the model, or another start finds a better minimum")  # fmt: skip


def _misfit(fit: Identification, known: bool) -> Iterator[str]:
    if not known or fit.dof < 1 or fit._objective.loss.name != "linear":
        return
    from scipy.special import chdtrc

    chance = float(chdtrc(fit.dof, fit.chi2))
    if chance < _IMPLAUSIBLE:
        yield (f"the residual is {np.sqrt(fit.chi2 / fit.dof):.2f} times the noise (chi2 {fit.chi2:.4g} with {fit.dof} "
               f"degrees of freedom): something is missing in the model, and the intervals are too narrow")  # fmt: skip
