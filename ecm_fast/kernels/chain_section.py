"""The Gauss points of a chain of elements, many at a time: what is not a recurrence is vector arithmetic.

The rows of a block stand `COLUMNS` numbers apart, a distance known when compiling, and the loops call nothing that is
not inlined. Only then does the compiler see that no row overlaps another, and work on several elements at once.
"""

from ._jit import kernel, step_kernel
from .layout import (
    B_BEND,
    B_BEYOND_X,
    B_BEYOND_Z,
    B_BY_N,
    B_BY_Q,
    B_CURVED,
    B_SCALE,
    B_UNIT,
    B_WEIGHT,
    C_SHIFT,
    C_SLOPE,
    C_STRETCH,
    E_LL,
    E_LR,
    E_RES_L,
    E_RES_R,
    E_RIGHT,
    E_RR,
    E_X_L,
    E_X_R,
    E_Z_L,
    E_Z_R,
    G_ANGLE,
    G_NODE,
    G_RES,
    G_SLOPE,
    G_X,
    G_Z,
    H_CXX,
    H_CXZ,
    H_CZZ,
    H_DOUBT,
    H_DX,
    H_DZ,
    H_FORCE_X,
    H_FORCE_Z,
    N_ENDS,
    N_SLOPE,
    N_STRETCH,
)

__all__ = ["COS", "MAX_ANGLE", "SIN", "linear_elements", "samples"]

NODE = N_ENDS + G_NODE
# Polynomials in t^2 for sin t / t and cos t: those of the condensed steps, which see no angle beyond this one [rad]
MAX_ANGLE = 1.6
SIN = (
    0.9999999999999999,
    -0.166666666666659,
    0.00833333333327031,
    -0.000198412698215638,
    2.7557316196951017e-06,
    -2.505185572558516e-08,
    1.6047346685140787e-10,
    -7.364331601228968e-13,
)
COS = (
    1.0,
    -0.49999999999999967,
    0.04166666666666307,
    -0.0013888888888744474,
    2.4801587272556152e-05,
    -2.755731594453267e-07,
    2.087653924157399e-09,
    -1.1462309288889073e-11,
    4.602690920668355e-14,
)
S0, S1, S2, S3, S4, S5, S6, S7 = SIN
C0, C1, C2, C3, C4, C5, C6, C7, C8 = COS


@step_kernel
def _sincos(t):
    """Sine, cosine and squared angle, without reduction: for |t| up to `MAX_ANGLE`."""
    t2 = t * t
    t4 = t2 * t2
    s = t * ((S0 + t4 * (S2 + t4 * (S4 + t4 * S6))) + t2 * (S1 + t4 * (S3 + t4 * (S5 + t4 * S7))))
    c = (C0 + t4 * (C2 + t4 * (C4 + t4 * (C6 + t4 * C8)))) + t2 * (C1 + t4 * (C3 + t4 * (C5 + t4 * C7)))
    return s, c, t2


