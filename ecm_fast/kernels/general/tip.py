"""The wrench on the head plate: two tendons over pulleys, the head's weight, a dead wrench at Q."""

import numpy as np

from .. import layout as at
from .._jit import kernel, step_kernel
from ..trig import sincos
from ..user_laws import added
from .pulleys import chord, tendon_directions

__all__ = ["force_slopes", "plate_turn", "tendon_forces", "tip_wrench"]


# the joint of the head plate: most Newton steps, and the gap that is closed [rad]
JOINT_STEPS, JOINT_CLOSED = 20, 1e-13


@step_kernel
def tendon_forces(tip, loads):
    """Tendon forces from the readings of the force cells, [T4] of `reference.tip`; for none they are the readings."""
    left, right, share = loads[at.L_LAM_L], loads[at.L_LAM_R], loads[at.L_GRAVITY]
    curved, cross = tip[at.T_NONLINEARITY], tip[at.T_CROSSTALK]
    lam_l = left * (tip[at.T_GAIN_L] + curved * left) + cross * right + share * tip[at.T_ZERO_L]
    lam_r = right * (tip[at.T_GAIN_R] + curved * right) + cross * left + share * tip[at.T_ZERO_R]
    return lam_l, lam_r


@kernel
def force_slopes(tip, left, right, jacobian):
    """Turn derivatives by the tendon forces, (3, 2), into derivatives by the readings `left`, `right` [N]."""
    curved, cross = 2.0 * tip[at.T_NONLINEARITY], tip[at.T_CROSSTALK]
    by_l, by_r = tip[at.T_GAIN_L] + curved * left, tip[at.T_GAIN_R] + curved * right
    for i in range(3):
        of_l, of_r = jacobian[i, 0], jacobian[i, 1]
        jacobian[i, 0], jacobian[i, 1] = by_l * of_l + cross * of_r, by_r * of_r + cross * of_l


@kernel
def _head_wrench(tip, loads, x, z, theta, wrench, K):
    """Wrench on the head at Q, (26) + (38) + (39), and its stiffness; arguments and result as for `tip_wrench`."""
    s, c = sincos(theta)
    e_lx, e_lz, free_l, e_rx, e_rz, free_r, l_x, l_z, r_x, r_z = tendon_directions(tip, x, z, s, c)
    s_x, s_z = tip[at.T_COM_X] * c + tip[at.T_COM_Z] * s, tip[at.T_COM_Z] * c - tip[at.T_COM_X] * s
    share = loads[at.L_GRAVITY]
    w_x, w_z = share * tip[at.T_WEIGHT_X], share * tip[at.T_WEIGHT_Z]
    lam_l, lam_r = tendon_forces(tip, loads)

    shortest = np.inf
    f_lx, f_lz, m_l, xx_l, zx_l, zz_l, tx_l, tz_l, tt_l = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    f_rx, f_rz, m_r, xx_r, zx_r, zz_r, tx_r, tz_r, tt_r = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if lam_l != 0.0:
        f_lx, f_lz, m_l, xx_l, zx_l, zz_l, tx_l, tz_l, tt_l = _pull(lam_l, e_lx, e_lz, free_l, l_x, l_z)
        shortest = free_l.real
    if lam_r != 0.0:
        f_rx, f_rz, m_r, xx_r, zx_r, zz_r, tx_r, tz_r, tt_r = _pull(lam_r, e_rx, e_rz, free_r, r_x, r_z)
        shortest = _shorter(shortest, free_r.real)
    k_z, k_t = tip[at.T_SPRING_Z], tip[at.T_SPRING_T]
    stop, stop_tt = _stops(tip, theta)
    wrench[0] = loads[at.L_FX] + w_x + f_lx + f_rx
    wrench[1] = loads[at.L_FZ] + w_z + f_lz + f_rz + share * tip[at.T_SIDE] - k_z * z
    wrench[2] = loads[at.L_TAU] + s_z * w_x - s_x * w_z + m_l + m_r - k_t * theta - stop
    K[0], K[1], K[2], K[3], K[4] = xx_l + xx_r, zx_l + zx_r, zz_l + zz_r + k_z, tx_l + tx_r, tz_l + tz_r
    K[5] = s_x * w_x + s_z * w_z + tt_l + tt_r + k_t + stop_tt
    if tip[at.T_CHORDS] != 0.0:
        shortest = _add_chords(tip, loads, x, z, s, c, wrench, K, shortest)
    if tip[at.T_LAW] != 0.0:
        forces, by = added(x, z, theta, tip[at.T_LAW], tip[at.T_USER :], 1.0)
        a = loads[at.L_PRESTRAIN]
        for i in range(3):
            wrench[i] += a * forces[i]
        K[0], K[1], K[2] = K[0] - a * by[0], K[1] - a * by[1], K[2] - a * by[3]
        K[3], K[4], K[5] = K[3] - a * by[2], K[4] - a * by[4], K[5] - a * by[5]
    return shortest


