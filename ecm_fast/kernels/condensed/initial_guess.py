"""Initial guesses on the condensed path: a polynomial in the tendon forces, or an extrapolation."""

import numpy as np

from .._jit import kernel, step_kernel, wide
from ..layout import LANES, N_SECTION, P_THETA, R_LAM_L, R_LAM_R, R_POINT, R_X
from .formulation import clear_record

__all__ = [
    "ANGLES",
    "N_GUESS",
    "extrapolate",
    "guess",
    "lane_inside",
    "lanes_inside",
    "monomials",
    "recall",
    "remember",
    "unknowns",
]

# coefficients of a polynomial of degree 5 in two variables
N_GUESS = 21
# unknowns: tip position (2), tip force (2), then angles
ANGLES = 4


@step_kernel
def _unknown(i):
    """Place of unknown `i` in the state: tip position and force, tip angle, then the points' angles."""
    return R_X + i if i < 5 else R_POINT + N_SECTION * (i - 5) + P_THETA


def unknowns(order: int) -> list[int]:
    """Return where all unknowns stand in the state."""
    return [_unknown.py_func(i) for i in range(5 + order)]


def monomials(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return the monomials of `guess`, (n, N_GUESS), at scaled tendon forces (n,)."""
    return np.stack([u**i * v**k for i in range(6) for k in range(6 - i)], axis=1)


@kernel
def lanes_inside(state, lam_max):
    """Return in how many lanes `guess` holds."""
    lam_l = state[LANES * R_LAM_L : LANES * (R_LAM_L + 1)]
    lam_r = state[LANES * R_LAM_R : LANES * (R_LAM_R + 1)]
    inside = 0
    for j in range(LANES):
        inside += 1 if (lam_l[j] <= lam_max) & (lam_r[j] <= lam_max) else 0
    return inside if lam_max > 0.0 else 0


@step_kernel
def lane_inside(state, lam_max, j):
    """Whether `guess` holds in lane `j`; not where a force is not a number."""
    held = state[LANES * R_LAM_L + j] <= lam_max and state[LANES * R_LAM_R + j] <= lam_max
    return held and lam_max > 0.0


@step_kernel
def guess(coefficients, lam_max, state, sr, n_lanes, order):
    """Put lanes where a polynomial in the tendon forces expects the equilibrium.

    coefficients : (5 + order, N_GUESS)   fitted over [0, lam_max]^2, scaled to [-1, 1]^2
    """
    wide()
    scale = 2.0 / lam_max
    lam_l = state[sr * R_LAM_L : sr * R_LAM_L + n_lanes]
    lam_r = state[sr * R_LAM_R : sr * R_LAM_R + n_lanes]
    for i in range(5 + order):
        # slices, for indices that the compiler knows to be positive; names of their own, because it cannot know that
        # no store into the state changes a coefficient
        place = sr * _unknown(i)
        a, row = coefficients[i], state[place : place + n_lanes]
        a00, a01, a02, a03, a04, a05 = a[0], a[1], a[2], a[3], a[4], a[5]
        a10, a11, a12, a13, a14 = a[6], a[7], a[8], a[9], a[10]
        a20, a21, a22, a23, a30, a31, a32 = a[11], a[12], a[13], a[14], a[15], a[16], a[17]
        a40, a41, a50 = a[18], a[19], a[20]
        for j in range(n_lanes):
            u, v = scale * lam_l[j] - 1.0, scale * lam_r[j] - 1.0
            b0 = a00 + v * (a01 + v * (a02 + v * (a03 + v * (a04 + v * a05))))
            b1 = a10 + v * (a11 + v * (a12 + v * (a13 + v * a14)))
            b2, b3 = a20 + v * (a21 + v * (a22 + v * a23)), a30 + v * (a31 + v * a32)
            row[j] = b0 + u * (b1 + u * (b2 + u * (b3 + u * (a40 + v * a41 + u * a50))))
    for j in range(n_lanes):
        clear_record(state, sr, j)


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
    clear_record(state, 1, 0)


@step_kernel
def remember(state, before, order):
    """Make the present state the one before: nothing is known yet of how it moves."""
    before[0], before[1] = state[R_LAM_L], state[R_LAM_R]
    for i in range(5 + order):
        before[2 + i] = state[_unknown(i)]


@step_kernel
def recall(state, before, order):
    """Make the state one step before the present one."""
    state[R_LAM_L], state[R_LAM_R] = before[0], before[1]
    for i in range(5 + order):
        state[_unknown(i)] = before[2 + i]
