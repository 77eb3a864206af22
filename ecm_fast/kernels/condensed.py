"""The fast path: one element of order p with p Gauss points, the positions eliminated exactly.

Dead loads along the beam and attachments at its tip only make the contact force known everywhere once the force f at
the tip is known: n(s) = f + the load beyond s. For p Gauss points that holds in the discrete equations too, so the
p + 1 nodes need no positions: unknown are the curvature at each Gauss point, the tip position r and f. The stretch
follows from the inverse of the axial law, the shear from Q/GA, and what is left is

    couple     w_h M_h + sum_g w_g B_gh (Q gamma_x - N gamma_z)_g - w_h tau = 0     for each Gauss point h
    closure    sum_g w_g r'_g = r
    tip        f = F(r, theta_tip)

with B the integral of the curvature up to each Gauss point. Newton eliminates f first: its 2 x 2 compliance is
positive, and the remaining p + 2 equations are positive definite exactly where the equilibrium is stable.
It is the same discrete solution as that of `newton`, to rounding; the steps themselves are written out in
`condensed3` to `condensed6`.
"""

import numpy as np

from ._jit import kernel
from .layout import (
    C_INV_FORCE2,
    C_INV_LENGTH2,
    C_SHIFT,
    C_SLOPE,
    C_STATION,
    C_STRETCH,
    C_THETA0,
    L_FX,
    L_FZ,
    L_LAM_L,
    L_LAM_R,
    L_TAU,
    LANES,
    N_POINT,
    N_SLOPE,
    N_STRETCH,
    N_TIP,
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
    S_EA,
    S_EI,
    S_GA,
    S_HOOKE,
    S_KAPPA0,
    S_LOAD_X,
    S_LOAD_Z,
    S_OFFSET,
    S_WEIGHT,
    T_BENDING_FORCE,
    T_LENGTH,
    T_WEIGHT_X,
    T_WEIGHT_Z,
)
from .section import axial_law
from .trig import sincos

__all__ = [
    "condense",
    "constants_size",
    "largest_step",
    "restart_lane",
    "start_lane",
    "state_size",
    "stretch_fit",
    "vouches",
]

# N/EA over which the polynomials for the stretch hold: from 9 % shortening to 4 % stretch
LOWEST, HIGHEST = -0.10, 0.04
# squares of a step, in rad and shares of the length: of the last one, of the largest first one, and of the ratio of
# two successive ones
TOLERANCE2, LARGEST2, SHRINK2 = 1e-18, 1.0, 0.25
MAX_STEPS = 7
# a tip force that still changes by 1e-7 EI/length^2 counts as much as a step of 1e-9
FORCE_SHARE = 0.01


def constants_size(order: int) -> int:
    """Return how many constants the condensed formulation of an order has."""
    return C_STATION + N_POINT * order + order * order


def state_size(order: int) -> int:
    """Return how many numbers the state of `LANES` load cases has."""
    return R_KAPPA + LANES * order


