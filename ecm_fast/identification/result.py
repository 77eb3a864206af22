"""The result of a fit: values with intervals, the source of the noise, warnings."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..data.columns import channel_key
from ..errors import InputError, did_you_mean
from ..mechanism.mechanism import Mechanism
from .least_squares import NEAR, Loss, Minimum, Residuals, minimize

__all__ = ["Estimate", "Identification", "Objective", "Profile"]

Array = NDArray[np.float64]

_SEARCHES = 12  # fits for one end of a profile's interval, at most
_PLACES = 8
"""Decimals beyond which a number is written with its power of ten."""
_CLOSE = 1e-3  # of the root that a profile is searched for
_WIDER = 1.3
"""Reach of a profile's curve, in lengths of its interval."""


@dataclass(frozen=True)
class Estimate:
    """One parameter.

    Attributes
    ----------
    value : where the sum of squares is smallest
    std : standard deviation; inf where the data do not see the parameter, or too few tell their noise
    lower, upper : interval, `value` less and plus a quantile times `std`, cut at the parameter's bounds; of EA, GA and
        EI the same of 1/value, in which poses are nearly linear
    unit : of all four
    dof : degrees of freedom of the quantile, Student's t; inf (Gaussian) where the noise is declared
    """

    value: float
    std: float
    lower: float
    upper: float
    unit: str
    dof: float = math.inf

    @property
    def rounded(self) -> str:
        """Value and standard deviation with the unit, both to the second digit of the latter."""
        unit = "" if self.unit == "-" else f" {self.unit}"
        return f"{self._text(self.value)} +- {self._text(self.std)}{unit}"

    def _text(self, number: float) -> str:
        """Return a number with as many decimals as the standard deviation deserves."""
        places = 1 - math.floor(math.log10(self.std)) if 0.0 < self.std < math.inf else _PLACES + 1
        return f"{number:.{max(places, 0)}f}" if places <= _PLACES else f"{number:.6g}"

    def __repr__(self) -> str:
        return f"{self.rounded} ({self._text(self.lower)} to {self._text(self.upper)})"


@dataclass(frozen=True, eq=False)
class Profile:
    """Rise of the sum of squares when one parameter is held and the others adapt.

    Attributes
    ----------
    name : of the parameter
    values : (k,) at which it was held, rising
    rise : (k,) of the sum of squares above its minimum
    lower, upper : interval: where `rise` reaches `threshold`; the parameter's bound where it never does
    threshold : square of the quantile; more of it where the noise that weighs the readings is estimated
    level : the interval's probability
    """

    name: str
    values: Array = field(repr=False)
    rise: Array = field(repr=False)
    lower: float
    upper: float
    threshold: float
    level: float


@dataclass(frozen=True, eq=False)
class Objective:
    """The sum of squares that was minimized, kept for profiles."""

    residuals: Residuals
    lower: Array
    upper: Array
    loss: Loss
    plain: int

    def minimum(self, start: Array, near: float = NEAR) -> Minimum:
        """Return the minimum downhill from `start`, see `minimize`."""
        return minimize(self.residuals, start, self.lower, self.upper, self.loss, self.plain, near)

    def held(self, place: int, value: float, start: Array) -> Minimum:
        """Return the minimum over all parameters but one."""
        lower, upper = self.lower.copy(), self.upper.copy()
        lower[place] = upper[place] = value
        return replace(self, lower=lower, upper=upper).minimum(start)


