"""Effects outside the catalogue, which a diagnosis must not give a wrong name.

Only the test bed has them, and no mechanism can. Each is one size, 0 when absent, and one law here.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError, did_you_mean, shown
from .variants import VARIANTS

__all__ = ["OUTSIDE", "Outside", "cells", "flexure", "friction", "lag", "memory", "named", "roll", "wall"]

Array = Any
Parameters = Mapping[str, Any]


class Outside(NamedTuple):
    """One effect outside the catalogue: its law in one line, the unit of its size, and the size one expects."""

    law: str
    unit: str
    typical: float


OUTSIDE: Mapping[str, Outside] = {
    "guide_friction": Outside("lam exp(-a theta^2 dir): the tendons rub more as the neck bends", "1/rad^2", 0.5),
    "slack": Outside("lam = r (1 - exp(-(r/a)^2)): a tendon below its pre-load does not pull", "N", 15.0),
    "thermal_cell": Outside("lam_l = r_l + a (1 - exp(-t/20 min)): the left force cell warms up", "N", 4.0),
    "wall": Outside("f_z - a (z - 12 mm) where z > 12 mm: the head touches a wall", "N/m", 2000.0),
    "plate_flexure": Outside("attachments at -a lam e_x^H: the plate bends under its tendons", "m/N", 5e-5),
    "out_of_plane_roll": Outside(
        "z cos r, tan(theta) cos r, r = a (lam_l + lam_r)/(320 N): the head rolls", "rad", 0.4
    ),
    "camera_lag": Outside("pose + (pose before - pose) exp(-dwell/a): the camera logs too late", "s", 6.0),
    "two_time_memory": Outside("M + a EI/L (theta - theta remembered), half of it for 5 s, half for 10 min", "-", 0.05),
}
"""Every effect outside the catalogue by its name."""

_KINDS = {"outside": OUTSIDE, "variant": VARIANTS}
WALL = 0.012
"""Place of the wall along z [m]."""
WARM_UP = 1.0 / 3.0
"""Time in which the left force cell warms up [h]."""
TIMES = (5.0, 600.0)
"""Time constants of the memory [s]."""
FULL_LOAD = 320.0
"""Sum of both tendon forces at which the roll is stated [N]."""


def named(sizes: Mapping[str, float]) -> dict[str, float]:
    """Return all sizes, and the shares of all variants, by their keys in the test bed.

    Raises
    ------
    InputError : no such effect, or its size is not a finite number.
    """
    for name, size in sizes.items():
        if name not in OUTSIDE and name not in VARIANTS:
            known = [*OUTSIDE, *VARIANTS]
            raise InputError(f"{name}: no effect of the test bed is called so{did_you_mean(name, known)}")
        if isinstance(size, bool) or not isinstance(size, (int, float)) or not np.isfinite(size):
            raise InputError(f"{name} = {shown(size)}: allowed is a finite number")
    return {f"{kind}.{name}": float(sizes.get(name, 0.0)) for kind, names in _KINDS.items() for name in names}


def cells(p: Parameters, lam: Array, hours: Array) -> Array:
    """Forces (2, n) behind the readings (2, n) of cells of which one warms up, at tendons that may be slack."""
    warmed = p["outside.thermal_cell"] * np.stack([1.0 - np.exp(-hours / WARM_UP), 0.0 * hours])
    if (size := p["outside.slack"]) == 0.0:
        return lam + warmed
    return lam * (1.0 - np.exp(-((lam / size) ** 2))) + warmed


def friction(p: Parameters, theta: Array, pulled: Array) -> Array:
    """Factor of the tendon forces, (2, n), from the angle of the head (n,) and the tendons' travel (2, n)."""
    return np.exp(-p["outside.guide_friction"] * theta**2 * pulled)


def flexure(p: Parameters, lam: Array) -> Array:
    """Height above Q at which a tendon is attached, for its force [m]."""
    return -p["outside.plate_flexure"] * lam


def wall(p: Parameters, z: Array) -> Array:
    """Force of the wall along z [N]."""
    return np.where(z.real > WALL, -p["outside.wall"] * (z - WALL), 0.0)


def memory(p: Parameters, gaps: tuple[Array, Array]) -> Array:
    """Addition to theta - theta remembered [rad], from the gaps (n,) of both time constants."""
    return p["outside.two_time_memory"] * 0.5 * (gaps[0] + gaps[1])


def roll(p: Parameters, pose: Array, load: Array) -> Array:
    """Pose (3, n) as seen from the front when the head rolls; `load` (n,) is the sum of both forces."""
    if p["outside.out_of_plane_roll"] == 0.0:
        return pose
    c = np.cos(p["outside.out_of_plane_roll"] * load / FULL_LOAD)
    return np.stack([pose[0], pose[1] * c, np.arctan(np.tan(pose[2]) * c)])


def lag(p: Parameters, pose: Array, dwell: Array) -> Array:
    """Pose (3, n) that the camera logs with each force; dwell (n,) [s]."""
    if p["outside.camera_lag"] <= 0.0:
        return pose
    before = np.concatenate([pose[:, :1], pose[:, :-1]], axis=1)
    return pose + (before - pose) * np.exp(-dwell / p["outside.camera_lag"])