def stretch_fit() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the scaled axial forces to fit at, and the matrices from stretches there to both polynomials.

    Shapes (N_STRETCH,), (N_STRETCH, N_STRETCH), (N_SLOPE, N_STRETCH).
    """
    u = np.cos(np.pi * (np.arange(N_STRETCH) + 0.5) / N_STRETCH)
    to_power = np.linalg.inv(np.vander(u, increasing=True))
    derivative = np.diag(np.arange(1.0, N_STRETCH), 1)
    slopes = np.vander(u, increasing=True) @ derivative @ to_power
    fewer = np.linalg.pinv(np.vander(u, N_SLOPE, increasing=True)) @ slopes
    return u, to_power, fewer


@kernel
def condense(stations, tip, q_rest, turn, fit_at, to_stretch, to_slope, con):
    """Constants of the condensed formulation, from those of the finite element model.

    stations : (p, N_STATION), tip : (N_TIP,), q_rest : (3 n_nodes,)   see `prepare`
    turn : (p, p)   integrals of the curvature's shape functions up to each Gauss point, for length 1 [-]
    fit_at, to_stretch, to_slope : see `stretch_fit`
    con : (constants_size(p),)   overwritten

    Returns whether the formulation applies: the section's laws are uncoupled and the axial one is the same along
    the beam.
    """
    p = stations.shape[0]
    length = tip[T_LENGTH]
    con[:N_TIP] = tip
    con[C_THETA0], con[C_INV_LENGTH2] = q_rest[2], 1.0 / (length * length)
    con[C_INV_FORCE2] = (FORCE_SHARE / tip[T_BENDING_FORCE]) ** 2
    half = 0.5 * (HIGHEST - LOWEST)
    con[C_SHIFT] = -0.5 * (HIGHEST + LOWEST) / half
    con[C_STRETCH:C_STATION] = 0.0
    for i in range(N_STRETCH):
        stretch = _stretch(stations[0, S_HOOKE], half * (fit_at[i] - con[C_SHIFT]))
        for k in range(N_STRETCH):
            con[C_STRETCH + k] += to_stretch[k, i] * stretch
        for k in range(N_SLOPE):
            con[C_SLOPE + k] += to_slope[k, i] * stretch / half
    applies = True
    for g in range(p):
        row, w = stations[g], stations[g, S_WEIGHT]
        applies = applies and row[S_OFFSET] == 0.0 and row[S_HOOKE] == stations[0, S_HOOKE]
        beyond_x, beyond_z = 0.0, 0.0
        for k in range(p):
            share = stations[k, S_WEIGHT] * turn[k, g] * length / w
            beyond_x += share * stations[k, S_LOAD_X]
            beyond_z += share * stations[k, S_LOAD_Z]
        point = con[C_STATION + N_POINT * g : C_STATION + N_POINT * (g + 1)]
        point[0], point[1], point[2] = w, 1.0 / (row[S_EA] * half), 1.0 / row[S_EA]
        point[3], point[4] = w * row[S_EI], w * row[S_EI] * row[S_KAPPA0]
        point[5], point[6], point[7] = beyond_x, beyond_z, 1.0 / row[S_GA]
        for h in range(p):
            con[C_STATION + N_POINT * p + p * g + h] = turn[g, h] * length
    return applies


@kernel
def _stretch(hooke, share):
    """Stretch at which the axial force is `share` of EA: the axial law [C1] inverted by Newton's method."""
    stretch = 1.0
    for _ in range(50):
        force, slope = axial_law(1.0, hooke, stretch)
        change = (share - force) / slope
        stretch += change
        if abs(change) < 1e-16:
            break
    return stretch


@kernel
def start_lane(con, loads, state, j):
    """Put a load case into lane `j` of the state, the beam straight.

    loads : (N_LOADS,), of which the share of gravity is taken as 1
    """
    state[R_LAM_L + j], state[R_LAM_R + j] = loads[L_LAM_L], loads[L_LAM_R]
    state[R_FX + j], state[R_FZ + j], state[R_TAU + j] = loads[L_FX], loads[L_FZ], loads[L_TAU]
    restart_lane(con, state, j)


@kernel
def restart_lane(con, state, j):
    """Put the beam of lane `j` back into its straight state, under the loads that are there."""
    s, c = sincos(con[C_THETA0])
    state[R_X + j], state[R_Z + j], state[R_THETA + j] = con[T_LENGTH] * c, -con[T_LENGTH] * s, con[C_THETA0]
    # tendons at rest pull along the beam, nearly; Newton corrects that
    pull = state[R_LAM_L + j] + state[R_LAM_R + j]
    state[R_FORCE_X + j] = state[R_FX + j] + con[T_WEIGHT_X] - pull * c
    state[R_FORCE_Z + j] = state[R_FZ + j] + con[T_WEIGHT_Z] + pull * s
    state[R_SIZE + j], state[R_PIVOT + j], state[R_EXTREME + j] = np.inf, np.inf, 0.0
    for row in range(R_KAPPA, state.shape[0], LANES):
        state[row + j] = 0.0


@kernel
def largest_step(state):
    """Return the largest squared step of all lanes; one that is not a number does not count."""
    largest = 0.0
    for j in range(LANES):
        largest = max(largest, state[R_SIZE + j])
    return largest


@kernel
def vouches(state, j):
    """Whether lane `j` holds a stable equilibrium that the fast path vouches for.

    Every iterate must have been stable and inside the range of the polynomials, every step must have shrunk by half
    at least, and the last one below the tolerance. Where it does not vouch, that is no verdict: the robust solver
    decides.
    """
    return state[R_SIZE + j] < TOLERANCE2 and state[R_PIVOT + j] > 0.0 and state[R_EXTREME + j] <= 1.0
