"""The condensed formulation for one element of order 6, written out. Do not edit.

Written by `tools/write_condensed.py`; the formulation is explained in `condensed`.
"""

import numpy as np

from .._jit import array_at, kernel, step_kernel, wide
from ..layout import (
    CONVERGED,
    LANES,
    NOT_CONVERGED,
    R_EXTREME,
    R_LAM_L,
    R_LAM_R,
    R_THETA,
    R_X,
    R_Z,
)
from ..prepare import prepare
from .control_step import rescue, unfold
from .formulation import MAX_STEPS, collect, condense, judge, nodes_of, put_load, settled, straighten, vouches
from .initial_guess import extrapolate, guess, lane_inside, lanes_inside, remember
from .physics import plate, section

__all__ = ["advance", "solve_loads", "solve_mechanisms", "solve_nodes", "sweep", "sweep_mechanisms"]

ORDER = 6


@step_kernel
def assemble(con, cr, cl, state, sr, j):
    """Equations for the angles alone, see `condensed`."""
    c_xx = state[sr * 35 + j] + state[sr * 45 + j] + state[sr * 55 + j] + state[sr * 65 + j] + state[sr * 75 + j] + state[sr * 85 + j]
    c_xz = state[sr * 36 + j] + state[sr * 46 + j] + state[sr * 56 + j] + state[sr * 66 + j] + state[sr * 76 + j] + state[sr * 86 + j]
    c_zz = state[sr * 37 + j] + state[sr * 47 + j] + state[sr * 57 + j] + state[sr * 67 + j] + state[sr * 77 + j] + state[sr * 87 + j]
    c_dx = state[sr * 33 + j] + state[sr * 43 + j] + state[sr * 53 + j] + state[sr * 63 + j] + state[sr * 73 + j] + state[sr * 83 + j]
    c_dz = state[sr * 34 + j] + state[sr * 44 + j] + state[sr * 54 + j] + state[sr * 64 + j] + state[sr * 74 + j] + state[sr * 84 + j]
    X0 = state[sr * 31 + j]
    X1 = state[sr * 41 + j]
    X2 = state[sr * 51 + j]
    X3 = state[sr * 61 + j]
    X4 = state[sr * 71 + j]
    X5 = state[sr * 81 + j]
    Z0 = state[sr * 32 + j]
    Z1 = state[sr * 42 + j]
    Z2 = state[sr * 52 + j]
    Z3 = state[sr * 62 + j]
    Z4 = state[sr * 72 + j]
    Z5 = state[sr * 82 + j]
    o0 = state[sr * 28 + j]
    o1 = state[sr * 38 + j]
    o2 = state[sr * 48 + j]
    o3 = state[sr * 58 + j]
    o4 = state[sr * 68 + j]
    o5 = state[sr * 78 + j]
    t0 = con[cr * 78 + cl]
    t1 = con[cr * 86 + cl]
    t2 = con[cr * 94 + cl]
    t3 = con[cr * 102 + cl]
    t4 = con[cr * 110 + cl]
    t5 = con[cr * 118 + cl]
    h_xx = state[sr * 16 + j]
    h_xz = state[sr * 17 + j]
    h_zz = state[sr * 18 + j]
    h_xt = state[sr * 19 + j]
    h_zt = state[sr * 20 + j]
    h_tt = state[sr * 21 + j]
    gap_x, gap_z = state[sr * 5 + j] - c_dx, state[sr * 6 + j] - c_dz
    e_x, e_z = state[sr * 13 + j] - state[sr * 7 + j], state[sr * 14 + j] - state[sr * 8 + j]
    m_xx, m_xz = 1.0 + h_xx * c_xx + h_xz * c_xz, h_xx * c_xz + h_xz * c_zz
    m_zx, m_zz = h_xz * c_xx + h_zz * c_xz, 1.0 + h_xz * c_xz + h_zz * c_zz
    pivot = m_xx * m_zz - m_xz * m_zx
    inv = 1.0 / pivot
    pivot = m_xx + m_zz if m_xx + m_zz < pivot else pivot
    j_xx, j_xz, j_zx, j_zz = m_zz * inv, -m_xz * inv, -m_zx * inv, m_xx * inv
    s_xx, s_xz, s_zz = j_xx * h_xx + j_xz * h_xz, j_xx * h_xz + j_xz * h_zz, j_zx * h_xz + j_zz * h_zz
    g_x, g_z = j_xx * h_xt + j_xz * h_zt, j_zx * h_xt + j_zz * h_zt
    q_x, q_z = c_xx * e_x + c_xz * e_z - gap_x, c_xz * e_x + c_zz * e_z - gap_z
    g_tt = h_tt - h_xt * (c_xx * g_x + c_xz * g_z) - h_zt * (c_xz * g_x + c_zz * g_z)
    p_x = j_xx * e_x + j_xz * e_z + s_xx * gap_x + s_xz * gap_z
    p_z = j_zx * e_x + j_zz * e_z + s_xz * gap_x + s_zz * gap_z
    pull = state[sr * 15 + j] - g_x * q_x - g_z * q_z
    state[sr * 11 + j] = pivot if pivot < state[sr * 11 + j] else state[sr * 11 + j]
    state[sr * 13 + j], state[sr * 14 + j] = e_x, e_z
    state[sr * 109 + j] = c_xx
    state[sr * 110 + j] = c_xz
    state[sr * 111 + j] = c_zz
    state[sr * 112 + j] = j_xx
    state[sr * 113 + j] = j_xz
    state[sr * 114 + j] = j_zx
    state[sr * 115 + j] = j_zz
    state[sr * 116 + j] = g_x
    state[sr * 117 + j] = g_z
    state[sr * 118 + j] = gap_x
    state[sr * 119 + j] = gap_z
    state[sr * 30 + j] = t0 * pull - (con[cr * 119 + cl] * o0 + con[cr * 120 + cl] * o1 + con[cr * 122 + cl] * o2 + con[cr * 125 + cl] * o3 + con[cr * 129 + cl] * o4 + con[cr * 134 + cl] * o5 - con[cr * 77 + cl] + state[sr * 30 + j]) - X0 * p_x - Z0 * p_z
    state[sr * 40 + j] = t1 * pull - (con[cr * 120 + cl] * o0 + con[cr * 121 + cl] * o1 + con[cr * 123 + cl] * o2 + con[cr * 126 + cl] * o3 + con[cr * 130 + cl] * o4 + con[cr * 135 + cl] * o5 - con[cr * 85 + cl] + state[sr * 40 + j]) - X1 * p_x - Z1 * p_z
    state[sr * 50 + j] = t2 * pull - (con[cr * 122 + cl] * o0 + con[cr * 123 + cl] * o1 + con[cr * 124 + cl] * o2 + con[cr * 127 + cl] * o3 + con[cr * 131 + cl] * o4 + con[cr * 136 + cl] * o5 - con[cr * 93 + cl] + state[sr * 50 + j]) - X2 * p_x - Z2 * p_z
    state[sr * 60 + j] = t3 * pull - (con[cr * 125 + cl] * o0 + con[cr * 126 + cl] * o1 + con[cr * 127 + cl] * o2 + con[cr * 128 + cl] * o3 + con[cr * 132 + cl] * o4 + con[cr * 137 + cl] * o5 - con[cr * 101 + cl] + state[sr * 60 + j]) - X3 * p_x - Z3 * p_z
    state[sr * 70 + j] = t4 * pull - (con[cr * 129 + cl] * o0 + con[cr * 130 + cl] * o1 + con[cr * 131 + cl] * o2 + con[cr * 132 + cl] * o3 + con[cr * 133 + cl] * o4 + con[cr * 138 + cl] * o5 - con[cr * 109 + cl] + state[sr * 70 + j]) - X4 * p_x - Z4 * p_z
    state[sr * 80 + j] = t5 * pull - (con[cr * 134 + cl] * o0 + con[cr * 135 + cl] * o1 + con[cr * 136 + cl] * o2 + con[cr * 137 + cl] * o3 + con[cr * 138 + cl] * o4 + con[cr * 139 + cl] * o5 - con[cr * 117 + cl] + state[sr * 80 + j]) - X5 * p_x - Z5 * p_z
    U0 = s_xx * X0 + s_xz * Z0 - g_x * t0
    V0 = s_xz * X0 + s_zz * Z0 - g_z * t0
    T0 = g_tt * t0 - g_x * X0 - g_z * Z0
    state[sr * 88 + j] = con[cr * 119 + cl] + U0 * X0 + V0 * Z0 + T0 * t0 + state[sr * 29 + j]
    U1 = s_xx * X1 + s_xz * Z1 - g_x * t1
    V1 = s_xz * X1 + s_zz * Z1 - g_z * t1
    T1 = g_tt * t1 - g_x * X1 - g_z * Z1
    state[sr * 89 + j] = con[cr * 120 + cl] + U1 * X0 + V1 * Z0 + T1 * t0
    state[sr * 90 + j] = con[cr * 121 + cl] + U1 * X1 + V1 * Z1 + T1 * t1 + state[sr * 39 + j]
    U2 = s_xx * X2 + s_xz * Z2 - g_x * t2
    V2 = s_xz * X2 + s_zz * Z2 - g_z * t2
    T2 = g_tt * t2 - g_x * X2 - g_z * Z2
    state[sr * 91 + j] = con[cr * 122 + cl] + U2 * X0 + V2 * Z0 + T2 * t0
    state[sr * 92 + j] = con[cr * 123 + cl] + U2 * X1 + V2 * Z1 + T2 * t1
    state[sr * 93 + j] = con[cr * 124 + cl] + U2 * X2 + V2 * Z2 + T2 * t2 + state[sr * 49 + j]
    U3 = s_xx * X3 + s_xz * Z3 - g_x * t3
    V3 = s_xz * X3 + s_zz * Z3 - g_z * t3
    T3 = g_tt * t3 - g_x * X3 - g_z * Z3
    state[sr * 94 + j] = con[cr * 125 + cl] + U3 * X0 + V3 * Z0 + T3 * t0
    state[sr * 95 + j] = con[cr * 126 + cl] + U3 * X1 + V3 * Z1 + T3 * t1
    state[sr * 96 + j] = con[cr * 127 + cl] + U3 * X2 + V3 * Z2 + T3 * t2
    state[sr * 97 + j] = con[cr * 128 + cl] + U3 * X3 + V3 * Z3 + T3 * t3 + state[sr * 59 + j]
    U4 = s_xx * X4 + s_xz * Z4 - g_x * t4
    V4 = s_xz * X4 + s_zz * Z4 - g_z * t4
    T4 = g_tt * t4 - g_x * X4 - g_z * Z4
    state[sr * 98 + j] = con[cr * 129 + cl] + U4 * X0 + V4 * Z0 + T4 * t0
    state[sr * 99 + j] = con[cr * 130 + cl] + U4 * X1 + V4 * Z1 + T4 * t1
    state[sr * 100 + j] = con[cr * 131 + cl] + U4 * X2 + V4 * Z2 + T4 * t2
    state[sr * 101 + j] = con[cr * 132 + cl] + U4 * X3 + V4 * Z3 + T4 * t3
    state[sr * 102 + j] = con[cr * 133 + cl] + U4 * X4 + V4 * Z4 + T4 * t4 + state[sr * 69 + j]
    U5 = s_xx * X5 + s_xz * Z5 - g_x * t5
    V5 = s_xz * X5 + s_zz * Z5 - g_z * t5
    T5 = g_tt * t5 - g_x * X5 - g_z * Z5
    state[sr * 103 + j] = con[cr * 134 + cl] + U5 * X0 + V5 * Z0 + T5 * t0
    state[sr * 104 + j] = con[cr * 135 + cl] + U5 * X1 + V5 * Z1 + T5 * t1
    state[sr * 105 + j] = con[cr * 136 + cl] + U5 * X2 + V5 * Z2 + T5 * t2
    state[sr * 106 + j] = con[cr * 137 + cl] + U5 * X3 + V5 * Z3 + T5 * t3
    state[sr * 107 + j] = con[cr * 138 + cl] + U5 * X4 + V5 * Z4 + T5 * t4
    state[sr * 108 + j] = con[cr * 139 + cl] + U5 * X5 + V5 * Z5 + T5 * t5 + state[sr * 79 + j]