@dataclass(frozen=True, eq=False, repr=False)
class Identification:
    """Parameters identified from measurements.

    Attributes
    ----------
    parameters : estimates by name
    covariance : (p, p), inf on the diagonal where the data do not see a parameter
    correlation : (p, p), nan where one of the two is not seen
    channels : what is read: x, z, theta of Q, then what the measurements name of markers and tendons
    residual : (n, c) measured less predicted [m, rad], the experiments one below the other
    used : (n, c) which of these entries the fit counted
    sigma : (n, c) standard deviation that each reading of the camera was given
    noise : by channel, where these come from: declared, replicates or residual
    left_out : place and reason of every row that holds a reading to fit but could not be used
    chi2, dof : weighted sum of squares without priors, and its degrees of freedom
    mechanisms : one an experiment, with the values found
    warnings : what to know before the numbers are used
    settled : whether the minimum was reached
    solves : how many equilibria it took
    level : probability of the intervals
    """

    parameters: Mapping[str, Estimate]
    covariance: Array
    correlation: Array
    channels: tuple[str, ...]
    residual: Array
    used: NDArray[np.bool_]
    sigma: Array
    noise: Mapping[str, str]
    left_out: tuple[tuple[str, str], ...]
    chi2: float
    dof: int
    mechanisms: tuple[Mechanism, ...]
    warnings: tuple[str, ...]
    settled: bool
    solves: int
    level: float
    _reach: Array
    _objective: Objective

    def __getitem__(self, name: str) -> Estimate:
        """Return the estimate of one parameter, named as it was asked for."""
        name = name if name in self.parameters else self.mechanism.key_of(name)
        if name not in self.parameters:
            raise InputError(f"{name!r} was not fitted{did_you_mean(str(name), self.parameters)}; these were: "
                             f"{', '.join(self.parameters)}")  # fmt: skip
        return self.parameters[name]

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism of the first experiment, with the values found."""
        return self.mechanisms[0]

    @property
    def values(self) -> Array:
        """The values in the order of the names, (p,)."""
        return np.array([estimate.value for estimate in self.parameters.values()])

    @property
    def rows(self) -> int:
        """Number of rows the fit counted."""
        return int(self.used.any(axis=1).sum())

    @property
    def counted(self) -> str:
        """Number of rows the fit counted, in words, and of how many where some are left out."""
        return f"{self.rows} of {self.rows + len(self.left_out)} rows" if self.left_out else f"{self.rows} rows"

    @cached_property
    def rms(self) -> dict[str, float | None]:
        """Root mean square of `residual` by channel, ``x_m``, ``z_m``, ``theta_rad``, fitted or not."""
        known = [column[np.isfinite(column)] for column in self.residual.T]
        return {
            channel_key(name): float(np.sqrt(np.mean(entries**2))) if entries.size else None
            for name, entries in zip(self.channels, known, strict=True)
        }

    def profile(self, name: str, points: int = 11) -> Profile:
        """Return the profile of one parameter: no parabola is assumed, only that the noise is what was taken.

        Parameters
        ----------
        name : as it was asked for
        points : of the curve, besides those that the interval's ends took

        Raises
        ------
        InputError : the parameter was not fitted, the data do not see it, or too few readings tell their noise.
        """
        estimate, place = self[name], list(self.parameters).index(name)
        if not np.isfinite(estimate.std):
            untold = np.isinf(self._reach[place])
            why = "too few readings tell their noise" if untold else "the data do not see it"
            raise InputError(f"{name} has no profile: {why}")
        best, target = self.values, float(self._reach[place])
        step = target * estimate.std
        floor = self._objective.held(place, estimate.value, best).total
        known = {estimate.value: (0.0, best)}

        def rise(value: float) -> float:
            if value not in known:
                nearest = min(known, key=lambda other: abs(other - value))
                minimum = self._objective.held(place, value, known[nearest][1])
                known[value] = max(minimum.total - floor, 0.0), minimum.values
            return known[value][0]

        ends = [
            _reach(rise, estimate.value, sign * step, float(bound), target)
            for sign, bound in ((-1.0, self._objective.lower[place]), (1.0, self._objective.upper[place]))
        ]
        wide = [estimate.value + _WIDER * (end - estimate.value) for end in ends]
        low, high = np.clip(wide, self._objective.lower[place], self._objective.upper[place])
        for value in sorted(np.linspace(low, high, points), key=lambda value: abs(value - estimate.value)):
            rise(float(value))
        values = sorted(known)
        rises = np.array([known[value][0] for value in values])
        return Profile(name, np.array(values), rises, ends[0], ends[1], target**2, self.level)

    def __repr__(self) -> str:
        noise = ", ".join(f"{name} {origin}" for name, origin in self.noise.items())
        lines = [f"<Identification from {self.counted}, {self.level:.0%} intervals; noise: {noise}"]
        lines += [f"  {name} {estimate}" for name, estimate in self.parameters.items()]
        rms = ", ".join(f"{name} {value:.3g}" for name, value in self.rms.items() if value is not None)
        lines += [f"  rms {rms}; chi2 {self.chi2:.4g} with {self.dof} degrees of freedom"]
        lines += [f"  left out: {where}: {reason}" for where, reason in self.left_out]
        return "\n".join(lines + [f"  warning: {text}" for text in self.warnings]) + ">"


def _reach(rise: Callable[[float], float], best: float, step: float, bound: float, target: float) -> float:
    """Return where the root of `rise` meets `target`, away from `best` in the direction of `step`.

    The root is close to a straight line through `best`, so each search goes where that line says.
    """
    beyond = abs(bound - best)
    inside, outside, size = 0.0, np.inf, abs(step)
    for _ in range(_SEARCHES):
        size = min(size, beyond)
        root = np.sqrt(rise(best + np.copysign(size, step)))
        if abs(root - target) <= _CLOSE * target:
            break
        if root < target:
            if size == beyond:
                return bound
            inside = size
        else:
            outside = size
        line = size * target / root if root > 0.1 * target else 4.0 * size
        size = line if inside < line < outside else 0.5 * (inside + min(outside, 4.0 * size))
    return float(best + np.copysign(size, step))
