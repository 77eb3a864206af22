"""What acts at the head plate: two tendons over pulleys, the head's weight, a dead wrench at Q."""

import numpy as np

from ._jit import kernel, step_kernel
from .layout import (
    L_FX,
    L_FZ,
    L_GRAVITY,
    L_LAM_L,
    L_LAM_R,
    L_TAU,
    T_ATTACH_LX,
    T_ATTACH_LZ,
    T_ATTACH_RX,
    T_ATTACH_RZ,
    T_COM_X,
    T_COM_Z,
    T_PULLEY_LX,
    T_PULLEY_LZ,
    T_PULLEY_RX,
    T_PULLEY_RZ,
    T_RADIUS,
    T_WEIGHT_X,
    T_WEIGHT_Z,
)
from .trig import sincos

__all__ = ["tendon", "tendon_directions", "tip_wrench"]


@step_kernel
def tendon(dx, dz, radius, side):
    """Direction and free length of a tendon that leaves its pulley on the outer side, [T1] of `reference.tip`.

    dx, dz : pulley center less attachment [m]
    radius : of the pulley [m]
    side : -1 for the left tendon, 1 for the right one

    Returns e_x, e_z, the unit vector along which the tendon pulls, and its free length [m]; that is nan where
    the attachment lies inside the pulley.
    """
    distance2 = dx * dx + dz * dz
    free = np.sqrt(distance2 - radius * radius)
    reach = side * radius
    return (free * dx - reach * dz) / distance2, (free * dz + reach * dx) / distance2, free


@kernel
def tendon_directions(tip, x, z, s, c):
    """Both tendons at a tip pose: e_x, e_z, free length of the left one, then of the right one, and their levers.

    The levers (r_x, r_z) go from Q to the attachment, in world axes [m].
    """
    l_x, l_z = tip[T_ATTACH_LX] * c + tip[T_ATTACH_LZ] * s, tip[T_ATTACH_LZ] * c - tip[T_ATTACH_LX] * s
    r_x, r_z = tip[T_ATTACH_RX] * c + tip[T_ATTACH_RZ] * s, tip[T_ATTACH_RZ] * c - tip[T_ATTACH_RX] * s
    e_lx, e_lz, free_l = tendon(tip[T_PULLEY_LX] - x - l_x, tip[T_PULLEY_LZ] - z - l_z, tip[T_RADIUS], -1.0)
    e_rx, e_rz, free_r = tendon(tip[T_PULLEY_RX] - x - r_x, tip[T_PULLEY_RZ] - z - r_z, tip[T_RADIUS], 1.0)
    return e_lx, e_lz, free_l, e_rx, e_rz, free_r, l_x, l_z, r_x, r_z


@kernel
def tip_wrench(tip, loads, x, z, theta, wrench, K):
    """Wrench on the tip section at Q, (26) + (38) + (39), and the load stiffness, [T2] and [T3] of `reference.tip`.

    tip : (N_TIP,), loads : (N_LOADS,)
    x, z, theta : tip pose [m, m, rad]
    wrench : (3,)   overwritten: f_x, f_z [N], tau [N m]
    K : (6,)        overwritten: minus its derivative by the pose, lower triangle xx, zx, zz, tx, tz, tt

    Returns the free length of the shorter tendon under tension [m]; inf when neither pulls.
    """
    s, c = sincos(theta)
    e_lx, e_lz, free_l, e_rx, e_rz, free_r, l_x, l_z, r_x, r_z = tendon_directions(tip, x, z, s, c)
    s_x, s_z = tip[T_COM_X] * c + tip[T_COM_Z] * s, tip[T_COM_Z] * c - tip[T_COM_X] * s
    w_x, w_z = loads[L_GRAVITY] * tip[T_WEIGHT_X], loads[L_GRAVITY] * tip[T_WEIGHT_Z]

    shortest = np.inf
    f_lx, f_lz, m_l, xx_l, zx_l, zz_l, tx_l, tz_l, tt_l = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    f_rx, f_rz, m_r, xx_r, zx_r, zz_r, tx_r, tz_r, tt_r = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if loads[L_LAM_L] != 0.0:
        f_lx, f_lz, m_l, xx_l, zx_l, zz_l, tx_l, tz_l, tt_l = _pull(loads[L_LAM_L], e_lx, e_lz, free_l, l_x, l_z)
        shortest = free_l.real
    if loads[L_LAM_R] != 0.0:
        f_rx, f_rz, m_r, xx_r, zx_r, zz_r, tx_r, tz_r, tt_r = _pull(loads[L_LAM_R], e_rx, e_rz, free_r, r_x, r_z)
        # a nan (attachment inside the pulley) must win
        shortest = shortest if free_r.real >= shortest else free_r.real
    wrench[0], wrench[1] = loads[L_FX] + w_x + f_lx + f_rx, loads[L_FZ] + w_z + f_lz + f_rz
    wrench[2] = loads[L_TAU] + s_z * w_x - s_x * w_z + m_l + m_r
    K[0], K[1], K[2], K[3], K[4] = xx_l + xx_r, zx_l + zx_r, zz_l + zz_r, tx_l + tx_r, tz_l + tz_r
    K[5] = s_x * w_x + s_z * w_z + tt_l + tt_r
    return shortest


@step_kernel
def _pull(lam, e_x, e_z, free, r_x, r_z):
    """One tendon's wrench f_x, f_z, tau and stiffness; it turns about its tangent point, so only across its line."""
    f_x, f_z = lam * e_x, lam * e_z
    stiffness = lam / free
    n_x, n_z = -stiffness * e_z, stiffness * e_x
    n_t = -e_z * r_z - e_x * r_x  # how the attachment moves across the line when the plate turns
    tt = stiffness * n_t * n_t + f_x * r_x + f_z * r_z
    return f_x, f_z, r_z * f_x - r_x * f_z, -n_x * e_z, n_x * e_x, n_z * e_x, n_x * n_t, n_z * n_t, tt