@step_kernel
def solve(con, cr, cl, state, sr, j, keep):
    """Solve for the angles, and take the step."""
    b0 = state[sr * 30 + j]
    b1 = state[sr * 40 + j]
    b2 = state[sr * 50 + j]
    b3 = state[sr * 60 + j]
    b4 = state[sr * 70 + j]
    b5 = state[sr * 80 + j]
    K0_0 = state[sr * 88 + j]
    K1_0 = state[sr * 89 + j]
    K1_1 = state[sr * 90 + j]
    K2_0 = state[sr * 91 + j]
    K2_1 = state[sr * 92 + j]
    K2_2 = state[sr * 93 + j]
    K3_0 = state[sr * 94 + j]
    K3_1 = state[sr * 95 + j]
    K3_2 = state[sr * 96 + j]
    K3_3 = state[sr * 97 + j]
    K4_0 = state[sr * 98 + j]
    K4_1 = state[sr * 99 + j]
    K4_2 = state[sr * 100 + j]
    K4_3 = state[sr * 101 + j]
    K4_4 = state[sr * 102 + j]
    K5_0 = state[sr * 103 + j]
    K5_1 = state[sr * 104 + j]
    K5_2 = state[sr * 105 + j]
    K5_3 = state[sr * 106 + j]
    K5_4 = state[sr * 107 + j]
    K5_5 = state[sr * 108 + j]
    pivot = state[sr * 11 + j]
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
    if keep:
        state[sr * 88 + j] = I0_0
        state[sr * 89 + j] = I1_0
        state[sr * 90 + j] = I1_1
        state[sr * 91 + j] = L2_0
        state[sr * 92 + j] = L2_1
        state[sr * 93 + j] = I2_2
        state[sr * 94 + j] = L3_0
        state[sr * 95 + j] = L3_1
        state[sr * 96 + j] = I3_2
        state[sr * 97 + j] = I3_3
        state[sr * 98 + j] = L4_0
        state[sr * 99 + j] = L4_1
        state[sr * 100 + j] = L4_2
        state[sr * 101 + j] = L4_3
        state[sr * 102 + j] = I4_4
        state[sr * 103 + j] = L5_0
        state[sr * 104 + j] = L5_1
        state[sr * 105 + j] = L5_2
        state[sr * 106 + j] = L5_3
        state[sr * 107 + j] = I5_4
        state[sr * 108 + j] = I5_5
    X0 = state[sr * 31 + j]
    X1 = state[sr * 41 + j]
    X2 = state[sr * 51 + j]
    X3 = state[sr * 61 + j]
    X4 = state[sr * 71 + j]
    X5 = state[sr * 81 + j]
    Z0 = state[sr * 32 + j]
    Z1 = state[sr * 42 + j]
    Z2 = state[sr * 52 + j]
    Z3 = state[sr * 62 + j]
    Z4 = state[sr * 72 + j]
    Z5 = state[sr * 82 + j]
    o0 = state[sr * 28 + j]
    o1 = state[sr * 38 + j]
    o2 = state[sr * 48 + j]
    o3 = state[sr * 58 + j]
    o4 = state[sr * 68 + j]
    o5 = state[sr * 78 + j]
    t0 = con[cr * 78 + cl]
    t1 = con[cr * 86 + cl]
    t2 = con[cr * 94 + cl]
    t3 = con[cr * 102 + cl]
    t4 = con[cr * 110 + cl]
    t5 = con[cr * 118 + cl]
    h_xx = state[sr * 16 + j]
    h_xz = state[sr * 17 + j]
    h_zz = state[sr * 18 + j]
    h_xt = state[sr * 19 + j]
    h_zt = state[sr * 20 + j]
    c_xx = state[sr * 109 + j]
    c_xz = state[sr * 110 + j]
    c_zz = state[sr * 111 + j]
    j_xx = state[sr * 112 + j]
    j_xz = state[sr * 113 + j]
    j_zx = state[sr * 114 + j]
    j_zz = state[sr * 115 + j]
    gap_x = state[sr * 118 + j]
    gap_z = state[sr * 119 + j]
    e_x, e_z = state[sr * 13 + j], state[sr * 14 + j]
    turned = t0 * b0 + t1 * b1 + t2 * b2 + t3 * b3 + t4 * b4 + t5 * b5
    e_x, e_z = e_x - h_xt * turned, e_z - h_zt * turned
    q_x = c_xx * e_x + c_xz * e_z - gap_x - (X0 * b0 + X1 * b1 + X2 * b2 + X3 * b3 + X4 * b4 + X5 * b5)
    q_z = c_xz * e_x + c_zz * e_z - gap_z - (Z0 * b0 + Z1 * b1 + Z2 * b2 + Z3 * b3 + Z4 * b4 + Z5 * b5)
    d_x, d_z = j_xx * q_x + j_zx * q_z, j_xz * q_x + j_zz * q_z
    f_x, f_z = e_x - h_xx * d_x - h_xz * d_z, e_z - h_xz * d_x - h_zz * d_z
    o0 = o0 + b0
    state[sr * 28 + j] = o0
    o1 = o1 + b1
    state[sr * 38 + j] = o1
    o2 = o2 + b2
    state[sr * 48 + j] = o2
    o3 = o3 + b3
    state[sr * 58 + j] = o3
    o4 = o4 + b4
    state[sr * 68 + j] = o4
    o5 = o5 + b5
    state[sr * 78 + j] = o5
    state[sr * 9 + j] = con[cr * 45 + cl] + t0 * o0 + t1 * o1 + t2 * o2 + t3 * o3 + t4 * o4 + t5 * o5
    state[sr * 5 + j] = state[sr * 5 + j] + d_x
    state[sr * 6 + j] = state[sr * 6 + j] + d_z
    state[sr * 7 + j] = state[sr * 7 + j] + f_x
    state[sr * 8 + j] = state[sr * 8 + j] + f_z
    size = b0 * b0 + b1 * b1 + b2 * b2 + b3 * b3 + b4 * b4 + b5 * b5 + turned * turned + (d_x * d_x + d_z * d_z) * con[cr * 46 + cl] + (f_x * f_x + f_z * f_z) * con[cr * 47 + cl]
    judge(state, sr, j, pivot, size)


