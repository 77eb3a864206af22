"""The instruments of the test bed: a camera and two force cells with their errors."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data.columns import COLUMNS
from ..data.measurements import Measurements
from ..errors import InputError, shown
from ..mechanism.mechanism import Mechanism
from .camera import seen
from .equilibria import Equilibria, equilibria
from .laws import named

__all__ = ["Sensors", "measure", "readings"]

Array = NDArray[np.float64]
Seed = int | np.random.Generator


@dataclass(frozen=True)
class Sensors:
    """The instruments' errors; without arguments white camera noise alone.

    Attributes
    ----------
    camera_sigma : noise of x, z, theta, one standard deviation [m, m, rad]
    camera_offset : added to x, z, theta [m, m, rad]
    camera_rotation : the camera's frame is turned about the clamp by this angle, positive like theta [rad]
    camera_scale : seen length over true length [-]
    camera_resolution : step of the readings of x, z, theta, 0 for none [m, m, rad]
    camera_drift : added little by little, the whole of it at the last reading [m, m, rad]
    force_sigma : noise of both force readings [N]; the neck always feels the true force
    force_gain, force_zero : reading = gain * force + zero, left and right [-, N]
    force_resolution : step of the force readings, 0 for none [N]
    force_drift : added little by little to the readings, left and right [N]
    tail_dof : degrees of freedom, above 2, of Student's t for all noise, scaled to the sigma given; inf is Gaussian
    correlation : of the camera noise of neighboring rows, an AR(1) process of the same sigma [-]
    outlier_share : share of rows in which the camera is off by `outlier_size` sigma, up or down, in every channel
    outlier_size : [-]
    declared : whether the measurements say the sigmas
    """

    camera_sigma: tuple[float, float, float] = (1e-4, 1e-4, 1e-3)
    camera_offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    camera_rotation: float = 0.0
    camera_scale: float = 1.0
    camera_resolution: tuple[float, float, float] = (0.0, 0.0, 0.0)
    camera_drift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    force_sigma: float = 0.0
    force_gain: tuple[float, float] = (1.0, 1.0)
    force_zero: tuple[float, float] = (0.0, 0.0)
    force_resolution: float = 0.0
    force_drift: tuple[float, float] = (0.0, 0.0)
    tail_dof: float = math.inf
    correlation: float = 0.0
    outlier_share: float = 0.0
    outlier_size: float = 10.0
    declared: bool = True

    def __post_init__(self) -> None:
        for entry in fields(self):
            if entry.name == "declared":
                continue
            value = getattr(self, entry.name)
            numbers = value if isinstance(value, (tuple, list)) else (value,)
            lower, upper, words = _ALLOWED.get(entry.name, (-math.inf, math.inf, "a finite number"))
            count = np.size(getattr(type(self), entry.name))
            good = len(numbers) == count and all(_is_number(entry.name, number) for number in numbers)
            if not good or not all(lower <= number <= upper for number in numbers):
                raise InputError(f"{entry.name} = {shown(value)}: allowed is {words}{f', {count} times' * (count > 1)}")

    @classmethod
    def perfect(cls) -> "Sensors":
        """Return instruments that read the truth."""
        return cls(camera_sigma=(0.0, 0.0, 0.0))


_SIZE = (0.0, math.inf, "a finite number >= 0")
_ALLOWED = {
    "camera_sigma": _SIZE,
    "camera_resolution": _SIZE,
    "camera_scale": (1e-9, math.inf, "a finite number > 0"),
    "force_sigma": _SIZE,
    "force_resolution": _SIZE,
    "tail_dof": (math.nextafter(2.0, 3.0), math.inf, "a number > 2, inf for Gaussian noise"),
    "correlation": (-1.0, 1.0, "a number from -1 to 1"),
    "outlier_share": (0.0, 1.0, "a number from 0 to 1"),
    "outlier_size": _SIZE,
}


def _is_number(name: str, value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return math.isfinite(value) or (name == "tail_dof" and value == math.inf)


def measure(
    mechanism: Mechanism,
    loads: Measurements,
    sensors: Sensors | None = None,
    seed: Seed = 0,
    *,
    hidden: Mapping[str, float] | None = None,
) -> Measurements:
    """Load the neck row by row and read the instruments.

    Parameters
    ----------
    mechanism : what is built; its effects are what there is to find
    loads : the loads of every row as ideal cells read them, in the order of measurement; its poses are not read
    sensors : the instruments; default white camera noise
    seed : of all random numbers
    hidden : sizes of effects of `OUTSIDE`

    Raises
    ------
    InputError : a row has no stable equilibrium (names the row and how much of its load was reached), or the
        mechanism has an effect that the test bed has no law for.
    """
    found = equilibria(mechanism, loads, hidden=hidden).raise_if_failed()
    return readings(mechanism, found, sensors, seed, hidden=hidden)


def readings(
    mechanism: Mechanism,
    equilibria: Equilibria,
    sensors: Sensors | None = None,
    seed: Seed = 0,
    *,
    hidden: Mapping[str, float] | None = None,
) -> Measurements:
    """Read the instruments once more at equilibria that are known; where there is none, the pose is blank.

    Each instrument and each kind of error has its own stream of random numbers: to switch one on leaves the rest.
    """
    use, loads = sensors or Sensors(), equilibria.loads
    streams = dict(zip(("camera", "force", "outlier"), np.random.default_rng(seed).spawn(3), strict=True))
    lam = _force_cells(use, loads.lam, _elapsed(loads), streams["force"])
    picture = seen(named(mechanism, hidden), equilibria.pose, loads)
    pose = _camera(use, picture, _elapsed(loads), streams["camera"], streams["outlier"])
    known = (*use.camera_sigma, use.force_sigma)
    sigmas: dict[str, Any] = {
        name: np.full(loads.n, sigma if use.declared and sigma > 0.0 else math.nan)
        for name, sigma in zip(("sigma_x", "sigma_z", "sigma_theta", "sigma_lam"), known, strict=True)
    }
    read: dict[str, Any] = dict(
        zip(("lam_l", "lam_r", "x", "z", "theta"), [*lam.T.copy(), *pose.T.copy()], strict=True)
    )
    read |= sigmas
    names = dict.fromkeys([*loads.columns, *(COLUMNS[name].names[0] for name in read)])
    return replace(loads, **read, columns=tuple(names), source=f"simulated {loads.source}")


def _elapsed(loads: Measurements) -> Array:
    """Time since the first reading as a share of the whole, (n,); by rows where times are not given."""
    t = loads.t if np.isfinite(loads.t).all() and np.ptp(loads.t) > 0.0 else np.arange(float(loads.n))
    elapsed: Array = (t - t.min()) / max(float(np.ptp(t)), 1e-300)
    return elapsed


def _force_cells(use: Sensors, lam: Array, elapsed: Array, rng: np.random.Generator) -> Array:
    """Readings (n, 2) of the true forces (n, 2); a cell shows no force below zero."""
    noise = use.force_sigma * _white(use, lam.shape, rng)
    read = lam * use.force_gain + use.force_zero + elapsed[:, None] * use.force_drift + noise
    return _rounded(np.maximum(read, 0.0), use.force_resolution)


def _camera(use: Sensors, pose: Array, elapsed: Array, rng: np.random.Generator, stray: np.random.Generator) -> Array:
    """Readings (n, 3) of what the camera sees, (n, 3)."""
    c, s = math.cos(use.camera_rotation), math.sin(use.camera_rotation)
    x, z, theta = pose.T
    turned = [use.camera_scale * (c * x + s * z), use.camera_scale * (c * z - s * x), theta + use.camera_rotation]
    seen = np.column_stack(turned) + use.camera_offset + elapsed[:, None] * use.camera_drift
    noise = _neighboring(use, _white(use, pose.shape, rng))
    outliers = stray.random(len(pose)) < use.outlier_share
    noise += outliers[:, None] * use.outlier_size * stray.choice([-1.0, 1.0], pose.shape)
    seen += noise * use.camera_sigma
    return np.column_stack([_rounded(*column) for column in zip(seen.T, use.camera_resolution, strict=True)])


def _white(use: Sensors, shape: tuple[int, ...], rng: np.random.Generator) -> Array:
    """Independent noise of unit variance."""
    if math.isinf(use.tail_dof):
        return rng.standard_normal(shape)
    return rng.standard_t(use.tail_dof, shape) * math.sqrt((use.tail_dof - 2.0) / use.tail_dof)


def _neighboring(use: Sensors, white: Array) -> Array:
    """Noise of unit variance, correlated from row to row."""
    noise = white.copy()
    for before, current, new in zip(noise[:-1], noise[1:], white[1:], strict=True):
        current[:] = use.correlation * before + math.sqrt(1.0 - use.correlation**2) * new
    return noise


def _rounded(values: Array, resolution: float) -> Array:
    """Return multiples of a resolution; of a decimal one they are the doubles nearest the decimal numbers."""
    if resolution == 0.0:
        return values
    per_unit = round(1.0 / resolution)
    if per_unit and math.isclose(per_unit * resolution, 1.0, rel_tol=1e-12):
        return np.round(values * per_unit) / per_unit
    return np.round(values / resolution) * resolution
