"""The physics of one Newton step of the condensed formulation: a section under a known force, and the head plate.

Both serve one load case and, inside a loop over lanes, a block of them; `condensed` explains the formulation and how
constants and state are addressed.
"""

import numpy as np

from .._jit import step_kernel
from ..layout import (
    C_SHIFT,
    C_STATION,
    N_POINT,
    N_SECTION,
    P_BX,
    P_BZ,
    P_COUPLE,
    P_DX,
    P_DZ,
    P_THETA,
    P_TURN,
    P_XX,
    P_XZ,
    P_ZZ,
    R_EXTREME,
    R_FORCE_X,
    R_FORCE_Z,
    R_FX,
    R_FZ,
    R_LAM_L,
    R_LAM_R,
    R_LT,
    R_LX,
    R_LZ,
    R_POINT,
    R_RT,
    R_RX,
    R_RZ,
    R_TAU,
    R_THETA,
    R_TT,
    R_WTAU,
    R_WX,
    R_WZ,
    R_X,
    R_XT,
    R_XX,
    R_XZ,
    R_Z,
    R_ZT,
    R_ZZ,
    T_ATTACH_LX,
    T_ATTACH_LZ,
    T_ATTACH_RX,
    T_ATTACH_RZ,
    T_COM_X,
    T_COM_Z,
    T_CROSSTALK,
    T_GAIN_L,
    T_GAIN_R,
    T_NONLINEARITY,
    T_PULLEY_LX,
    T_PULLEY_LZ,
    T_PULLEY_RX,
    T_PULLEY_RZ,
    T_REACH_L,
    T_REACH_R,
    T_SIDE,
    T_SPRING_T,
    T_SPRING_Z,
    T_WEIGHT_X,
    T_WEIGHT_Z,
    T_ZERO_L,
    T_ZERO_R,
)
from ..trig import NEAR, sincos_near
from .axial_law import stretch_at

__all__ = ["plate", "section"]

_PER_NEAR2 = 1.0 / NEAR**2


@step_kernel
def section(con, cr, cl, state, sr, j, g):
    """Gauss point `g`: the force there is known, so stretch and shear follow from it."""
    i, r = cr * (C_STATION + N_POINT * g) + cl, sr * (R_POINT + N_SECTION * g) + j
    w = con[i]
    theta = state[r + sr * P_THETA]
    s, c = sincos_near(theta)
    n_x, n_z = state[sr * R_FORCE_X + j] + con[i + cr * 3], state[sr * R_FORCE_Z + j] + con[i + cr * 4]
    N, Q = n_x * c - n_z * s, n_x * s + n_z * c
    u = N * con[i + cr] + con[cr * C_SHIFT + cl]
    stretch, slope = stretch_at(con, cr, cl, u)
    by_N, by_Q = con[i + cr * 2] * slope, con[i + cr * 5]
    shear = Q * by_Q
    across, along = stretch - N * by_Q, Q * by_N - shear
    ws, wc = w * s, w * c
    state[r + sr * P_TURN] = w * (N * across - Q * along)
    state[r + sr * P_COUPLE] = w * (Q * stretch - N * shear)
    state[r + sr * P_BX], state[r + sr * P_BZ] = along * wc + across * ws, across * wc - along * ws
    state[r + sr * P_DX], state[r + sr * P_DZ] = stretch * wc + shear * ws, shear * wc - stretch * ws
    c_N, s_Q = wc * by_N, ws * by_Q
    state[r + sr * P_XX] = c_N * c + s_Q * s
    state[r + sr * P_XZ] = s_Q * c - c_N * s
    state[r + sr * P_ZZ] = ws * (s * by_N) + wc * (c * by_Q)
    # how near the polynomials are to the ends of their ranges; beyond 1 the general path takes over
    e = sr * R_EXTREME + j
    turned, strained, extreme = theta * theta * _PER_NEAR2, u * u, state[e]
    extreme = turned if turned > extreme else extreme
    state[e] = strained if strained > extreme else extreme


@step_kernel
def _tendon(lever_x, lever_z, v_x, v_z, reach):
    """Pull of a tendon by unit force, and its stiffness by unit force: see `tip.tendon`; here with one division.

    lever_x, lever_z : from Q to the attachment, v_x, v_z : from there to the pulley's center [m]
    reach : radius of the pulley, with the sign of the side on which the tendon passes it [m]

    Returns e_x, e_z, moment about Q, 1/free length, and how far the attachment moves across the tendon by turn.
    """
    square = v_x * v_x + v_z * v_z
    free = np.sqrt(square - reach * reach)
    inv = 1.0 / (square * free)
    by_square = inv * free
    e_x, e_z = (free * v_x - reach * v_z) * by_square, (free * v_z + reach * v_x) * by_square
    return e_x, e_z, lever_z * e_x - lever_x * e_z, inv * square, -e_z * lever_z - e_x * lever_x


