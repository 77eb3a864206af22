"""Newton's step of the condensed formulation for one element of order 6, written out. Do not edit.

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
    k3 = state[R_KAPPA + 3 * LANES + j]
    k4 = state[R_KAPPA + 4 * LANES + j]
    k5 = state[R_KAPPA + 5 * LANES + j]
    x, z, f_x, f_z = state[R_X + j], state[R_Z + j], state[R_FORCE_X + j], state[R_FORCE_Z + j]
    w0 = con[C_STATION + 0]
    w1 = con[C_STATION + 8]
    w2 = con[C_STATION + 16]
    w3 = con[C_STATION + 24]
    w4 = con[C_STATION + 32]
    w5 = con[C_STATION + 40]
    # angles: the clamp's plus the integral of the curvature
    t0 = con[C_THETA0] + con[C_STATION + 48] * k0 + con[C_STATION + 49] * k1 + con[C_STATION + 50] * k2 + con[C_STATION + 51] * k3 + con[C_STATION + 52] * k4 + con[C_STATION + 53] * k5
    t1 = con[C_THETA0] + con[C_STATION + 54] * k0 + con[C_STATION + 55] * k1 + con[C_STATION + 56] * k2 + con[C_STATION + 57] * k3 + con[C_STATION + 58] * k4 + con[C_STATION + 59] * k5
    t2 = con[C_THETA0] + con[C_STATION + 60] * k0 + con[C_STATION + 61] * k1 + con[C_STATION + 62] * k2 + con[C_STATION + 63] * k3 + con[C_STATION + 64] * k4 + con[C_STATION + 65] * k5
    t3 = con[C_THETA0] + con[C_STATION + 66] * k0 + con[C_STATION + 67] * k1 + con[C_STATION + 68] * k2 + con[C_STATION + 69] * k3 + con[C_STATION + 70] * k4 + con[C_STATION + 71] * k5
    t4 = con[C_THETA0] + con[C_STATION + 72] * k0 + con[C_STATION + 73] * k1 + con[C_STATION + 74] * k2 + con[C_STATION + 75] * k3 + con[C_STATION + 76] * k4 + con[C_STATION + 77] * k5
    t5 = con[C_THETA0] + con[C_STATION + 78] * k0 + con[C_STATION + 79] * k1 + con[C_STATION + 80] * k2 + con[C_STATION + 81] * k3 + con[C_STATION + 82] * k4 + con[C_STATION + 83] * k5
    t_tip = con[C_THETA0] + w0 * k0 + w1 * k1 + w2 * k2 + w3 * k3 + w4 * k4 + w5 * k5
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
    # Gauss point 3: the force there is known, so stretch and shear follow from it
    r2 = t3 * t3
    r22 = r2 * r2
    s = t3 * ((0.9999999999999999 + r22 * (0.00833333333327031 + r22 * (2.7557316196951017e-06 + r22 * (1.6047346685140787e-10)))) + r2 * (-0.166666666666659 + r22 * (-0.000198412698215638 + r22 * (-2.505185572558516e-08 + r22 * (-7.364331601228968e-13)))))
    c = (1.0 + r22 * (0.04166666666666307 + r22 * (2.4801587272556152e-05 + r22 * (2.087653924157399e-09 + r22 * (4.602690920668355e-14))))) + r2 * (-0.49999999999999967 + r22 * (-0.0013888888888744474 + r22 * (-2.755731594453267e-07 + r22 * (-1.1462309288889073e-11))))
    extreme = r2 * 0.39062499999999994 if r2 * 0.39062499999999994 > extreme else extreme
    n_x, n_z = f_x + con[C_STATION + 29], f_z + con[C_STATION + 30]
    N, Q = n_x * c - n_z * s, n_x * s + n_z * c
    u = N * con[C_STATION + 25] + con[C_SHIFT]
    u2 = u * u
    stretch = (con[C_STRETCH + 0] + u2 * (con[C_STRETCH + 2] + u2 * (con[C_STRETCH + 4] + u2 * (con[C_STRETCH + 6] + u2 * (con[C_STRETCH + 8] + u2 * (con[C_STRETCH + 10] + u2 * (con[C_STRETCH + 12]))))))) + u * (con[C_STRETCH + 1] + u2 * (con[C_STRETCH + 3] + u2 * (con[C_STRETCH + 5] + u2 * (con[C_STRETCH + 7] + u2 * (con[C_STRETCH + 9] + u2 * (con[C_STRETCH + 11]))))))
    by_N = con[C_STATION + 26] * ((con[C_SLOPE + 0] + u2 * (con[C_SLOPE + 2] + u2 * (con[C_SLOPE + 4] + u2 * (con[C_SLOPE + 6] + u2 * (con[C_SLOPE + 8]))))) + u * (con[C_SLOPE + 1] + u2 * (con[C_SLOPE + 3] + u2 * (con[C_SLOPE + 5] + u2 * (con[C_SLOPE + 7])))))
    extreme = u2 if u2 > extreme else extreme
    by_Q = con[C_STATION + 31]
    shear = Q * by_Q
    a3 = w3 * (Q * (shear - Q * by_N) + N * (stretch - N * by_Q))
    along, across = w3 * (Q * by_N - shear), w3 * (stretch - N * by_Q)
    bx3, bz3 = along * c + across * s, across * c - along * s
    m3 = w3 * (Q * stretch - N * shear)
    dx3, dz3 = w3 * (stretch * c + shear * s), w3 * (shear * c - stretch * s)
    cxx3 = w3 * (c * c * by_N + s * s * by_Q)
    cxz3 = w3 * s * c * (by_Q - by_N)
    czz3 = w3 * (s * s * by_N + c * c * by_Q)
    # Gauss point 4: the force there is known, so stretch and shear follow from it
    r2 = t4 * t4
    r22 = r2 * r2
    s = t4 * ((0.9999999999999999 + r22 * (0.00833333333327031 + r22 * (2.7557316196951017e-06 + r22 * (1.6047346685140787e-10)))) + r2 * (-0.166666666666659 + r22 * (-0.000198412698215638 + r22 * (-2.505185572558516e-08 + r22 * (-7.364331601228968e-13)))))
    c = (1.0 + r22 * (0.04166666666666307 + r22 * (2.4801587272556152e-05 + r22 * (2.087653924157399e-09 + r22 * (4.602690920668355e-14))))) + r2 * (-0.49999999999999967 + r22 * (-0.0013888888888744474 + r22 * (-2.755731594453267e-07 + r22 * (-1.1462309288889073e-11))))
    extreme = r2 * 0.39062499999999994 if r2 * 0.39062499999999994 > extreme else extreme
    n_x, n_z = f_x + con[C_STATION + 37], f_z + con[C_STATION + 38]
    N, Q = n_x * c - n_z * s, n_x * s + n_z * c
    u = N * con[C_STATION + 33] + con[C_SHIFT]
    u2 = u * u
    stretch = (con[C_STRETCH + 0] + u2 * (con[C_STRETCH + 2] + u2 * (con[C_STRETCH + 4] + u2 * (con[C_STRETCH + 6] + u2 * (con[C_STRETCH + 8] + u2 * (con[C_STRETCH + 10] + u2 * (con[C_STRETCH + 12]))))))) + u * (con[C_STRETCH + 1] + u2 * (con[C_STRETCH + 3] + u2 * (con[C_STRETCH + 5] + u2 * (con[C_STRETCH + 7] + u2 * (con[C_STRETCH + 9] + u2 * (con[C_STRETCH + 11]))))))
    by_N = con[C_STATION + 34] * ((con[C_SLOPE + 0] + u2 * (con[C_SLOPE + 2] + u2 * (con[C_SLOPE + 4] + u2 * (con[C_SLOPE + 6] + u2 * (con[C_SLOPE + 8]))))) + u * (con[C_SLOPE + 1] + u2 * (con[C_SLOPE + 3] + u2 * (con[C_SLOPE + 5] + u2 * (con[C_SLOPE + 7])))))
    extreme = u2 if u2 > extreme else extreme
    by_Q = con[C_STATION + 39]
    shear = Q * by_Q
    a4 = w4 * (Q * (shear - Q * by_N) + N * (stretch - N * by_Q))
    along, across = w4 * (Q * by_N - shear), w4 * (stretch - N * by_Q)
    bx4, bz4 = along * c + across * s, across * c - along * s
    m4 = w4 * (Q * stretch - N * shear)
    dx4, dz4 = w4 * (stretch * c + shear * s), w4 * (shear * c - stretch * s)
    cxx4 = w4 * (c * c * by_N + s * s * by_Q)
    cxz4 = w4 * s * c * (by_Q - by_N)
    czz4 = w4 * (s * s * by_N + c * c * by_Q)
    # Gauss point 5: the force there is known, so stretch and shear follow from it
    r2 = t5 * t5
    r22 = r2 * r2
    s = t5 * ((0.9999999999999999 + r22 * (0.00833333333327031 + r22 * (2.7557316196951017e-06 + r22 * (1.6047346685140787e-10)))) + r2 * (-0.166666666666659 + r22 * (-0.000198412698215638 + r22 * (-2.505185572558516e-08 + r22 * (-7.364331601228968e-13)))))
    c = (1.0 + r22 * (0.04166666666666307 + r22 * (2.4801587272556152e-05 + r22 * (2.087653924157399e-09 + r22 * (4.602690920668355e-14))))) + r2 * (-0.49999999999999967 + r22 * (-0.0013888888888744474 + r22 * (-2.755731594453267e-07 + r22 * (-1.1462309288889073e-11))))
    extreme = r2 * 0.39062499999999994 if r2 * 0.39062499999999994 > extreme else extreme
    n_x, n_z = f_x + con[C_STATION + 45], f_z + con[C_STATION + 46]
    N, Q = n_x * c - n_z * s, n_x * s + n_z * c
    u = N * con[C_STATION + 41] + con[C_SHIFT]
    u2 = u * u
    stretch = (con[C_STRETCH + 0] + u2 * (con[C_STRETCH + 2] + u2 * (con[C_STRETCH + 4] + u2 * (con[C_STRETCH + 6] + u2 * (con[C_STRETCH + 8] + u2 * (con[C_STRETCH + 10] + u2 * (con[C_STRETCH + 12]))))))) + u * (con[C_STRETCH + 1] + u2 * (con[C_STRETCH + 3] + u2 * (con[C_STRETCH + 5] + u2 * (con[C_STRETCH + 7] + u2 * (con[C_STRETCH + 9] + u2 * (con[C_STRETCH + 11]))))))
    by_N = con[C_STATION + 42] * ((con[C_SLOPE + 0] + u2 * (con[C_SLOPE + 2] + u2 * (con[C_SLOPE + 4] + u2 * (con[C_SLOPE + 6] + u2 * (con[C_SLOPE + 8]))))) + u * (con[C_SLOPE + 1] + u2 * (con[C_SLOPE + 3] + u2 * (con[C_SLOPE + 5] + u2 * (con[C_SLOPE + 7])))))
    extreme = u2 if u2 > extreme else extreme
    by_Q = con[C_STATION + 47]
    shear = Q * by_Q
    a5 = w5 * (Q * (shear - Q * by_N) + N * (stretch - N * by_Q))
    along, across = w5 * (Q * by_N - shear), w5 * (stretch - N * by_Q)
    bx5, bz5 = along * c + across * s, across * c - along * s
    m5 = w5 * (Q * stretch - N * shear)
    dx5, dz5 = w5 * (stretch * c + shear * s), w5 * (shear * c - stretch * s)
    cxx5 = w5 * (c * c * by_N + s * s * by_Q)
    cxz5 = w5 * s * c * (by_Q - by_N)
    czz5 = w5 * (s * s * by_N + c * c * by_Q)
    cxx = cxx0 + cxx1 + cxx2 + cxx3 + cxx4 + cxx5
    cxz = cxz0 + cxz1 + cxz2 + cxz3 + cxz4 + cxz5
    czz = czz0 + czz1 + czz2 + czz3 + czz4 + czz5
    dx = dx0 + dx1 + dx2 + dx3 + dx4 + dx5
    dz = dz0 + dz1 + dz2 + dz3 + dz4 + dz5
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
    X0, Z0 = con[C_STATION + 48] * bx0 + con[C_STATION + 54] * bx1 + con[C_STATION + 60] * bx2 + con[C_STATION + 66] * bx3 + con[C_STATION + 72] * bx4 + con[C_STATION + 78] * bx5, con[C_STATION + 48] * bz0 + con[C_STATION + 54] * bz1 + con[C_STATION + 60] * bz2 + con[C_STATION + 66] * bz3 + con[C_STATION + 72] * bz4 + con[C_STATION + 78] * bz5
    Y0, V0 = i_xx * X0 + i_xz * Z0, i_xz * X0 + i_zz * Z0
    b0 = -(con[C_STATION + 3] * k0 - con[C_STATION + 4] + con[C_STATION + 48] * m0 + con[C_STATION + 54] * m1 + con[C_STATION + 60] * m2 + con[C_STATION + 66] * m3 + con[C_STATION + 72] * m4 + con[C_STATION + 78] * m5 - w0 * tau + X0 * g_x + Z0 * g_z)
    X1, Z1 = con[C_STATION + 49] * bx0 + con[C_STATION + 55] * bx1 + con[C_STATION + 61] * bx2 + con[C_STATION + 67] * bx3 + con[C_STATION + 73] * bx4 + con[C_STATION + 79] * bx5, con[C_STATION + 49] * bz0 + con[C_STATION + 55] * bz1 + con[C_STATION + 61] * bz2 + con[C_STATION + 67] * bz3 + con[C_STATION + 73] * bz4 + con[C_STATION + 79] * bz5
    Y1, V1 = i_xx * X1 + i_xz * Z1, i_xz * X1 + i_zz * Z1
    b1 = -(con[C_STATION + 11] * k1 - con[C_STATION + 12] + con[C_STATION + 49] * m0 + con[C_STATION + 55] * m1 + con[C_STATION + 61] * m2 + con[C_STATION + 67] * m3 + con[C_STATION + 73] * m4 + con[C_STATION + 79] * m5 - w1 * tau + X1 * g_x + Z1 * g_z)
    X2, Z2 = con[C_STATION + 50] * bx0 + con[C_STATION + 56] * bx1 + con[C_STATION + 62] * bx2 + con[C_STATION + 68] * bx3 + con[C_STATION + 74] * bx4 + con[C_STATION + 80] * bx5, con[C_STATION + 50] * bz0 + con[C_STATION + 56] * bz1 + con[C_STATION + 62] * bz2 + con[C_STATION + 68] * bz3 + con[C_STATION + 74] * bz4 + con[C_STATION + 80] * bz5
    Y2, V2 = i_xx * X2 + i_xz * Z2, i_xz * X2 + i_zz * Z2
    b2 = -(con[C_STATION + 19] * k2 - con[C_STATION + 20] + con[C_STATION + 50] * m0 + con[C_STATION + 56] * m1 + con[C_STATION + 62] * m2 + con[C_STATION + 68] * m3 + con[C_STATION + 74] * m4 + con[C_STATION + 80] * m5 - w2 * tau + X2 * g_x + Z2 * g_z)
    X3, Z3 = con[C_STATION + 51] * bx0 + con[C_STATION + 57] * bx1 + con[C_STATION + 63] * bx2 + con[C_STATION + 69] * bx3 + con[C_STATION + 75] * bx4 + con[C_STATION + 81] * bx5, con[C_STATION + 51] * bz0 + con[C_STATION + 57] * bz1 + con[C_STATION + 63] * bz2 + con[C_STATION + 69] * bz3 + con[C_STATION + 75] * bz4 + con[C_STATION + 81] * bz5
    Y3, V3 = i_xx * X3 + i_xz * Z3, i_xz * X3 + i_zz * Z3
    b3 = -(con[C_STATION + 27] * k3 - con[C_STATION + 28] + con[C_STATION + 51] * m0 + con[C_STATION + 57] * m1 + con[C_STATION + 63] * m2 + con[C_STATION + 69] * m3 + con[C_STATION + 75] * m4 + con[C_STATION + 81] * m5 - w3 * tau + X3 * g_x + Z3 * g_z)
    X4, Z4 = con[C_STATION + 52] * bx0 + con[C_STATION + 58] * bx1 + con[C_STATION + 64] * bx2 + con[C_STATION + 70] * bx3 + con[C_STATION + 76] * bx4 + con[C_STATION + 82] * bx5, con[C_STATION + 52] * bz0 + con[C_STATION + 58] * bz1 + con[C_STATION + 64] * bz2 + con[C_STATION + 70] * bz3 + con[C_STATION + 76] * bz4 + con[C_STATION + 82] * bz5
    Y4, V4 = i_xx * X4 + i_xz * Z4, i_xz * X4 + i_zz * Z4
    b4 = -(con[C_STATION + 35] * k4 - con[C_STATION + 36] + con[C_STATION + 52] * m0 + con[C_STATION + 58] * m1 + con[C_STATION + 64] * m2 + con[C_STATION + 70] * m3 + con[C_STATION + 76] * m4 + con[C_STATION + 82] * m5 - w4 * tau + X4 * g_x + Z4 * g_z)
    X5, Z5 = con[C_STATION + 53] * bx0 + con[C_STATION + 59] * bx1 + con[C_STATION + 65] * bx2 + con[C_STATION + 71] * bx3 + con[C_STATION + 77] * bx4 + con[C_STATION + 83] * bx5, con[C_STATION + 53] * bz0 + con[C_STATION + 59] * bz1 + con[C_STATION + 65] * bz2 + con[C_STATION + 71] * bz3 + con[C_STATION + 77] * bz4 + con[C_STATION + 83] * bz5
    Y5, V5 = i_xx * X5 + i_xz * Z5, i_xz * X5 + i_zz * Z5
    b5 = -(con[C_STATION + 43] * k5 - con[C_STATION + 44] + con[C_STATION + 53] * m0 + con[C_STATION + 59] * m1 + con[C_STATION + 65] * m2 + con[C_STATION + 71] * m3 + con[C_STATION + 77] * m4 + con[C_STATION + 83] * m5 - w5 * tau + X5 * g_x + Z5 * g_z)
    b6, b7 = F_x - f_x - g_x, F_z - f_z - g_z
    # tangent by the curvatures and the tip position, lower triangle
    A0 = con[C_STATION + 48] * a0
    A1 = con[C_STATION + 54] * a1
    A2 = con[C_STATION + 60] * a2
    A3 = con[C_STATION + 66] * a3
    A4 = con[C_STATION + 72] * a4
    A5 = con[C_STATION + 78] * a5
    u0 = w0 * H_tt
    K0_0 = con[C_STATION + 3] + A0 * con[C_STATION + 48] + A1 * con[C_STATION + 54] + A2 * con[C_STATION + 60] + A3 * con[C_STATION + 66] + A4 * con[C_STATION + 72] + A5 * con[C_STATION + 78] + Y0 * X0 + V0 * Z0 + u0 * w0
    A0 = con[C_STATION + 49] * a0
    A1 = con[C_STATION + 55] * a1
    A2 = con[C_STATION + 61] * a2
    A3 = con[C_STATION + 67] * a3
    A4 = con[C_STATION + 73] * a4
    A5 = con[C_STATION + 79] * a5
    u1 = w1 * H_tt
    K1_0 = A0 * con[C_STATION + 48] + A1 * con[C_STATION + 54] + A2 * con[C_STATION + 60] + A3 * con[C_STATION + 66] + A4 * con[C_STATION + 72] + A5 * con[C_STATION + 78] + Y1 * X0 + V1 * Z0 + u1 * w0
    K1_1 = con[C_STATION + 11] + A0 * con[C_STATION + 49] + A1 * con[C_STATION + 55] + A2 * con[C_STATION + 61] + A3 * con[C_STATION + 67] + A4 * con[C_STATION + 73] + A5 * con[C_STATION + 79] + Y1 * X1 + V1 * Z1 + u1 * w1
    A0 = con[C_STATION + 50] * a0
    A1 = con[C_STATION + 56] * a1
    A2 = con[C_STATION + 62] * a2
    A3 = con[C_STATION + 68] * a3
    A4 = con[C_STATION + 74] * a4
    A5 = con[C_STATION + 80] * a5
    u2 = w2 * H_tt
    K2_0 = A0 * con[C_STATION + 48] + A1 * con[C_STATION + 54] + A2 * con[C_STATION + 60] + A3 * con[C_STATION + 66] + A4 * con[C_STATION + 72] + A5 * con[C_STATION + 78] + Y2 * X0 + V2 * Z0 + u2 * w0
    K2_1 = A0 * con[C_STATION + 49] + A1 * con[C_STATION + 55] + A2 * con[C_STATION + 61] + A3 * con[C_STATION + 67] + A4 * con[C_STATION + 73] + A5 * con[C_STATION + 79] + Y2 * X1 + V2 * Z1 + u2 * w1
    K2_2 = con[C_STATION + 19] + A0 * con[C_STATION + 50] + A1 * con[C_STATION + 56] + A2 * con[C_STATION + 62] + A3 * con[C_STATION + 68] + A4 * con[C_STATION + 74] + A5 * con[C_STATION + 80] + Y2 * X2 + V2 * Z2 + u2 * w2
    A0 = con[C_STATION + 51] * a0
    A1 = con[C_STATION + 57] * a1
    A2 = con[C_STATION + 63] * a2
    A3 = con[C_STATION + 69] * a3
    A4 = con[C_STATION + 75] * a4
    A5 = con[C_STATION + 81] * a5
    u3 = w3 * H_tt
    K3_0 = A0 * con[C_STATION + 48] + A1 * con[C_STATION + 54] + A2 * con[C_STATION + 60] + A3 * con[C_STATION + 66] + A4 * con[C_STATION + 72] + A5 * con[C_STATION + 78] + Y3 * X0 + V3 * Z0 + u3 * w0
    K3_1 = A0 * con[C_STATION + 49] + A1 * con[C_STATION + 55] + A2 * con[C_STATION + 61] + A3 * con[C_STATION + 67] + A4 * con[C_STATION + 73] + A5 * con[C_STATION + 79] + Y3 * X1 + V3 * Z1 + u3 * w1
    K3_2 = A0 * con[C_STATION + 50] + A1 * con[C_STATION + 56] + A2 * con[C_STATION + 62] + A3 * con[C_STATION + 68] + A4 * con[C_STATION + 74] + A5 * con[C_STATION + 80] + Y3 * X2 + V3 * Z2 + u3 * w2
    K3_3 = con[C_STATION + 27] + A0 * con[C_STATION + 51] + A1 * con[C_STATION + 57] + A2 * con[C_STATION + 63] + A3 * con[C_STATION + 69] + A4 * con[C_STATION + 75] + A5 * con[C_STATION + 81] + Y3 * X3 + V3 * Z3 + u3 * w3
    A0 = con[C_STATION + 52] * a0
    A1 = con[C_STATION + 58] * a1
    A2 = con[C_STATION + 64] * a2
    A3 = con[C_STATION + 70] * a3
    A4 = con[C_STATION + 76] * a4
    A5 = con[C_STATION + 82] * a5
    u4 = w4 * H_tt
    K4_0 = A0 * con[C_STATION + 48] + A1 * con[C_STATION + 54] + A2 * con[C_STATION + 60] + A3 * con[C_STATION + 66] + A4 * con[C_STATION + 72] + A5 * con[C_STATION + 78] + Y4 * X0 + V4 * Z0 + u4 * w0
    K4_1 = A0 * con[C_STATION + 49] + A1 * con[C_STATION + 55] + A2 * con[C_STATION + 61] + A3 * con[C_STATION + 67] + A4 * con[C_STATION + 73] + A5 * con[C_STATION + 79] + Y4 * X1 + V4 * Z1 + u4 * w1
    K4_2 = A0 * con[C_STATION + 50] + A1 * con[C_STATION + 56] + A2 * con[C_STATION + 62] + A3 * con[C_STATION + 68] + A4 * con[C_STATION + 74] + A5 * con[C_STATION + 80] + Y4 * X2 + V4 * Z2 + u4 * w2
    K4_3 = A0 * con[C_STATION + 51] + A1 * con[C_STATION + 57] + A2 * con[C_STATION + 63] + A3 * con[C_STATION + 69] + A4 * con[C_STATION + 75] + A5 * con[C_STATION + 81] + Y4 * X3 + V4 * Z3 + u4 * w3
    K4_4 = con[C_STATION + 35] + A0 * con[C_STATION + 52] + A1 * con[C_STATION + 58] + A2 * con[C_STATION + 64] + A3 * con[C_STATION + 70] + A4 * con[C_STATION + 76] + A5 * con[C_STATION + 82] + Y4 * X4 + V4 * Z4 + u4 * w4
    A0 = con[C_STATION + 53] * a0
    A1 = con[C_STATION + 59] * a1
    A2 = con[C_STATION + 65] * a2
    A3 = con[C_STATION + 71] * a3
    A4 = con[C_STATION + 77] * a4
    A5 = con[C_STATION + 83] * a5
    u5 = w5 * H_tt
    K5_0 = A0 * con[C_STATION + 48] + A1 * con[C_STATION + 54] + A2 * con[C_STATION + 60] + A3 * con[C_STATION + 66] + A4 * con[C_STATION + 72] + A5 * con[C_STATION + 78] + Y5 * X0 + V5 * Z0 + u5 * w0
    K5_1 = A0 * con[C_STATION + 49] + A1 * con[C_STATION + 55] + A2 * con[C_STATION + 61] + A3 * con[C_STATION + 67] + A4 * con[C_STATION + 73] + A5 * con[C_STATION + 79] + Y5 * X1 + V5 * Z1 + u5 * w1
    K5_2 = A0 * con[C_STATION + 50] + A1 * con[C_STATION + 56] + A2 * con[C_STATION + 62] + A3 * con[C_STATION + 68] + A4 * con[C_STATION + 74] + A5 * con[C_STATION + 80] + Y5 * X2 + V5 * Z2 + u5 * w2
    K5_3 = A0 * con[C_STATION + 51] + A1 * con[C_STATION + 57] + A2 * con[C_STATION + 63] + A3 * con[C_STATION + 69] + A4 * con[C_STATION + 75] + A5 * con[C_STATION + 81] + Y5 * X3 + V5 * Z3 + u5 * w3
    K5_4 = A0 * con[C_STATION + 52] + A1 * con[C_STATION + 58] + A2 * con[C_STATION + 64] + A3 * con[C_STATION + 70] + A4 * con[C_STATION + 76] + A5 * con[C_STATION + 82] + Y5 * X4 + V5 * Z4 + u5 * w4
    K5_5 = con[C_STATION + 43] + A0 * con[C_STATION + 53] + A1 * con[C_STATION + 59] + A2 * con[C_STATION + 65] + A3 * con[C_STATION + 71] + A4 * con[C_STATION + 77] + A5 * con[C_STATION + 83] + Y5 * X5 + V5 * Z5 + u5 * w5
    K6_0 = Y0 + w0 * H_xt
    K7_0 = V0 + w0 * H_zt
    K6_1 = Y1 + w1 * H_xt
    K7_1 = V1 + w1 * H_zt
    K6_2 = Y2 + w2 * H_xt
    K7_2 = V2 + w2 * H_zt
    K6_3 = Y3 + w3 * H_xt
    K7_3 = V3 + w3 * H_zt
    K6_4 = Y4 + w4 * H_xt
    K7_4 = V4 + w4 * H_zt
    K6_5 = Y5 + w5 * H_xt
    K7_5 = V5 + w5 * H_zt
    K6_6 = i_xx + H_xx
    K7_6 = i_xz + H_xz
    K7_7 = i_zz + H_zz
    # factor by blocks of two, tip position first; the pivots' signs certify stability
    pivot = state[R_PIVOT + j]
    det = K6_6 * K7_7 - K7_6 * K7_6
    inv = 1.0 / det
    I6_6, I7_6, I7_7 = K7_7 * inv, -K7_6 * inv, K6_6 * inv
    pivot = K6_6 if K6_6 < pivot else pivot
    pivot = det if det < pivot else pivot
    L0_6 = K6_0 * I6_6 + K7_0 * I7_6
    L0_7 = K6_0 * I7_6 + K7_0 * I7_7
    L1_6 = K6_1 * I6_6 + K7_1 * I7_6
    L1_7 = K6_1 * I7_6 + K7_1 * I7_7
    L2_6 = K6_2 * I6_6 + K7_2 * I7_6
    L2_7 = K6_2 * I7_6 + K7_2 * I7_7
    L3_6 = K6_3 * I6_6 + K7_3 * I7_6
    L3_7 = K6_3 * I7_6 + K7_3 * I7_7
    L4_6 = K6_4 * I6_6 + K7_4 * I7_6
    L4_7 = K6_4 * I7_6 + K7_4 * I7_7
    L5_6 = K6_5 * I6_6 + K7_5 * I7_6
    L5_7 = K6_5 * I7_6 + K7_5 * I7_7
    K0_0 = K0_0 - L0_6 * K6_0 - L0_7 * K7_0
    b0 = b0 - L0_6 * b6 - L0_7 * b7
    K1_0 = K1_0 - L1_6 * K6_0 - L1_7 * K7_0
    K1_1 = K1_1 - L1_6 * K6_1 - L1_7 * K7_1
    b1 = b1 - L1_6 * b6 - L1_7 * b7
    K2_0 = K2_0 - L2_6 * K6_0 - L2_7 * K7_0
    K2_1 = K2_1 - L2_6 * K6_1 - L2_7 * K7_1
    K2_2 = K2_2 - L2_6 * K6_2 - L2_7 * K7_2
    b2 = b2 - L2_6 * b6 - L2_7 * b7
    K3_0 = K3_0 - L3_6 * K6_0 - L3_7 * K7_0
    K3_1 = K3_1 - L3_6 * K6_1 - L3_7 * K7_1
    K3_2 = K3_2 - L3_6 * K6_2 - L3_7 * K7_2
    K3_3 = K3_3 - L3_6 * K6_3 - L3_7 * K7_3
    b3 = b3 - L3_6 * b6 - L3_7 * b7
    K4_0 = K4_0 - L4_6 * K6_0 - L4_7 * K7_0
    K4_1 = K4_1 - L4_6 * K6_1 - L4_7 * K7_1
    K4_2 = K4_2 - L4_6 * K6_2 - L4_7 * K7_2
    K4_3 = K4_3 - L4_6 * K6_3 - L4_7 * K7_3
    K4_4 = K4_4 - L4_6 * K6_4 - L4_7 * K7_4
    b4 = b4 - L4_6 * b6 - L4_7 * b7
    K5_0 = K5_0 - L5_6 * K6_0 - L5_7 * K7_0
    K5_1 = K5_1 - L5_6 * K6_1 - L5_7 * K7_1
    K5_2 = K5_2 - L5_6 * K6_2 - L5_7 * K7_2
    K5_3 = K5_3 - L5_6 * K6_3 - L5_7 * K7_3
    K5_4 = K5_4 - L5_6 * K6_4 - L5_7 * K7_4
    K5_5 = K5_5 - L5_6 * K6_5 - L5_7 * K7_5
    b5 = b5 - L5_6 * b6 - L5_7 * b7
    det = K0_0 * K1_1 - K1_0 * K1_0
    inv = 1.0 / det
    I0_0, I1_0, I1_1 = K1_1 * inv, -K1_0 * inv, K0_0 * inv
    pivot = K0_0 if K0_0 < pivot else pivot
    pivot = det if det < pivot else pivot
    L2_0 = K2_0 * I0_0 + K2_1 * I1_0
    L2_1 = K2_0 * I1_0 + K2_1 * I1_1
    L3_0 = K3_0 * I0_0 + K3_1 * I1_0
    L3_1 = K3_0 * I1_0 + K3_1 * I1_1
    L4_0 = K4_0 * I0_0 + K4_1 * I1_0
    L4_1 = K4_0 * I1_0 + K4_1 * I1_1
    L5_0 = K5_0 * I0_0 + K5_1 * I1_0
    L5_1 = K5_0 * I1_0 + K5_1 * I1_1
    K2_2 = K2_2 - L2_0 * K2_0 - L2_1 * K2_1
    b2 = b2 - L2_0 * b0 - L2_1 * b1
    K3_2 = K3_2 - L3_0 * K2_0 - L3_1 * K2_1
    K3_3 = K3_3 - L3_0 * K3_0 - L3_1 * K3_1
    b3 = b3 - L3_0 * b0 - L3_1 * b1
    K4_2 = K4_2 - L4_0 * K2_0 - L4_1 * K2_1
    K4_3 = K4_3 - L4_0 * K3_0 - L4_1 * K3_1
    K4_4 = K4_4 - L4_0 * K4_0 - L4_1 * K4_1
    b4 = b4 - L4_0 * b0 - L4_1 * b1
    K5_2 = K5_2 - L5_0 * K2_0 - L5_1 * K2_1
    K5_3 = K5_3 - L5_0 * K3_0 - L5_1 * K3_1
    K5_4 = K5_4 - L5_0 * K4_0 - L5_1 * K4_1
    K5_5 = K5_5 - L5_0 * K5_0 - L5_1 * K5_1
    b5 = b5 - L5_0 * b0 - L5_1 * b1
    det = K2_2 * K3_3 - K3_2 * K3_2
    inv = 1.0 / det
    I2_2, I3_2, I3_3 = K3_3 * inv, -K3_2 * inv, K2_2 * inv
    pivot = K2_2 if K2_2 < pivot else pivot
    pivot = det if det < pivot else pivot
    L4_2 = K4_2 * I2_2 + K4_3 * I3_2
    L4_3 = K4_2 * I3_2 + K4_3 * I3_3
    L5_2 = K5_2 * I2_2 + K5_3 * I3_2
    L5_3 = K5_2 * I3_2 + K5_3 * I3_3
    K4_4 = K4_4 - L4_2 * K4_2 - L4_3 * K4_3
    b4 = b4 - L4_2 * b2 - L4_3 * b3
    K5_4 = K5_4 - L5_2 * K4_2 - L5_3 * K4_3
    K5_5 = K5_5 - L5_2 * K5_2 - L5_3 * K5_3
    b5 = b5 - L5_2 * b2 - L5_3 * b3
    det = K4_4 * K5_5 - K5_4 * K5_4
    inv = 1.0 / det
    I4_4, I5_4, I5_5 = K5_5 * inv, -K5_4 * inv, K4_4 * inv
    pivot = K4_4 if K4_4 < pivot else pivot
    pivot = det if det < pivot else pivot
    b4, b5 = I4_4 * b4 + I5_4 * b5, I5_4 * b4 + I5_5 * b5
    b2, b3 = I2_2 * b2 + I3_2 * b3 - L4_2 * b4 - L5_2 * b5, I3_2 * b2 + I3_3 * b3 - L4_3 * b4 - L5_3 * b5
    b0, b1 = I0_0 * b0 + I1_0 * b1 - L2_0 * b2 - L3_0 * b3 - L4_0 * b4 - L5_0 * b5, I1_0 * b0 + I1_1 * b1 - L2_1 * b2 - L3_1 * b3 - L4_1 * b4 - L5_1 * b5
    b6, b7 = I6_6 * b6 + I7_6 * b7 - L0_6 * b0 - L1_6 * b1 - L2_6 * b2 - L3_6 * b3 - L4_6 * b4 - L5_6 * b5, I7_6 * b6 + I7_7 * b7 - L0_7 * b0 - L1_7 * b1 - L2_7 * b2 - L3_7 * b3 - L4_7 * b4 - L5_7 * b5
    # step, and the tip force that goes with it
    step_x = b6 + gap_x + X0 * b0 + X1 * b1 + X2 * b2 + X3 * b3 + X4 * b4 + X5 * b5
    step_z = b7 + gap_z + Z0 * b0 + Z1 * b1 + Z2 * b2 + Z3 * b3 + Z4 * b4 + Z5 * b5
    state[R_KAPPA + 0 * LANES + j] = k0 + b0
    state[R_KAPPA + 1 * LANES + j] = k1 + b1
    state[R_KAPPA + 2 * LANES + j] = k2 + b2
    state[R_KAPPA + 3 * LANES + j] = k3 + b3
    state[R_KAPPA + 4 * LANES + j] = k4 + b4
    state[R_KAPPA + 5 * LANES + j] = k5 + b5
    state[R_X + j] = x + b6
    state[R_Z + j] = z + b7
    b_x, b_z = i_xx * step_x + i_xz * step_z, i_xz * step_x + i_zz * step_z
    state[R_FORCE_X + j] = f_x + b_x
    state[R_FORCE_Z + j] = f_z + b_z
    turned = w0 * b0 + w1 * b1 + w2 * b2 + w3 * b3 + w4 * b4 + w5 * b5
    state[R_THETA + j] = t_tip + turned
    # squared size of the step: turns in rad, positions as shares of the length, and the tip force
    size = (w0 * b0) * (w0 * b0) + (w1 * b1) * (w1 * b1) + (w2 * b2) * (w2 * b2) + (w3 * b3) * (w3 * b3) + (w4 * b4) * (w4 * b4) + (w5 * b5) * (w5 * b5) + (b6 * b6 + b7 * b7) * con[C_INV_LENGTH2] + (b_x * b_x + b_z * b_z) * con[C_INV_FORCE2] + turned * turned
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