@step_kernel
def tip_columns(con, state, compliance):
    """Compliance at Q, lower triangle xx, zx, zz, tx, tz, tt, from the factor that a step with `keep` left."""
    cr, cl, sr, j = 1, 0, 1, 0
    X0 = state[sr * 31 + j]
    X1 = state[sr * 41 + j]
    X2 = state[sr * 51 + j]
    X3 = state[sr * 61 + j]
    X4 = state[sr * 71 + j]
    X5 = state[sr * 81 + j]
    Z0 = state[sr * 32 + j]
    Z1 = state[sr * 42 + j]
    Z2 = state[sr * 52 + j]
    Z3 = state[sr * 62 + j]
    Z4 = state[sr * 72 + j]
    Z5 = state[sr * 82 + j]
    t0 = con[cr * 78 + cl]
    I0_0 = state[sr * 88 + j]
    t1 = con[cr * 86 + cl]
    I1_0 = state[sr * 89 + j]
    I1_1 = state[sr * 90 + j]
    t2 = con[cr * 94 + cl]
    L2_0 = state[sr * 91 + j]
    L2_1 = state[sr * 92 + j]
    I2_2 = state[sr * 93 + j]
    t3 = con[cr * 102 + cl]
    L3_0 = state[sr * 94 + j]
    L3_1 = state[sr * 95 + j]
    I3_2 = state[sr * 96 + j]
    I3_3 = state[sr * 97 + j]
    t4 = con[cr * 110 + cl]
    L4_0 = state[sr * 98 + j]
    L4_1 = state[sr * 99 + j]
    L4_2 = state[sr * 100 + j]
    L4_3 = state[sr * 101 + j]
    I4_4 = state[sr * 102 + j]
    t5 = con[cr * 118 + cl]
    L5_0 = state[sr * 103 + j]
    L5_1 = state[sr * 104 + j]
    L5_2 = state[sr * 105 + j]
    L5_3 = state[sr * 106 + j]
    I5_4 = state[sr * 107 + j]
    I5_5 = state[sr * 108 + j]
    c_xx = state[sr * 109 + j]
    c_xz = state[sr * 110 + j]
    c_zz = state[sr * 111 + j]
    j_xx = state[sr * 112 + j]
    j_xz = state[sr * 113 + j]
    j_zx = state[sr * 114 + j]
    j_zz = state[sr * 115 + j]
    g_x = state[sr * 116 + j]
    g_z = state[sr * 117 + j]
    h_xt, h_zt = state[sr * 19 + j], state[sr * 20 + j]
    b0 = -j_xx * X0 - j_zx * Z0 - (g_x * c_xx + g_z * c_xz) * t0
    b1 = -j_xx * X1 - j_zx * Z1 - (g_x * c_xx + g_z * c_xz) * t1
    b2 = -j_xx * X2 - j_zx * Z2 - (g_x * c_xx + g_z * c_xz) * t2
    b3 = -j_xx * X3 - j_zx * Z3 - (g_x * c_xx + g_z * c_xz) * t3
    b4 = -j_xx * X4 - j_zx * Z4 - (g_x * c_xx + g_z * c_xz) * t4
    b5 = -j_xx * X5 - j_zx * Z5 - (g_x * c_xx + g_z * c_xz) * t5
    b2 = b2 - L2_0 * b0 - L2_1 * b1
    b3 = b3 - L3_0 * b0 - L3_1 * b1
    b4 = b4 - L4_0 * b0 - L4_1 * b1
    b5 = b5 - L5_0 * b0 - L5_1 * b1
    b4 = b4 - L4_2 * b2 - L4_3 * b3
    b5 = b5 - L5_2 * b2 - L5_3 * b3
    b4, b5 = I4_4 * b4 + I5_4 * b5, I5_4 * b4 + I5_5 * b5
    b2, b3 = I2_2 * b2 + I3_2 * b3 - L4_2 * b4 - L5_2 * b5, I3_2 * b2 + I3_3 * b3 - L4_3 * b4 - L5_3 * b5
    b0, b1 = I0_0 * b0 + I1_0 * b1 - L2_0 * b2 - L3_0 * b3 - L4_0 * b4 - L5_0 * b5, I1_0 * b0 + I1_1 * b1 - L2_1 * b2 - L3_1 * b3 - L4_1 * b4 - L5_1 * b5
    turned = t0 * b0 + t1 * b1 + t2 * b2 + t3 * b3 + t4 * b4 + t5 * b5
    e_x, e_z = 1.0 - h_xt * turned, 0.0 - h_zt * turned
    q_x = c_xx * e_x + c_xz * e_z - (X0 * b0 + X1 * b1 + X2 * b2 + X3 * b3 + X4 * b4 + X5 * b5)
    q_z = c_xz * e_x + c_zz * e_z - (Z0 * b0 + Z1 * b1 + Z2 * b2 + Z3 * b3 + Z4 * b4 + Z5 * b5)
    d_x, d_z = j_xx * q_x + j_zx * q_z, j_xz * q_x + j_zz * q_z
    compliance[0] = d_x
    compliance[1] = d_z
    compliance[3] = turned
    b0 = -j_xz * X0 - j_zz * Z0 - (g_x * c_xz + g_z * c_zz) * t0
    b1 = -j_xz * X1 - j_zz * Z1 - (g_x * c_xz + g_z * c_zz) * t1
    b2 = -j_xz * X2 - j_zz * Z2 - (g_x * c_xz + g_z * c_zz) * t2
    b3 = -j_xz * X3 - j_zz * Z3 - (g_x * c_xz + g_z * c_zz) * t3
    b4 = -j_xz * X4 - j_zz * Z4 - (g_x * c_xz + g_z * c_zz) * t4
    b5 = -j_xz * X5 - j_zz * Z5 - (g_x * c_xz + g_z * c_zz) * t5
    b2 = b2 - L2_0 * b0 - L2_1 * b1
    b3 = b3 - L3_0 * b0 - L3_1 * b1
    b4 = b4 - L4_0 * b0 - L4_1 * b1
    b5 = b5 - L5_0 * b0 - L5_1 * b1
    b4 = b4 - L4_2 * b2 - L4_3 * b3
    b5 = b5 - L5_2 * b2 - L5_3 * b3
    b4, b5 = I4_4 * b4 + I5_4 * b5, I5_4 * b4 + I5_5 * b5
    b2, b3 = I2_2 * b2 + I3_2 * b3 - L4_2 * b4 - L5_2 * b5, I3_2 * b2 + I3_3 * b3 - L4_3 * b4 - L5_3 * b5
    b0, b1 = I0_0 * b0 + I1_0 * b1 - L2_0 * b2 - L3_0 * b3 - L4_0 * b4 - L5_0 * b5, I1_0 * b0 + I1_1 * b1 - L2_1 * b2 - L3_1 * b3 - L4_1 * b4 - L5_1 * b5
    turned = t0 * b0 + t1 * b1 + t2 * b2 + t3 * b3 + t4 * b4 + t5 * b5
    e_x, e_z = 0.0 - h_xt * turned, 1.0 - h_zt * turned
    q_x = c_xx * e_x + c_xz * e_z - (X0 * b0 + X1 * b1 + X2 * b2 + X3 * b3 + X4 * b4 + X5 * b5)
    q_z = c_xz * e_x + c_zz * e_z - (Z0 * b0 + Z1 * b1 + Z2 * b2 + Z3 * b3 + Z4 * b4 + Z5 * b5)
    d_x, d_z = j_xx * q_x + j_zx * q_z, j_xz * q_x + j_zz * q_z
    compliance[2] = d_z
    compliance[4] = turned
    b0 = t0
    b1 = t1
    b2 = t2
    b3 = t3
    b4 = t4
    b5 = t5
    b2 = b2 - L2_0 * b0 - L2_1 * b1
    b3 = b3 - L3_0 * b0 - L3_1 * b1
    b4 = b4 - L4_0 * b0 - L4_1 * b1
    b5 = b5 - L5_0 * b0 - L5_1 * b1
    b4 = b4 - L4_2 * b2 - L4_3 * b3
    b5 = b5 - L5_2 * b2 - L5_3 * b3
    b4, b5 = I4_4 * b4 + I5_4 * b5, I5_4 * b4 + I5_5 * b5
    b2, b3 = I2_2 * b2 + I3_2 * b3 - L4_2 * b4 - L5_2 * b5, I3_2 * b2 + I3_3 * b3 - L4_3 * b4 - L5_3 * b5
    b0, b1 = I0_0 * b0 + I1_0 * b1 - L2_0 * b2 - L3_0 * b3 - L4_0 * b4 - L5_0 * b5, I1_0 * b0 + I1_1 * b1 - L2_1 * b2 - L3_1 * b3 - L4_1 * b4 - L5_1 * b5
    turned = t0 * b0 + t1 * b1 + t2 * b2 + t3 * b3 + t4 * b4 + t5 * b5
    e_x, e_z = 0.0 - h_xt * turned, 0.0 - h_zt * turned
    q_x = c_xx * e_x + c_xz * e_z - (X0 * b0 + X1 * b1 + X2 * b2 + X3 * b3 + X4 * b4 + X5 * b5)
    q_z = c_xz * e_x + c_zz * e_z - (Z0 * b0 + Z1 * b1 + Z2 * b2 + Z3 * b3 + Z4 * b4 + Z5 * b5)
    d_x, d_z = j_xx * q_x + j_zx * q_z, j_xz * q_x + j_zz * q_z
    compliance[5] = turned


