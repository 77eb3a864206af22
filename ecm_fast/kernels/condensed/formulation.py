"""The condensed formulation: one element of order p with p Gauss points, positions eliminated exactly.

Dead loads along the beam and attachments at its tip only make the contact force known everywhere once the force f at
the tip is known: n(s) = f + the load beyond s. For p Gauss points that holds in the discrete equations too, so the
p + 1 nodes need no positions: unknown are the angle at each Gauss point, the tip position r and f. The stretch follows
from the inverse of the axial law, the shear from Q/GA, and what is left is

    couple     sum_k K_hk theta_k - c_h + w_h (Q gamma_x - N gamma_z)_h - t_h tau = 0     for each Gauss point h
    closure    sum_g w_g r'_g = r
    tip        f = F(r, theta_tip)

with K the bending stiffness of the angles, c the couple of clamp and curvature as built, t_h the share of theta_h in
the tip's angle. With C the compliance of the sections' stretch and shear, X = -dr/dtheta at fixed f and H = -dF/dpose,
Newton's step eliminates f and r through J = (1 + H_rr C)^-1, which stays well-conditioned however stiff the sections
are, and solves p equations for the angles. Equilibrium is stable exactly where 1 + H_rr C and what is left are
positive: the pivots certify it. It is the same discrete solution as that of `newton`, to rounding.

The same source serves three uses. Constant k of a lane is ``con[cr * k + cl]`` and quantity k of its state
``state[sr * k + j]``: one load case alone has ``cr = sr = 1`` and ``cl = j = 0``; in a block, lanes lie side by side
(``sr = LANES``) and share one mechanism (``cr = 1, cl = 0``) or have one each (``cr = LANES, cl = j``). The compiler
sees these numbers as constants. `physics` holds sections and head plate, `equations` writes out the rest of the step
for an order, and `step` holds what loops over it. The order is the length of the tuple `points`, so it is a type.
"""

import numpy as np

from .._jit import copy, kernel, step_kernel
from ..layout import (
    C_INV_FORCE2,
    C_INV_LENGTH2,
    C_ROUGH,
    C_SHIFT,
    C_STATION,
    C_STRETCH,
    C_THETA0,
    C_TIP,
    C_TOP_HEAVY,
    CONVERGED,
    LANES,
    N_KEPT,
    N_PAIR_TIP,
    N_POINT,
    N_SECTION,
    NOT_CONVERGED,
    P_THETA,
    R_DOUBT,
    R_EXTREME,
    R_FORCE_X,
    R_FORCE_Z,
    R_FX,
    R_FZ,
    R_LAM_L,
    R_LAM_R,
    R_PIVOT,
    R_POINT,
    R_SIZE,
    R_TAU,
    R_THETA,
    R_X,
    R_Z,
    S_EA,
    S_EI,
    S_FURTHER,
    S_GA,
    S_GUIDES,
    S_HOOKE,
    S_KAPPA0,
    S_LOAD_X,
    S_LOAD_Z,
    S_OFFSET,
    S_PLACE,
    S_WEIGHT,
    T_BENDING_FORCE,
    T_CHORDS,
    T_FURTHER,
    T_LENGTH,
    T_WEIGHT_X,
    T_WEIGHT_Z,
)
from ..prepare import is_top_heavy
from ..trig import sincos
from .axial_law import HALF, SHIFT, stretch_at

__all__ = [
    "accepts",
    "all_converged",
    "clear_record",
    "condense",
    "constants_size",
    "nodes_of",
    "plain_section",
    "put_head",
    "put_load",
    "read_results",
    "record_step",
    "reset_straight",
    "state_size",
]

# squares, in rad and shares of the length: of a step that is rounding, of the largest first one, and of the ratio of
# two successive ones
ROUNDING2, LARGEST2, SHRINK2 = 1e-18, 1.0, 0.25
MAX_STEPS = 7  # of Newton, whose last five square the error; what needs more goes the general path
# a tip force that still changes by 1e-7 EI/length^2 counts as much as a step of 1e-9
FORCE_SHARE = 0.01


def constants_size(order: int) -> int:
    """Return how many constants the condensed formulation of an order has."""
    return C_STATION + N_POINT * order + order * (order + 1) // 2


def state_size(order: int) -> int:
    """Return how many numbers the state of one load case has."""
    return R_POINT + N_SECTION * order + order * (order + 1) // 2 + N_KEPT


@kernel
def put_head(hooke, tip, theta0, stretch, con):
    """Put the constants before `C_STATION`, which do not depend on the mesh; arguments as in `condense`."""
    length = tip[T_LENGTH]
    copy(tip[:N_PAIR_TIP], con)
    con[C_THETA0], con[C_TIP], con[C_SHIFT] = theta0, theta0, SHIFT
    con[C_INV_LENGTH2], con[C_INV_FORCE2] = 1.0 / (length * length), (FORCE_SHARE / tip[T_BENDING_FORCE]) ** 2
    con[C_ROUGH], con[C_TOP_HEAVY] = 0.0, 0.0
    copy(stretch[1 if hooke > 0.5 else 0], con[C_STRETCH:])


