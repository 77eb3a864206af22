"""The camera's reading of the pose of Q."""

from typing import Any

import numpy as np

from .parameters import Parameters

__all__ = ["reading"]


def _turned(r: Any, angle: Any) -> Any:
    """Vector (2,) whose components along axes turned by `angle` are `r`."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([r[0] * c + r[1] * s, r[1] * c - r[0] * s])


def reading(p: Parameters, pose: Any) -> Any:
    """[V1] Reading (3,) of a pose x, z, theta.

    The marker sits at a lever in the head's frame; lens, keystone and scales stretch what is seen from the clamp;
    then the camera's axes are turned, and its origin and the marker's angle are off.
    """
    seen = pose[:2] + _turned((p["effects.marker_lever_x"], p["effects.marker_lever_z"]), pose[2])
    seen = seen * (1.0 + p["effects.lens_distortion"] * (seen @ seen))
    seen = seen * (1.0 + p["effects.camera_keystone"] * seen[1])
    uneven = 0.5 * p["effects.camera_anisotropy"]
    seen = seen * (1.0 + p["effects.camera_scale"]) * np.array([1.0 + uneven, 1.0 - uneven])
    offset = np.array([p["effects.camera_x_offset"], p["effects.camera_z_offset"]])
    turn = p["effects.camera_rotation"]
    return np.append(_turned(seen, turn) + offset, pose[2] + turn + p["effects.marker_angle_offset"])
