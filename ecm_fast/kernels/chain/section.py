"""The section law at the Gauss points of a chain, in vector arithmetic over many points.

The rows of a block stand `COLUMNS` numbers apart, a distance known when compiling, and the loops call nothing that is
not inlined. Only then does the compiler see that no row overlaps another, and work on several elements at once.
"""

from .._jit import kernel, step_kernel
from ..condensed.axial_law import stretch_at
from ..layout import (
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
)
from ..trig import NEAR, sincos_near

__all__ = ["linear_elements", "samples"]

NODE = N_ENDS + G_NODE


@step_kernel
def _section(con, points, j, angle, f_x, f_z):
    """One Gauss point at a known force: stretch and shear follow from it, see `condensed`.

    Returns, each times the weight: derivative of the residual by the angle, residual, its derivatives by the force,
    slope r', compliance xx, xz, zz; and more than 0 where a polynomial does not hold.
    """
    s, c = sincos_near(angle)
    w, by_Q = points[B_WEIGHT + j], points[B_BY_Q + j]
    n_x, n_z = f_x + points[B_BEYOND_X + j], f_z + points[B_BEYOND_Z + j]
    N, Q = n_x * c - n_z * s, n_x * s + n_z * c
    u = N * points[B_SCALE + j] + con[C_SHIFT]
    stretch, slope = stretch_at(con, 1, 0, u)
    by_N = points[B_BY_N + j] * slope
    shear = Q * by_Q
    along, across = w * (Q * by_N - shear), w * (stretch - N * by_Q)
    slope = N * across - Q * along
    b_x, b_z = along * c + across * s, across * c - along * s
    res = w * (Q * stretch - N * shear)
    d_x, d_z = w * (stretch * c + shear * s), w * (shear * c - stretch * s)
    w_N, w_Q = w * by_N, w * by_Q
    outside = (0.0 if u * u <= 1.0 else 1.0) + (0.0 if angle * angle <= NEAR * NEAR else 1.0)
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