@step_kernel
def step(con, state, keep):
    """Take one Newton step for the one load case that `state` holds; with `keep`, leave the factor to `tip_columns`."""
    section(con, 1, 0, state, 1, 0, 0)
    section(con, 1, 0, state, 1, 0, 1)
    section(con, 1, 0, state, 1, 0, 2)
    section(con, 1, 0, state, 1, 0, 3)
    section(con, 1, 0, state, 1, 0, 4)
    section(con, 1, 0, state, 1, 0, 5)
    plate(con, 1, 0, state, 1, 0)
    assemble(con, 1, 0, state, 1, 0)
    solve(con, 1, 0, state, 1, 0, keep)


@step_kernel
def _sweep(con, cr, own, state):
    wide()
    # one loop after the other: each body fits the window in which a processor reorders instructions
    for j in range(LANES):
        section(con, cr, own * j, state, LANES, j, 0)
    for j in range(LANES):
        section(con, cr, own * j, state, LANES, j, 1)
    for j in range(LANES):
        section(con, cr, own * j, state, LANES, j, 2)
    for j in range(LANES):
        section(con, cr, own * j, state, LANES, j, 3)
    for j in range(LANES):
        section(con, cr, own * j, state, LANES, j, 4)
    for j in range(LANES):
        section(con, cr, own * j, state, LANES, j, 5)
    for j in range(LANES):
        plate(con, cr, own * j, state, LANES, j)
    for j in range(LANES):
        assemble(con, cr, own * j, state, LANES, j)
    for j in range(LANES):
        solve(con, cr, own * j, state, LANES, j, False)


