"""Where a solve on the fast path starts from: a polynomial in the tendon forces, or the two states before."""

import numpy as np

from ._jit import step_kernel
from .condensed import unjudged
from .layout import N_SECTION, P_THETA, R_LAM_L, R_LAM_R, R_POINT, R_THETA, R_X

__all__ = ["ANGLES", "N_GUESS", "extrapolate", "guess", "monomials", "remember", "unknowns"]

# coefficients of a polynomial of degree 4 in two variables
N_GUESS = 15
# unknowns: tip position (2), tip force (2), then angles
ANGLES = 4


@step_kernel
def _unknown(i):
    """Return where unknown `i` stands in the state: tip position and force, tip angle, then the Gauss points' angles."""
    return R_X + i if i < 5 else R_POINT + N_SECTION * (i - 5) + P_THETA


def unknowns(order: int) -> list[int]:
    """Return where all unknowns stand in the state."""
    return [_unknown.py_func(i) for i in range(5 + order)]


@step_kernel
def _row(a, u, v):
    """Polynomial of degree 4 in u and v, by Horner's rule in both."""
    v0 = a[0] + v * (a[1] + v * (a[2] + v * (a[3] + v * a[4])))
    v1 = a[5] + v * (a[6] + v * (a[7] + v * a[8]))
    v2 = a[9] + v * (a[10] + v * a[11])
    return v0 + u * (v1 + u * (v2 + u * (a[12] + v * a[13] + u * a[14])))


def monomials(u, v):
    """Return the monomials of `guess`, (n, N_GUESS), at scaled tendon forces (n,)."""
    return np.stack([u**i * v**k for i in range(5) for k in range(5 - i)], axis=1)


@step_kernel
def guess(coefficients, lam_max, state, sr, n_lanes, order):
    """Put lanes where a polynomial in the tendon forces expects the equilibrium.

    coefficients : (5 + order, N_GUESS)   fitted over [0, lam_max]^2, scaled to [-1, 1]^2
    """
    scale = 2.0 / lam_max
    for i in range(5 + order):
        a, place = coefficients[i], sr * _unknown(i)
        for j in range(n_lanes):
            u, v = scale * state[sr * R_LAM_L + j] - 1.0, scale * state[sr * R_LAM_R + j] - 1.0
            state[place + j] = _row(a, u, v)
    for j in range(n_lanes):
        unjudged(state, sr, j)


@step_kernel
def extrapolate(state, before, lam_l, lam_r, order):
    """Set new tendon forces, and move the state as it moved with the forces the last time.

    before : (7 + order,)   tendon forces and unknowns one step earlier; overwritten with the present ones

    The change of the forces is projected on the last change; across it nothing is known, so nothing moves.
    """
    d_l, d_r = state[R_LAM_L] - before[0], state[R_LAM_R] - before[1]
    along = (lam_l - state[R_LAM_L]) * d_l + (lam_r - state[R_LAM_R]) * d_r
    share = along / (d_l * d_l + d_r * d_r)
    share = share if -1.0 <= share <= 2.0 else 0.0
    before[0], before[1] = state[R_LAM_L], state[R_LAM_R]
    for i in range(5 + order):
        place = _unknown(i)
        now = state[place]
        state[place] = now + share * (now - before[2 + i])
        before[2 + i] = now
    state[R_LAM_L], state[R_LAM_R] = lam_l, lam_r
    unjudged(state, 1, 0)


@step_kernel
def remember(state, before, order):
    """Make the present state the one before: nothing is known yet of how it moves."""
    before[0], before[1] = state[R_LAM_L], state[R_LAM_R]
    for i in range(5 + order):
        before[2 + i] = state[_unknown(i)]
