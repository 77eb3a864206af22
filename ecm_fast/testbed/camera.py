"""A noise-free camera: marker position, picture and camera frame."""

from typing import Any

import numpy as np

from ..data.measurements import Measurements
from . import outside
from .history import drifted, hours
from .laws import Parameters, length
from .variants import LENS, blend, used

__all__ = ["seen"]

Array = Any


def seen(p: Parameters, pose: Array, loads: Measurements) -> Array:
    """Return the poses (n, 3) that the camera sees of the plate's poses (n, 3), rows in the order of measurement."""
    dwell = np.where(np.isfinite(loads.dwell), loads.dwell, 0.0)
    x, z, theta = outside.roll(p, outside.lag(p, pose.T, dwell), loads.lam.sum(axis=1))
    x, z, theta = _shown(p, x, z, theta)
    if used(p, "zeroed_at_rest"):
        rest = _shown(p, length(p), 0.0, 0.0)
        x, z, theta = x - rest[0] + length(p), z - rest[1], theta - rest[2]
    t = drifted(p, hours(loads))
    x = x + p["effects.camera_x_offset"] + p["effects.camera_drift_x"] * t
    z = z + p["effects.camera_z_offset"] + p["effects.camera_drift_z"] * t
    return np.column_stack([x, z, theta + p["effects.marker_angle_offset"]])


def _shown(p: Parameters, x: Array, z: Array, theta: Array) -> tuple[Array, Array, Array]:
    """Place and angle in the camera's frame, wherever its origin is."""
    x, z = _marker(p, x, z, theta)
    x, z = _picture(p, x, z)
    a = p["effects.camera_rotation"]
    c, s, center = np.cos(a), np.sin(a), blend(p, "turned_about_marker", 0.0, length(p))
    return center + (x - center) * c + z * s, z * c - (x - center) * s, theta + a


def _marker(p: Parameters, x: Array, z: Array, theta: Array) -> tuple[Array, Array]:
    """Place of a marker that does not sit on Q."""
    above, beside, c, s = p["effects.marker_lever_x"], p["effects.marker_lever_z"], np.cos(theta), np.sin(theta)
    return x + above * c + beside * s, z - above * s + beside * c


def _picture(p: Parameters, x: Array, z: Array) -> tuple[Array, Array]:
    """Distortions one after the other: the lens, the view askew, the scales."""
    at_x, at_z = (blend(p, "lens_beside", 0.0, place) for place in LENS)
    lens = 1.0 + p["effects.lens_distortion"] * ((x - at_x) ** 2 + (z - at_z) ** 2)
    x, z = at_x + (x - at_x) * lens, at_z + (z - at_z) * lens
    askew = 1.0 + p["effects.camera_keystone"] * z
    scale, differ = 1.0 + p["effects.camera_scale"], 0.5 * p["effects.camera_anisotropy"]
    return x * askew * scale * (1.0 + differ), z * askew * scale * (1.0 - differ)