@kernel
def sweep(con, state):
    """Take one Newton step in every lane: many loads, one mechanism."""
    wide()
    _sweep(con, 1, 0, state)


@kernel
def sweep_mechanisms(con, state):
    """Take one Newton step in every lane, each with constants of its own: `con` holds lanes as `state` does."""
    wide()
    _sweep(con, LANES, 1, state)


@kernel
def solve_loads(con, coefficients, lam_max, lam, wrench, last2, state, x, z, theta, status):
    """Solve load cases on one mechanism, LANES at a time.

    coefficients, lam_max : see `start.guess`, used where both tendon forces are at most `lam_max`; else, and for
        lam_max = 0 always, the beam starts straight
    lam : (n, 2), wrench : (n, 3) or (1, 3), last2 : largest squared last step
    state : (LANES * state_size,)   work space
    x, z, theta, status : (n,)   overwritten; CONVERGED, or NOT_CONVERGED where the robust solver must decide
    """
    n, last_wrench = lam.shape[0], wrench.shape[0] - 1
    for first in range(0, n, LANES):
        for j in range(LANES):
            i = min(first + j, n - 1)
            put_load(state, LANES, j, lam[i], wrench[min(i, last_wrench)])
        inside = lanes_inside(state, lam_max)
        if inside > 0:
            guess(coefficients, lam_max, state, LANES, LANES, ORDER)
        if inside < LANES:
            for j in range(LANES):
                if not lane_inside(state, lam_max, j):
                    straighten(con, 1, 0, state, LANES, j, ORDER)
        for _ in range(MAX_STEPS):
            sweep(con, state)
            if settled(state, last2):
                break
        end = min(first + LANES, n)
        collect(state, last2, x[first:end], z[first:end], theta[first:end], status[first:end])