@step_kernel
def forces(con, cr, cl, left, right):
    """Tendon forces from the readings of the force cells, as `tip.tendon_forces` under the whole load."""
    curved, cross = con[cr * T_NONLINEARITY + cl], con[cr * T_CROSSTALK + cl]
    lam_l = left * (con[cr * T_GAIN_L + cl] + curved * left) + (cross * right + con[cr * T_ZERO_L + cl])
    lam_r = right * (con[cr * T_GAIN_R + cl] + curved * right) + (cross * left + con[cr * T_ZERO_R + cl])
    return lam_l, lam_r


@step_kernel
def plate(con, cr, cl, state, sr, j):
    """Head plate: tendons, head's weight and dead wrench, and their stiffness, as `tip.tip_wrench`."""
    theta = state[sr * R_THETA + j]
    s, c = sincos_near(theta)
    e = sr * R_EXTREME + j
    turned, extreme = theta * theta * _PER_NEAR2, state[e]
    state[e] = turned if turned > extreme else extreme
    com_x, com_z = con[cr * T_COM_X + cl], con[cr * T_COM_Z + cl]
    w_x, w_z = con[cr * T_WEIGHT_X + cl], con[cr * T_WEIGHT_Z + cl]
    r_x, r_z = com_x * c + com_z * s, com_z * c - com_x * s
    a_x, a_z = con[cr * T_ATTACH_LX + cl], con[cr * T_ATTACH_LZ + cl]
    l_x, l_z = a_x * c + a_z * s, a_z * c - a_x * s
    a_x, a_z = con[cr * T_ATTACH_RX + cl], con[cr * T_ATTACH_RZ + cl]
    m_x, m_z = a_x * c + a_z * s, a_z * c - a_x * s
    x, z = state[sr * R_X + j], state[sr * R_Z + j]
    v_x, v_z = con[cr * T_PULLEY_LX + cl] - x - l_x, con[cr * T_PULLEY_LZ + cl] - z - l_z
    l_ex, l_ez, l_tau, l_inv, l_t = _tendon(l_x, l_z, v_x, v_z, con[cr * T_REACH_L + cl])
    v_x, v_z = con[cr * T_PULLEY_RX + cl] - x - m_x, con[cr * T_PULLEY_RZ + cl] - z - m_z
    r_ex, r_ez, r_tau, r_inv, r_t = _tendon(m_x, m_z, v_x, v_z, con[cr * T_REACH_R + cl])
    lam_l, lam_r = forces(con, cr, cl, state[sr * R_LAM_L + j], state[sr * R_LAM_R + j])
    k_z, k_t, side = con[cr * T_SPRING_Z + cl], con[cr * T_SPRING_T + cl], con[cr * T_SIDE + cl]
    state[sr * R_WX + j] = state[sr * R_FX + j] + w_x + lam_l * l_ex + lam_r * r_ex
    state[sr * R_WZ + j] = state[sr * R_FZ + j] + w_z + lam_l * l_ez + lam_r * r_ez + side - k_z * z
    couple = r_z * w_x - r_x * w_z + lam_l * l_tau + lam_r * r_tau
    state[sr * R_WTAU + j] = state[sr * R_TAU + j] + couple - k_t * theta
    # the stiffness acts across the tendon, along (-e_z, e_x)
    k_l, k_r = lam_l * l_inv, lam_r * r_inv
    state[sr * R_XX + j] = k_l * l_ez * l_ez + k_r * r_ez * r_ez
    state[sr * R_XZ + j] = -k_l * l_ez * l_ex - k_r * r_ez * r_ex
    state[sr * R_ZZ + j] = k_l * l_ex * l_ex + k_r * r_ex * r_ex + k_z
    state[sr * R_XT + j] = -k_l * l_ez * l_t - k_r * r_ez * r_t
    state[sr * R_ZT + j] = k_l * l_ex * l_t + k_r * r_ex * r_t
    turn_l, turn_r = lam_l * (l_ex * l_x + l_ez * l_z), lam_r * (r_ex * m_x + r_ez * m_z)
    state[sr * R_TT + j] = r_x * w_x + r_z * w_z + k_l * l_t * l_t + k_r * r_t * r_t + turn_l + turn_r + k_t
    state[sr * R_LX + j], state[sr * R_LZ + j], state[sr * R_LT + j] = l_ex, l_ez, l_tau
    state[sr * R_RX + j], state[sr * R_RZ + j], state[sr * R_RT + j] = r_ex, r_ez, r_tau
