"""Contact of tendons with their pulleys: the direction in which a tendon leaves its pulley, and its free length."""

import numpy as np

from .. import layout as at
from .._jit import kernel, step_kernel

__all__ = ["chord", "tendon", "tendon_directions"]


@step_kernel
def tendon(dx, dz, reach):
    """Direction and free length of a tendon that leaves its pulley on one side, [T1] of `reference.tip`.

    dx, dz : pulley center less attachment [m]
    reach : radius of the pulley, with the sign of the side, see `layout` [m]

    Returns e_x, e_z, the unit vector along which the tendon pulls, and its free length [m]; that is nan where
    the attachment lies inside the pulley.
    """
    distance2 = dx * dx + dz * dz
    free = np.sqrt(distance2 - reach * reach)
    return (free * dx - reach * dz) / distance2, (free * dz + reach * dx) / distance2, free


@kernel
def tendon_directions(tip, x, z, s, c):
    """Both tendons at a tip pose: e_x, e_z, free length of the left one, then of the right one, and their levers.

    The levers (r_x, r_z) go from Q to the attachment, in world axes [m].
    """
    l_x, l_z = tip[at.T_ATTACH_LX] * c + tip[at.T_ATTACH_LZ] * s, tip[at.T_ATTACH_LZ] * c - tip[at.T_ATTACH_LX] * s
    r_x, r_z = tip[at.T_ATTACH_RX] * c + tip[at.T_ATTACH_RZ] * s, tip[at.T_ATTACH_RZ] * c - tip[at.T_ATTACH_RX] * s
    e_lx, e_lz, free_l = tendon(tip[at.T_PULLEY_LX] - x - l_x, tip[at.T_PULLEY_LZ] - z - l_z, tip[at.T_REACH_L])
    e_rx, e_rz, free_r = tendon(tip[at.T_PULLEY_RX] - x - r_x, tip[at.T_PULLEY_RZ] - z - r_z, tip[at.T_REACH_R])
    return e_lx, e_lz, free_l, e_rx, e_rz, free_r, l_x, l_z, r_x, r_z


@kernel
def chord(tip, i, x, z, s, c):
    """A chord beside the first two tendons: e_x, e_z, free length, and lever from Q in world axes."""
    anchors = tip[at.T_CHORD + at.N_CHORD * i : at.T_CHORD + at.N_CHORD * (i + 1)]
    r_x, r_z = anchors[1] * c + anchors[2] * s, anchors[2] * c - anchors[1] * s
    e_x, e_z, free = tendon(anchors[3] - x - r_x, anchors[4] - z - r_z, anchors[5])
    return e_x, e_z, free, r_x, r_z