@kernel
def solve_mechanisms(
    par, mesh, nodes, turn, slopes, stretch, lam, wrench, last2, system, con, lanes, state, x, z, theta, status
):
    """Solve cases that each have a mechanism of their own, from the straight beam, LANES at a time.

    par : (n, n_parameters)
    mesh, nodes, turn, slopes, stretch : see `prepare` and `condensed.condense`
    system : work arrays of one thread: stations, tip, q_rest; con : (constants_size,), lanes : LANES times that
    the rest as in `solve_loads`
    """
    n, last_wrench = lam.shape[0], wrench.shape[0] - 1
    stations, tip, q_rest = system
    for first in range(0, n, LANES):
        for j in range(LANES):
            i = min(first + j, n - 1)
            prepare(par[i], mesh, nodes, stations, tip, q_rest)
            applies = condense(stations, tip, q_rest, turn, slopes, stretch, con)
            for k in range(con.shape[0]):
                lanes[LANES * k + j] = con[k]
            put_load(state, LANES, j, lam[i], wrench[min(i, last_wrench)])
            straighten(lanes, LANES, j, state, LANES, j, ORDER)
            if not applies:
                state[LANES * R_EXTREME + j] = 2.0
        for _ in range(MAX_STEPS):
            sweep_mechanisms(lanes, state)
            if settled(state, last2):
                break
        end = min(first + LANES, n)
        collect(state, last2, x[first:end], z[first:end], theta[first:end], status[first:end])