@step_kernel
def _polynomial(con, first, n, u, u2):
    """Polynomial in u with an odd number of coefficients: two Horner chains in u^2, half as deep as one."""
    even, odd = con[first + n - 1], con[first + n - 2]
    for k in range(n // 2 - 1):
        even = con[first + n - 3 - 2 * k] + u2 * even
        odd = con[first + n - 4 - 2 * k] + u2 * odd
    return con[first] + u2 * even + u * odd


@step_kernel
def _section(con, points, j, angle, f_x, f_z):
    """One Gauss point at a known force: stretch and shear follow from it, see `condensed`.

    Returns, each times the weight: derivative of the residual by the angle, residual, its derivatives by the force,
    slope r', compliance xx, xz, zz; and more than 0 where a polynomial does not hold.
    """
    s, c, t2 = _sincos(angle)
    w, by_Q = points[B_WEIGHT + j], points[B_BY_Q + j]
    n_x, n_z = f_x + points[B_BEYOND_X + j], f_z + points[B_BEYOND_Z + j]
    N, Q = n_x * c - n_z * s, n_x * s + n_z * c
    u = N * points[B_SCALE + j] + con[C_SHIFT]
    u2 = u * u
    stretch = _polynomial(con, C_STRETCH, N_STRETCH, u, u2)
    by_N = points[B_BY_N + j] * _polynomial(con, C_SLOPE, N_SLOPE, u, u2)
    shear = Q * by_Q
    along, across = w * (Q * by_N - shear), w * (stretch - N * by_Q)
    slope = N * across - Q * along
    b_x, b_z = along * c + across * s, across * c - along * s
    res = w * (Q * stretch - N * shear)
    d_x, d_z = w * (stretch * c + shear * s), w * (shear * c - stretch * s)
    w_N, w_Q = w * by_N, w * by_Q
    outside = (0.0 if u2 <= 1.0 else 1.0) + (0.0 if t2 <= MAX_ANGLE * MAX_ANGLE else 1.0)
    c_xx, c_xz, c_zz = c * c * w_N + s * s * w_Q, s * c * (w_Q - w_N), s * s * w_N + c * c * w_Q
    return slope, res, b_x, b_z, d_x, d_z, c_xx, c_xz, c_zz, outside


@kernel
def linear_elements(con, points, block, m, head):
    """Linear elements of one block, to both of their ends.

    con : constants; points, block : rows of constants and of the state, see `layout`
    m : how many columns
    head : sums added to
    """
    f_x, f_z = head[H_FORCE_X], head[H_FORCE_Z]
    dx, dz, cxx, cxz, czz, doubt = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(m):
        left, right = block[NODE + j], block[E_RIGHT + j]
        slope, res, b_x, b_z, d_x, d_z, c_xx, c_xz, c_zz, outside = _section(
            con, points, j, 0.5 * (left + right), f_x, f_z
        )
        couple = points[B_BEND + j] * (right - left) - points[B_CURVED + j]
        share = 0.25 * slope * points[B_UNIT + j]
        block[E_LL + j], block[E_LR + j], block[E_RR + j] = share + 1.0, share - 1.0, share + 1.0
        block[E_RES_L + j], block[E_RES_R + j] = 0.5 * res - couple, 0.5 * res + couple
        block[E_X_L + j], block[E_X_R + j] = 0.5 * b_x, 0.5 * b_x
        block[E_Z_L + j], block[E_Z_R + j] = 0.5 * b_z, 0.5 * b_z
        dx += d_x
        dz += d_z
        cxx += c_xx
        cxz += c_xz
        czz += c_zz
        doubt += outside
    _add(head, dx, dz, cxx, cxz, czz, doubt)


@kernel
def samples(con, points, sample, m, head):
    """One Gauss point in every element of a block; arguments as for `linear_elements`.

    sample : rows `G_*` of this Gauss point
    """
    f_x, f_z = head[H_FORCE_X], head[H_FORCE_Z]
    dx, dz, cxx, cxz, czz, doubt = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(m):
        slope, res, b_x, b_z, d_x, d_z, c_xx, c_xz, c_zz, outside = _section(
            con, points, j, sample[G_ANGLE + j], f_x, f_z
        )
        sample[G_SLOPE + j], sample[G_RES + j] = slope, res
        sample[G_X + j], sample[G_Z + j] = b_x, b_z
        dx += d_x
        dz += d_z
        cxx += c_xx
        cxz += c_xz
        czz += c_zz
        doubt += outside
    _add(head, dx, dz, cxx, cxz, czz, doubt)


@step_kernel
def _add(head, dx, dz, cxx, cxz, czz, doubt):
    """Add one loop's sums to those of the chain."""
    head[H_DX] += dx
    head[H_DZ] += dz
    head[H_CXX] += cxx
    head[H_CXZ] += cxz
    head[H_CZZ] += czz
    head[H_DOUBT] += doubt
