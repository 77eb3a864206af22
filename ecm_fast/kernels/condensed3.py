"""Newton's step of the condensed formulation for one element of order 3, written out. Do not edit.

Written by `tools/write_condensed.py`; the formulation is explained in `condensed`.
"""

import math

import numpy as np

from ._jit import kernel, step_kernel
from .condensed import LARGEST2, MAX_STEPS, SHRINK2, TOLERANCE2, largest_step, restart_lane, start_lane, vouches
from .layout import (
    C_INV_FORCE2,
    C_INV_LENGTH2,
    C_SHIFT,
    C_SLOPE,
    C_STATION,
    C_STRETCH,
    C_THETA0,
    CONVERGED,
    INVALID_INPUT,
    LANES,
    NOT_CONVERGED,
    R_EXTREME,
    R_FORCE_X,
    R_FORCE_Z,
    R_FX,
    R_FZ,
    R_KAPPA,
    R_LAM_L,
    R_LAM_R,
    R_PIVOT,
    R_SIZE,
    R_TAU,
    R_THETA,
    R_X,
    R_Z,
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

__all__ = ["advance", "solve_block", "step", "sweep"]


@step_kernel
def step(con, state, j):
    """Take one Newton step for the load case in column `j`; see `condensed`."""
    # state: curvatures at the Gauss points, tip position, tip force
    k0 = state[R_KAPPA + 0 * LANES + j]
    k1 = state[R_KAPPA + 1 * LANES + j]
    k2 = state[R_KAPPA + 2 * LANES + j]
    x, z, f_x, f_z = state[R_X + j], state[R_Z + j], state[R_FORCE_X + j], state[R_FORCE_Z + j]
    w0 = con[C_STATION + 0]
    w1 = con[C_STATION + 8]
    w2 = con[C_STATION + 16]
    # angles: the clamp's plus the integral of the curvature
    t0 = con[C_THETA0] + con[C_STATION + 24] * k0 + con[C_STATION + 25] * k1 + con[C_STATION + 26] * k2
    t1 = con[C_THETA0] + con[C_STATION + 27] * k0 + con[C_STATION + 28] * k1 + con[C_STATION + 29] * k2
    t2 = con[C_THETA0] + con[C_STATION + 30] * k0 + con[C_STATION + 31] * k1 + con[C_STATION + 32] * k2
    t_tip = con[C_THETA0] + w0 * k0 + w1 * k1 + w2 * k2
    extreme = state[R_EXTREME + j]
    # Gauss point 0: the force there is known, so stretch and shear follow from it
    r2 = t0 * t0
    r22 = r2 * r2
    s = t0 * ((0.9999999999999999 + r22 * (0.00833333333327031 + r22 * (2.7557316196951017e-06 + r22 * (1.6047346685140787e-10)))) + r2 * (-0.166666666666659 + r22 * (-0.000198412698215638 + r22 * (-2.505185572558516e-08 + r22 * (-7.364331601228968e-13)))))
    c = (1.0 + r22 * (0.04166666666666307 + r22 * (2.4801587272556152e-05 + r22 * (2.087653924157399e-09 + r22 * (4.602690920668355e-14))))) + r2 * (-0.49999999999999967 + r22 * (-0.0013888888888744474 + r22 * (-2.755731594453267e-07 + r22 * (-1.1462309288889073e-11))))
    extreme = r2 * 0.39062499999999994 if r2 * 0.39062499999999994 > extreme else extreme
    n_x, n_z = f_x + con[C_STATION + 5], f_z + con[C_STATION + 6]
    N, Q = n_x * c - n_z * s, n_x * s + n_z * c
    u = N * con[C_STATION + 1] + con[C_SHIFT]
    u2 = u * u
    stretch = (con[C_STRETCH + 0] + u2 * (con[C_STRETCH + 2] + u2 * (con[C_STRETCH + 4] + u2 * (con[C_STRETCH + 6] + u2 * (con[C_STRETCH + 8] + u2 * (con[C_STRETCH + 10] + u2 * (con[C_STRETCH + 12]))))))) + u * (con[C_STRETCH + 1] + u2 * (con[C_STRETCH + 3] + u2 * (con[C_STRETCH + 5] + u2 * (con[C_STRETCH + 7] + u2 * (con[C_STRETCH + 9] + u2 * (con[C_STRETCH + 11]))))))
    by_N = con[C_STATION + 2] * ((con[C_SLOPE + 0] + u2 * (con[C_SLOPE + 2] + u2 * (con[C_SLOPE + 4] + u2 * (con[C_SLOPE + 6] + u2 * (con[C_SLOPE + 8]))))) + u * (con[C_SLOPE + 1] + u2 * (con[C_SLOPE + 3] + u2 * (con[C_SLOPE + 5] + u2 * (con[C_SLOPE + 7])))))
    extreme = u2 if u2 > extreme else extreme
    by_Q = con[C_STATION + 7]
    shear = Q * by_Q
    a0 = w0 * (Q * (shear - Q * by_N) + N * (stretch - N * by_Q))
    along, across = w0 * (Q * by_N - shear), w0 * (stretch - N * by_Q)
    bx0, bz0 = along * c + across * s, across * c - along * s
    m0 = w0 * (Q * stretch - N * shear)
    dx0, dz0 = w0 * (stretch * c + shear * s), w0 * (shear * c - stretch * s)
    cxx0 = w0 * (c * c * by_N + s * s * by_Q)
    cxz0 = w0 * s * c * (by_Q - by_N)
    czz0 = w0 * (s * s * by_N + c * c * by_Q)
    # Gauss point 1: the force there is known, so stretch and shear follow from it
    r2 = t1 * t1
    r22 = r2 * r2
    s = t1 * ((0.9999999999999999 + r22 * (0.00833333333327031 + r22 * (2.7557316196951017e-06 + r22 * (1.6047346685140787e-10)))) + r2 * (-0.166666666666659 + r22 * (-0.000198412698215638 + r22 * (-2.505185572558516e-08 + r22 * (-7.364331601228968e-13)))))
    c = (1.0 + r22 * (0.04166666666666307 + r22 * (2.4801587272556152e-05 + r22 * (2.087653924157399e-09 + r22 * (4.602690920668355e-14))))) + r2 * (-0.49999999999999967 + r22 * (-0.0013888888888744474 + r22 * (-2.755731594453267e-07 + r22 * (-1.1462309288889073e-11))))
    extreme = r2 * 0.39062499999999994 if r2 * 0.39062499999999994 > extreme else extreme
    n_x, n_z = f_x + con[C_STATION + 13], f_z + con[C_STATION + 14]
    N, Q = n_x * c - n_z * s, n_x * s + n_z * c
    u = N * con[C_STATION + 9] + con[C_SHIFT]
    u2 = u * u
    stretch = (con[C_STRETCH + 0] + u2 * (con[C_STRETCH + 2] + u2 * (con[C_STRETCH + 4] + u2 * (con[C_STRETCH + 6] + u2 * (con[C_STRETCH + 8] + u2 * (con[C_STRETCH + 10] + u2 * (con[C_STRETCH + 12]))))))) + u * (con[C_STRETCH + 1] + u2 * (con[C_STRETCH + 3] + u2 * (con[C_STRETCH + 5] + u2 * (con[C_STRETCH + 7] + u2 * (con[C_STRETCH + 9] + u2 * (con[C_STRETCH + 11]))))))
    by_N = con[C_STATION + 10] * ((con[C_SLOPE + 0] + u2 * (con[C_SLOPE + 2] + u2 * (con[C_SLOPE + 4] + u2 * (con[C_SLOPE + 6] + u2 * (con[C_SLOPE + 8]))))) + u * (con[C_SLOPE + 1] + u2 * (con[C_SLOPE + 3] + u2 * (con[C_SLOPE + 5] + u2 * (con[C_SLOPE + 7])))))
    extreme = u2 if u2 > extreme else extreme
    by_Q = con[C_STATION + 15]
    shear = Q * by_Q
    a1 = w1 * (Q * (shear - Q * by_N) + N * (stretch - N * by_Q))
    along, across = w1 * (Q * by_N - shear), w1 * (stretch - N * by_Q)
    bx1, bz1 = along * c + across * s, across * c - along * s
    m1 = w1 * (Q * stretch - N * shear)
    dx1, dz1 = w1 * (stretch * c + shear * s), w1 * (shear * c - stretch * s)
    cxx1 = w1 * (c * c * by_N + s * s * by_Q)
    cxz1 = w1 * s * c * (by_Q - by_N)
    czz1 = w1 * (s * s * by_N + c * c * by_Q)
    # Gauss point 2: the force there is known, so stretch and shear follow from it
    r2 = t2 * t2
    r22 = r2 * r2
    s = t2 * ((0.9999999999999999 + r22 * (0.00833333333327031 + r22 * (2.7557316196951017e-06 + r22 * (1.6047346685140787e-10)))) + r2 * (-0.166666666666659 + r22 * (-0.000198412698215638 + r22 * (-2.505185572558516e-08 + r22 * (-7.364331601228968e-13)))))
    c = (1.0 + r22 * (0.04166666666666307 + r22 * (2.4801587272556152e-05 + r22 * (2.087653924157399e-09 + r22 * (4.602690920668355e-14))))) + r2 * (-0.49999999999999967 + r22 * (-0.0013888888888744474 + r22 * (-2.755731594453267e-07 + r22 * (-1.1462309288889073e-11))))
    extreme = r2 * 0.39062499999999994 if r2 * 0.39062499999999994 > extreme else extreme
    n_x, n_z = f_x + con[C_STATION + 21], f_z + con[C_STATION + 22]
    N, Q = n_x * c - n_z * s, n_x * s + n_z * c
    u = N * con[C_STATION + 17] + con[C_SHIFT]
    u2 = u * u
    stretch = (con[C_STRETCH + 0] + u2 * (con[C_STRETCH + 2] + u2 * (con[C_STRETCH + 4] + u2 * (con[C_STRETCH + 6] + u2 * (con[C_STRETCH + 8] + u2 * (con[C_STRETCH + 10] + u2 * (con[C_STRETCH + 12]))))))) + u * (con[C_STRETCH + 1] + u2 * (con[C_STRETCH + 3] + u2 * (con[C_STRETCH + 5] + u2 * (con[C_STRETCH + 7] + u2 * (con[C_STRETCH + 9] + u2 * (con[C_STRETCH + 11]))))))
    by_N = con[C_STATION + 18] * ((con[C_SLOPE + 0] + u2 * (con[C_SLOPE + 2] + u2 * (con[C_SLOPE + 4] + u2 * (con[C_SLOPE + 6] + u2 * (con[C_SLOPE + 8]))))) + u * (con[C_SLOPE + 1] + u2 * (con[C_SLOPE + 3] + u2 * (con[C_SLOPE + 5] + u2 * (con[C_SLOPE + 7])))))
    extreme = u2 if u2 > extreme else extreme
    by_Q = con[C_STATION + 23]
    shear = Q * by_Q
    a2 = w2 * (Q * (shear - Q * by_N) + N * (stretch - N * by_Q))
    along, across = w2 * (Q * by_N - shear), w2 * (stretch - N * by_Q)
    bx2, bz2 = along * c + across * s, across * c - along * s
    m2 = w2 * (Q * stretch - N * shear)
    dx2, dz2 = w2 * (stretch * c + shear * s), w2 * (shear * c - stretch * s)
    cxx2 = w2 * (c * c * by_N + s * s * by_Q)
    cxz2 = w2 * s * c * (by_Q - by_N)
    czz2 = w2 * (s * s * by_N + c * c * by_Q)
    cxx = cxx0 + cxx1 + cxx2
    cxz = cxz0 + cxz1 + cxz2
    czz = czz0 + czz1 + czz2
    dx = dx0 + dx1 + dx2
    dz = dz0 + dz1 + dz2
    # head plate: tendons, head's weight, dead wrench, and their stiffness
    r2 = t_tip * t_tip
    r22 = r2 * r2
    s = t_tip * ((0.9999999999999999 + r22 * (0.00833333333327031 + r22 * (2.7557316196951017e-06 + r22 * (1.6047346685140787e-10)))) + r2 * (-0.166666666666659 + r22 * (-0.000198412698215638 + r22 * (-2.505185572558516e-08 + r22 * (-7.364331601228968e-13)))))
    c = (1.0 + r22 * (0.04166666666666307 + r22 * (2.4801587272556152e-05 + r22 * (2.087653924157399e-09 + r22 * (4.602690920668355e-14))))) + r2 * (-0.49999999999999967 + r22 * (-0.0013888888888744474 + r22 * (-2.755731594453267e-07 + r22 * (-1.1462309288889073e-11))))
    extreme = r2 * 0.39062499999999994 if r2 * 0.39062499999999994 > extreme else extreme
    r_x, r_z = con[T_COM_X] * c + con[T_COM_Z] * s, con[T_COM_Z] * c - con[T_COM_X] * s
    weight_x, weight_z = con[T_WEIGHT_X], con[T_WEIGHT_Z]
    F_x, F_z = state[R_FX + j] + weight_x, state[R_FZ + j] + weight_z
    tau = state[R_TAU + j] + r_z * weight_x - r_x * weight_z
    H_tt = r_x * weight_x + r_z * weight_z
    r_x, r_z = con[T_ATTACH_LX] * c + con[T_ATTACH_LZ] * s, con[T_ATTACH_LZ] * c - con[T_ATTACH_LX] * s
    v_x, v_z, reach = con[T_PULLEY_LX] - x - r_x, con[T_PULLEY_LZ] - z - r_z, -con[T_RADIUS]
    square = v_x * v_x + v_z * v_z
    free = math.sqrt(square - reach * reach)
    inv = 1.0 / (square * free)
    by_square = inv * free
    e_x, e_z = (free * v_x - reach * v_z) * by_square, (free * v_z + reach * v_x) * by_square
    lam = state[R_LAM_L + j]
    pull_x, pull_z, stiff = lam * e_x, lam * e_z, lam * inv * square
    e_t = -e_z * r_z - e_x * r_x
    H_xx = stiff * e_z * e_z
    H_xz = -stiff * e_z * e_x
    H_zz = stiff * e_x * e_x
    H_xt = -stiff * e_z * e_t
    H_zt = stiff * e_x * e_t
    H_tt = H_tt + stiff * e_t * e_t + pull_x * r_x + pull_z * r_z
    F_x, F_z = F_x + pull_x, F_z + pull_z
    tau = tau + r_z * pull_x - r_x * pull_z
    r_x, r_z = con[T_ATTACH_RX] * c + con[T_ATTACH_RZ] * s, con[T_ATTACH_RZ] * c - con[T_ATTACH_RX] * s
    v_x, v_z, reach = con[T_PULLEY_RX] - x - r_x, con[T_PULLEY_RZ] - z - r_z, con[T_RADIUS]
    square = v_x * v_x + v_z * v_z
    free = math.sqrt(square - reach * reach)
    inv = 1.0 / (square * free)
    by_square = inv * free
    e_x, e_z = (free * v_x - reach * v_z) * by_square, (free * v_z + reach * v_x) * by_square
    lam = state[R_LAM_R + j]
    pull_x, pull_z, stiff = lam * e_x, lam * e_z, lam * inv * square
    e_t = -e_z * r_z - e_x * r_x
    H_xx = H_xx + stiff * e_z * e_z
    H_xz = H_xz + -stiff * e_z * e_x
    H_zz = H_zz + stiff * e_x * e_x
    H_xt = H_xt + -stiff * e_z * e_t
    H_zt = H_zt + stiff * e_x * e_t
    H_tt = H_tt + stiff * e_t * e_t + pull_x * r_x + pull_z * r_z
    F_x, F_z = F_x + pull_x, F_z + pull_z
    tau = tau + r_z * pull_x - r_x * pull_z
    # eliminate the tip force: its 2 x 2 compliance is positive, so what is left is positive where stable
    inv = 1.0 / (cxx * czz - cxz * cxz)
    i_xx, i_xz, i_zz = czz * inv, -cxz * inv, cxx * inv
    gap_x, gap_z = x - (dx), z - (dz)
    g_x, g_z = i_xx * gap_x + i_xz * gap_z, i_xz * gap_x + i_zz * gap_z
    X0, Z0 = con[C_STATION + 24] * bx0 + con[C_STATION + 27] * bx1 + con[C_STATION + 30] * bx2, con[C_STATION + 24] * bz0 + con[C_STATION + 27] * bz1 + con[C_STATION + 30] * bz2
    Y0, V0 = i_xx * X0 + i_xz * Z0, i_xz * X0 + i_zz * Z0
    b0 = -(con[C_STATION + 3] * k0 - con[C_STATION + 4] + con[C_STATION + 24] * m0 + con[C_STATION + 27] * m1 + con[C_STATION + 30] * m2 - w0 * tau + X0 * g_x + Z0 * g_z)
    X1, Z1 = con[C_STATION + 25] * bx0 + con[C_STATION + 28] * bx1 + con[C_STATION + 31] * bx2, con[C_STATION + 25] * bz0 + con[C_STATION + 28] * bz1 + con[C_STATION + 31] * bz2
    Y1, V1 = i_xx * X1 + i_xz * Z1, i_xz * X1 + i_zz * Z1
    b1 = -(con[C_STATION + 11] * k1 - con[C_STATION + 12] + con[C_STATION + 25] * m0 + con[C_STATION + 28] * m1 + con[C_STATION + 31] * m2 - w1 * tau + X1 * g_x + Z1 * g_z)
    X2, Z2 = con[C_STATION + 26] * bx0 + con[C_STATION + 29] * bx1 + con[C_STATION + 32] * bx2, con[C_STATION + 26] * bz0 + con[C_STATION + 29] * bz1 + con[C_STATION + 32] * bz2
    Y2, V2 = i_xx * X2 + i_xz * Z2, i_xz * X2 + i_zz * Z2
    b2 = -(con[C_STATION + 19] * k2 - con[C_STATION + 20] + con[C_STATION + 26] * m0 + con[C_STATION + 29] * m1 + con[C_STATION + 32] * m2 - w2 * tau + X2 * g_x + Z2 * g_z)
    b3, b4 = F_x - f_x - g_x, F_z - f_z - g_z
    # tangent by the curvatures and the tip position, lower triangle
    A0 = con[C_STATION + 24] * a0
    A1 = con[C_STATION + 27] * a1
    A2 = con[C_STATION + 30] * a2
    u0 = w0 * H_tt
    K0_0 = con[C_STATION + 3] + A0 * con[C_STATION + 24] + A1 * con[C_STATION + 27] + A2 * con[C_STATION + 30] + Y0 * X0 + V0 * Z0 + u0 * w0
    A0 = con[C_STATION + 25] * a0
    A1 = con[C_STATION + 28] * a1
    A2 = con[C_STATION + 31] * a2
    u1 = w1 * H_tt
    K1_0 = A0 * con[C_STATION + 24] + A1 * con[C_STATION + 27] + A2 * con[C_STATION + 30] + Y1 * X0 + V1 * Z0 + u1 * w0
    K1_1 = con[C_STATION + 11] + A0 * con[C_STATION + 25] + A1 * con[C_STATION + 28] + A2 * con[C_STATION + 31] + Y1 * X1 + V1 * Z1 + u1 * w1
    A0 = con[C_STATION + 26] * a0
    A1 = con[C_STATION + 29] * a1
    A2 = con[C_STATION + 32] * a2
    u2 = w2 * H_tt
    K2_0 = A0 * con[C_STATION + 24] + A1 * con[C_STATION + 27] + A2 * con[C_STATION + 30] + Y2 * X0 + V2 * Z0 + u2 * w0
    K2_1 = A0 * con[C_STATION + 25] + A1 * con[C_STATION + 28] + A2 * con[C_STATION + 31] + Y2 * X1 + V2 * Z1 + u2 * w1
    K2_2 = con[C_STATION + 19] + A0 * con[C_STATION + 26] + A1 * con[C_STATION + 29] + A2 * con[C_STATION + 32] + Y2 * X2 + V2 * Z2 + u2 * w2
    K3_0 = Y0 + w0 * H_xt
    K4_0 = V0 + w0 * H_zt
    K3_1 = Y1 + w1 * H_xt
    K4_1 = V1 + w1 * H_zt
    K3_2 = Y2 + w2 * H_xt
    K4_2 = V2 + w2 * H_zt
    K3_3 = i_xx + H_xx
    K4_3 = i_xz + H_xz
    K4_4 = i_zz + H_zz
    # factor by blocks of two, tip position first; the pivots' signs certify stability
    pivot = state[R_PIVOT + j]
    det = K3_3 * K4_4 - K4_3 * K4_3
    inv = 1.0 / det
    I3_3, I4_3, I4_4 = K4_4 * inv, -K4_3 * inv, K3_3 * inv
    pivot = K3_3 if K3_3 < pivot else pivot
    pivot = det if det < pivot else pivot
    L0_3 = K3_0 * I3_3 + K4_0 * I4_3
    L0_4 = K3_0 * I4_3 + K4_0 * I4_4
    L1_3 = K3_1 * I3_3 + K4_1 * I4_3
    L1_4 = K3_1 * I4_3 + K4_1 * I4_4
    L2_3 = K3_2 * I3_3 + K4_2 * I4_3
    L2_4 = K3_2 * I4_3 + K4_2 * I4_4
    K0_0 = K0_0 - L0_3 * K3_0 - L0_4 * K4_0
    b0 = b0 - L0_3 * b3 - L0_4 * b4
    K1_0 = K1_0 - L1_3 * K3_0 - L1_4 * K4_0
    K1_1 = K1_1 - L1_3 * K3_1 - L1_4 * K4_1
    b1 = b1 - L1_3 * b3 - L1_4 * b4
    K2_0 = K2_0 - L2_3 * K3_0 - L2_4 * K4_0
    K2_1 = K2_1 - L2_3 * K3_1 - L2_4 * K4_1
    K2_2 = K2_2 - L2_3 * K3_2 - L2_4 * K4_2
    b2 = b2 - L2_3 * b3 - L2_4 * b4
    det = K0_0 * K1_1 - K1_0 * K1_0
    inv = 1.0 / det
    I0_0, I1_0, I1_1 = K1_1 * inv, -K1_0 * inv, K0_0 * inv
    pivot = K0_0 if K0_0 < pivot else pivot
    pivot = det if det < pivot else pivot
    L2_0 = K2_0 * I0_0 + K2_1 * I1_0
    L2_1 = K2_0 * I1_0 + K2_1 * I1_1
    K2_2 = K2_2 - L2_0 * K2_0 - L2_1 * K2_1
    b2 = b2 - L2_0 * b0 - L2_1 * b1
    I2_2 = 1.0 / K2_2
    pivot = K2_2 if K2_2 < pivot else pivot
    b2 = I2_2 * b2
    b0, b1 = I0_0 * b0 + I1_0 * b1 - L2_0 * b2, I1_0 * b0 + I1_1 * b1 - L2_1 * b2
    b3, b4 = I3_3 * b3 + I4_3 * b4 - L0_3 * b0 - L1_3 * b1 - L2_3 * b2, I4_3 * b3 + I4_4 * b4 - L0_4 * b0 - L1_4 * b1 - L2_4 * b2
    # step, and the tip force that goes with it
    step_x = b3 + gap_x + X0 * b0 + X1 * b1 + X2 * b2
    step_z = b4 + gap_z + Z0 * b0 + Z1 * b1 + Z2 * b2
    state[R_KAPPA + 0 * LANES + j] = k0 + b0
    state[R_KAPPA + 1 * LANES + j] = k1 + b1
    state[R_KAPPA + 2 * LANES + j] = k2 + b2
    state[R_X + j] = x + b3
    state[R_Z + j] = z + b4
    b_x, b_z = i_xx * step_x + i_xz * step_z, i_xz * step_x + i_zz * step_z
    state[R_FORCE_X + j] = f_x + b_x
    state[R_FORCE_Z + j] = f_z + b_z
    turned = w0 * b0 + w1 * b1 + w2 * b2
    state[R_THETA + j] = t_tip + turned
    # squared size of the step: turns in rad, positions as shares of the length, and the tip force
    size = (w0 * b0) * (w0 * b0) + (w1 * b1) * (w1 * b1) + (w2 * b2) * (w2 * b2) + (b3 * b3 + b4 * b4) * con[C_INV_LENGTH2] + (b_x * b_x + b_z * b_z) * con[C_INV_FORCE2] + turned * turned
    # a step that does not shrink, or a large first one, may lead to another branch: not vouched for
    astray = size > min(LARGEST2, SHRINK2 * state[R_SIZE + j]) and size > TOLERANCE2
    extreme = 2.0 if astray else extreme
    state[R_SIZE + j] = size
    state[R_PIVOT + j] = pivot
    state[R_EXTREME + j] = extreme


@kernel
def sweep(con, state):
    """Take one Newton step for every lane; the compiler turns this loop into vector instructions."""
    for j in range(LANES):
        step(con, state, j)


@kernel
def solve_block(con, loads, state, pose, status):
    """Solve load cases from the straight beam, LANES at a time.

    loads : (n, N_LOADS)
    state : (state_size,)   work space
    pose : (n, 3), status : (n,)   overwritten; CONVERGED, or NOT_CONVERGED where the robust solver must decide
    """
    n = loads.shape[0]
    for first in range(0, n, LANES):
        for j in range(LANES):
            start_lane(con, loads[min(first + j, n - 1)], state, j)
        for _ in range(MAX_STEPS):
            sweep(con, state)
            if largest_step(state) < TOLERANCE2:
                break
        for j in range(min(LANES, n - first)):
            i = first + j
            pose[i, 0], pose[i, 1], pose[i, 2] = state[R_X + j], state[R_Z + j], state[R_THETA + j]
            status[i] = CONVERGED if vouches(state, j) else NOT_CONVERGED


@kernel
def advance(con, state, lam_l, lam_r):
    """Follow one load case, lane 0, to new tendon forces; starts again from the straight beam where that fails.

    Returns x, z, theta, status; see `condensed`.
    """
    state[R_LAM_L], state[R_LAM_R] = lam_l, lam_r
    if not (0.0 <= lam_l < np.inf and 0.0 <= lam_r < np.inf):
        return np.nan, np.nan, np.nan, INVALID_INPUT
    warm = vouches(state, 0)
    for attempt in range(2):
        if attempt == 0 and not warm:
            continue
        if attempt == 1:
            restart_lane(con, state, 0)
        state[R_SIZE], state[R_PIVOT], state[R_EXTREME] = np.inf, np.inf, 0.0
        for _ in range(MAX_STEPS):
            step(con, state, 0)
            if not state[R_SIZE] > TOLERANCE2:
                break
        if vouches(state, 0):
            return state[R_X], state[R_Z], state[R_THETA], CONVERGED
    return np.nan, np.nan, np.nan, NOT_CONVERGED