@step_kernel
def _iterate(con, state, last2, keep):
    for _ in range(MAX_STEPS):
        step(con, state, keep)
        if vouches(state, 1, 0, last2):
            return True
    return False


@kernel
def solve_nodes(par, mesh, nodes, turn, slopes, stretch, tables, lam, wrench, last2, system, con, state, q, status):
    """Solve cases one after the other, each from the straight beam, into their nodes.

    par : (1 or n, n_parameters)   one mechanism for all, or one for each
    tables : (3, p, p + 1); the other arguments as in `solve_mechanisms`, of one lane
    q : (n, 3 n_nodes), status : (n,)   overwritten; CONVERGED, or NOT_CONVERGED where the robust solver must decide
    """
    n, last_wrench = lam.shape[0], wrench.shape[0] - 1
    stations, tip, q_rest = system
    applies = False
    for i in range(n):
        if i < par.shape[0]:
            prepare(par[i], mesh, nodes, stations, tip, q_rest)
            applies = condense(stations, tip, q_rest, turn, slopes, stretch, con)
        put_load(state, 1, 0, lam[i], wrench[min(i, last_wrench)])
        straighten(con, 1, 0, state, 1, 0, ORDER)
        found = _iterate(con, state, last2, False) and applies
        status[i] = CONVERGED if found else NOT_CONVERGED
        nodes_of(con, state, tables, slopes, ORDER, q[i])