@kernel
def _add_chords(tip, loads, x, z, s, c, wrench, K, shortest):
    """Add the chords beside the first two tendons to wrench and stiffness; returns the shortest free length so far."""
    for i in range(int(tip[at.T_CHORDS].real)):
        anchors = tip[at.T_CHORD + at.N_CHORD * i : at.T_CHORD + at.N_CHORD * (i + 1)]
        lam = loads[int(anchors[0].real)] * anchors[6] + loads[at.L_GRAVITY] * anchors[7]
        if lam == 0.0:
            continue
        e_x, e_z, free, r_x, r_z = chord(tip, i, x, z, s, c)
        f_x, f_z, m, xx, zx, zz, tx, tz, tt = _pull(lam, e_x, e_z, free, r_x, r_z)
        wrench[0] += f_x
        wrench[1] += f_z
        wrench[2] += m
        K[0] += xx
        K[1] += zx
        K[2] += zz
        K[3] += tx
        K[4] += tz
        K[5] += tt
        shortest = _shorter(shortest, free.real)
    return shortest


@kernel
def _shorter(length, other):
    """The smaller of two free lengths; nan, of an attachment inside its pulley, where either is."""
    return length if other >= length or length != length else other


@step_kernel
def _stops(tip, theta):
    """Couple of the soft stops against the head's turn, and its derivative."""
    both, one = tip[at.T_STOP], tip[at.T_STOP_1]
    couple, slope = 0.0 * theta, 0.0 * theta
    angle = tip[at.T_STOP_ANGLE]
    if theta.real > angle.real:
        couple, slope = both * (theta - angle), both + 0.0 * theta
    if theta.real < -angle.real:
        couple, slope = both * (theta + angle), both + 0.0 * theta
    if theta.real > tip[at.T_STOP_1_ANGLE].real:
        couple, slope = couple + one * (theta - tip[at.T_STOP_1_ANGLE]), slope + one
    return couple, slope


@kernel
def tip_wrench(tip, loads, x, z, theta, wrench, K):
    """Wrench on the tip section at Q and its load stiffness, [T2] and [T3] of `reference.tip`.

    tip : (N_TIP,), loads : (N_LOADS,)
    x, z, theta : pose of the tip section [m, m, rad]
    wrench : (3,)   overwritten: f_x, f_z [N], tau [N m]
    K : (6,)        overwritten: minus its derivative by the pose, lower triangle xx, zx, zz, tx, tz, tt

    Where the joint of the head plate gives way, the head has turned further than the section, until the joint's
    couple is the head's, [T5]; the stiffness is what is left when that turn is eliminated.

    Returns the free length of the shorter tendon under tension [m], inf when neither pulls; and the head's angle.
    """
    free = _head_wrench(tip, loads, x, z, theta, wrench, K)
    joint = tip[at.T_JOINT]
    turned = theta
    if joint != 0.0:
        for _ in range(JOINT_STEPS):
            gap = turned - theta - joint * wrench[2]
            turned -= gap / (1.0 + joint * K[5])
            free = _head_wrench(tip, loads, x, z, turned, wrench, K)
            if abs(gap) < JOINT_CLOSED:
                break
        across, along, by = K[3], K[4], 1.0 / (1.0 + joint * K[5])
        K[0] -= across * across * joint * by
        K[1] -= across * along * joint * by
        K[2] -= along * along * joint * by
        K[3], K[4], K[5] = across * by, along * by, K[5] * by
    return free, turned


@kernel
def plate_turn(tip, loads, x, z, turned, K):
    """Turn of the head with the tip section: derivatives of its angle by x, z, theta of the section and by a couple.

    turned : the head's angle; K : (9,) work space
    """
    joint = tip[at.T_JOINT]
    if joint == 0.0:
        return 0.0, 0.0, 1.0, 0.0
    _head_wrench(tip, loads, x, z, turned, K[6:9], K)
    by = 1.0 / (1.0 + joint * K[5])
    return -joint * K[3] * by, -joint * K[4] * by, by, joint * by


@step_kernel
def _pull(lam, e_x, e_z, free, r_x, r_z):
    """One tendon's wrench f_x, f_z, tau and stiffness; it turns about its tangent point, so only across its line."""
    f_x, f_z = lam * e_x, lam * e_z
    stiffness = lam / free
    n_x, n_z = -stiffness * e_z, stiffness * e_x
    n_t = -e_z * r_z - e_x * r_x  # how the attachment moves across the line when the plate turns
    tt = stiffness * n_t * n_t + f_x * r_x + f_z * r_z
    return f_x, f_z, r_z * f_x - r_x * f_z, -n_x * e_z, n_x * e_x, n_z * e_x, n_x * n_t, n_z * n_t, tt