@step_kernel
def plain_section(station):
    """Whether the laws of a section are uncoupled, bending and shear linear: stretch follows from N, shear from Q."""
    return station[S_OFFSET] == 0.0 and station[S_FURTHER] == 0.0 and station[S_GUIDES] == 0.0


@kernel
def _roughness(stations):
    """Size of the highest two Legendre coefficients of the bending compliance along the beam, as a share of its mean.

    stations : as in `condense`
    """
    p = stations.shape[0]
    last, before, mean = 0.0, 0.0, 0.0
    for g in range(p):
        x = 2.0 * stations[g, S_PLACE] - 1.0
        compliance = stations[g, S_WEIGHT] / stations[g, S_EI]
        lower, value = 0.0, 1.0
        for k in range(p - 1):
            lower, value = value, ((2.0 * k + 1.0) * x * value - k * lower) / (k + 1.0)
        mean += compliance
        last += (2.0 * p - 1.0) * compliance * value
        before += (2.0 * p - 3.0) * compliance * lower
    return np.sqrt(last * last + before * before) / mean


@kernel
def condense(stations, tip, q_rest, turn, slopes, stretch, con):
    """Constants of the condensed formulation, from those of the finite element model.

    stations : (p, N_STATION), tip : (N_TIP,), q_rest : (3 n_nodes,)   see `prepare`
    turn : (p, p)     integrals of the curvature's shape functions up to each Gauss point, for length 1 [-]
    slopes : (p, p)   its inverse: curvature at each Gauss point by the angles there
    stretch : see `stretch.stretch_polynomials`
    con : (constants_size(p),)   overwritten

    Returns whether the formulation applies: the section's laws are the plain ones and the axial one is the same along
    the beam, nothing gives way at the beam's ends, and no stop touches the head.
    """
    p, length, theta0 = stations.shape[0], tip[T_LENGTH], q_rest[2]
    put_head(stations[0, S_HOOKE], tip, theta0, stretch, con)
    con[C_STATION:] = 0.0
    K = con[C_STATION + N_POINT * p :]
    applies, shares = tip[T_FURTHER] == 0.0 and tip[T_CHORDS] == 0.0, 0.0
    for g in range(p):
        row, w = stations[g], stations[g, S_WEIGHT]
        applies = applies and plain_section(row) and row[S_HOOKE] == stations[0, S_HOOKE]
        point = con[C_STATION + N_POINT * g : C_STATION + N_POINT * (g + 1)]
        point[0], point[1], point[2], point[5] = w, 1.0 / (row[S_EA] * HALF), 1.0 / row[S_EA], 1.0 / row[S_GA]
        for k in range(p):
            other = stations[k]
            share = other[S_WEIGHT] * turn[k, g] * length / w
            point[3] += share * other[S_LOAD_X]
            point[4] += share * other[S_LOAD_Z]
            bend = other[S_WEIGHT] * slopes[k, g] / length
            point[6] += bend * other[S_EI] * other[S_KAPPA0]
            point[7] += bend
            for h in range(p):
                K_gh = bend * other[S_EI] * slopes[k, h] / length
                point[6] += K_gh * theta0
                if h <= g:
                    K[g * (g + 1) // 2 + h] += K_gh
        shares += point[7]
    con[C_TIP] = (1.0 - shares) * theta0
    con[C_ROUGH] = _roughness(stations)
    con[C_TOP_HEAVY] = 1.0 if is_top_heavy(stations, tip, theta0) else 0.0
    return applies


@step_kernel
def put_load(state, sr, j, lam, wrench):
    """Put tendon forces (2,) and a dead wrench (3,) on lane `j`."""
    state[sr * R_LAM_L + j], state[sr * R_LAM_R + j] = lam[0], lam[1]
    state[sr * R_FX + j], state[sr * R_FZ + j], state[sr * R_TAU + j] = wrench[0], wrench[1], wrench[2]


@step_kernel
def reset_straight(con, cr, cl, state, sr, j, order):
    """Put the beam of lane `j` back into its straight state, under the loads that are there.

    Where the beam does not carry its own weight, nothing that starts there is vouched for, see `is_top_heavy`.
    """
    length, theta = con[cr * T_LENGTH + cl], con[cr * C_THETA0 + cl]
    s, c = sincos(theta)
    state[sr * R_X + j], state[sr * R_Z + j], state[sr * R_THETA + j] = length * c, -length * s, theta
    # tendons at rest pull along the beam, nearly; Newton corrects that
    pull = state[sr * R_LAM_L + j] + state[sr * R_LAM_R + j]
    state[sr * R_FORCE_X + j] = state[sr * R_FX + j] + con[cr * T_WEIGHT_X + cl] - pull * c
    state[sr * R_FORCE_Z + j] = state[sr * R_FZ + j] + con[cr * T_WEIGHT_Z + cl] + pull * s
    for g in range(order):
        state[sr * (R_POINT + N_SECTION * g + P_THETA) + j] = theta
    clear_record(state, sr, j)
    state[sr * R_EXTREME + j] = 2.0 * con[cr * C_TOP_HEAVY + cl]


@step_kernel
def clear_record(state, sr, j):
    """Forget what the steps of lane `j` said."""
    state[sr * R_SIZE + j], state[sr * R_PIVOT + j], state[sr * R_EXTREME + j] = np.inf, np.inf, 0.0


@step_kernel
def record_step(state, sr, j, size):
    """Write down how large a step was.

    size : sum of squares of the turns [rad], of the tip's displacement [lengths] and of the tip force's change
    A step that does not shrink, or a large first one, may lead to another branch: it is not vouched for.
    """
    limit = SHRINK2 * state[sr * R_SIZE + j]
    limit = limit if limit < LARGEST2 else LARGEST2
    limit = limit if limit > ROUNDING2 else ROUNDING2
    extreme = state[sr * R_EXTREME + j]
    state[sr * R_EXTREME + j] = 2.0 if size > limit else extreme
    state[sr * R_SIZE + j] = size


@step_kernel
def accepts(state, sr, j, step_tol2):
    """Whether lane `j` holds a stable equilibrium that the fast path accepts.

    Every iterate must have been stable and inside the range of the polynomials, every step must have shrunk by half
    at least, and the squared size of the last one is at most `step_tol2`. Where it does not vouch, that is no verdict:
    the general path decides.
    """
    converged, stable = state[sr * R_SIZE + j] <= step_tol2, state[sr * R_PIVOT + j] > 0.0
    return converged and stable and state[sr * R_EXTREME + j] <= 1.0


@kernel
def all_converged(state, step_tol2):
    """Whether every lane's last step is small enough, of those that can still be vouched for."""
    size = state[LANES * R_SIZE : LANES * (R_SIZE + 1)]
    extreme = state[LANES * R_EXTREME : LANES * (R_EXTREME + 1)]
    open_lanes = 0
    for j in range(LANES):
        open_lanes += 1 if (size[j] > step_tol2) & (extreme[j] <= 1.0) else 0
    return open_lanes == 0


@kernel
def read_results(state, step_tol2, x, z, theta, status, doubt):
    """Read poses, verdicts and bounds of the error off the first lanes, as many as there is room for."""
    for j in range(x.shape[0]):
        doubt[j] = state[LANES * R_DOUBT + j]
    for j in range(x.shape[0]):
        x[j], z[j], theta[j] = state[LANES * R_X + j], state[LANES * R_Z + j], state[LANES * R_THETA + j]
    size, pivot = state[LANES * R_SIZE : LANES * (R_SIZE + 1)], state[LANES * R_PIVOT : LANES * (R_PIVOT + 1)]
    extreme = state[LANES * R_EXTREME : LANES * (R_EXTREME + 1)]
    for j in range(x.shape[0]):
        # as `accepts`, without a branch
        found = (size[j] <= step_tol2) & (pivot[j] > 0.0) & (extreme[j] <= 1.0)
        status[j] = CONVERGED if found else NOT_CONVERGED


@kernel
def nodes_of(con, state, tables, slopes, order, q):
    """Positions and angles of the nodes, (3 n_nodes,), of the one load case that `state` holds.

    tables : (3, p, p + 1), of which the last integrates from the clamp to the nodes, see `Discretization.tables`
    """
    length, theta0 = con[T_LENGTH], con[C_THETA0]
    for a in range(order + 1):
        q[3 * a], q[3 * a + 1], q[3 * a + 2] = 0.0, 0.0, theta0
    for g in range(order):
        i, r = C_STATION + N_POINT * g, R_POINT + N_SECTION * g
        s, c = sincos(state[r + P_THETA])
        n_x, n_z = state[R_FORCE_X] + con[i + 3], state[R_FORCE_Z] + con[i + 4]
        stretch, _ = stretch_at(con, 1, 0, (n_x * c - n_z * s) * con[i + 1] + con[C_SHIFT])
        shear = (n_x * s + n_z * c) * con[i + 5]
        kappa = 0.0
        for h in range(order):
            kappa += slopes[g, h] * (state[R_POINT + N_SECTION * h + P_THETA] - theta0) / length
        for a in range(order + 1):
            lift = length * tables[2, g, a]
            q[3 * a] += lift * (stretch * c + shear * s)
            q[3 * a + 1] += lift * (shear * c - stretch * s)
            q[3 * a + 2] += lift * kappa