@step_kernel
def _follow(con, coefficients, settings, state, before, lam_l, lam_r):
    last2, keep, lam_max = settings[0], settings[1] > 0.0, settings[2]
    if lam_max == 0.0 and vouches(state, 1, 0, last2):
        extrapolate(state, before, lam_l, lam_r, ORDER)
        if _iterate(con, state, last2, keep):
            return True
    state[R_LAM_L], state[R_LAM_R] = lam_l, lam_r
    if lam_l <= lam_max and lam_r <= lam_max and lam_max > 0.0:
        guess(coefficients, lam_max, state, 1, 1, ORDER)
    else:
        straighten(con, 1, 0, state, 1, 0, ORDER)
    found = _iterate(con, state, last2, keep)
    remember(state, before, ORDER)
    return found


@kernel
def advance(address, lam_l, lam_r):
    """Take a control step: to new tendon forces, from where the memory at `address` stands; see `stepper`.

    Returns x, z, theta, status.
    """
    memory = array_at(address, 1973)
    settings = memory[0:3]
    con = memory[3:143]
    state = memory[143:263]
    before = memory[263:276]
    columns = memory[276:282]
    jacobian = memory[282:288].reshape((3, 2))
    compliance = memory[288:297].reshape((3, 3))
    coefficients = memory[297:528].reshape((11, 21))
    loads = memory[528:534]
    tables = memory[534:660].reshape((3, 6, 7))
    stations = memory[660:840].reshape((6, 30))
    tip = memory[840:884]
    q_rest = memory[884:905]
    q = memory[905:926]
    out = memory[926:938]
    work = memory[938:1973]
    possible = 0.0 <= lam_l < np.inf and 0.0 <= lam_r < np.inf
    if possible and _follow(con, coefficients, settings, state, before, lam_l, lam_r):
        if settings[1] > 0.0:
            tip_columns(con, state, columns)
            unfold(con, state, columns, compliance, jacobian)
        return state[R_X], state[R_Z], state[R_THETA], CONVERGED
    afresh = settings[2] != 0.0
    return rescue(tables, stations, tip, q_rest, loads, q, work, out, compliance, jacobian, afresh, lam_l, lam_r)
