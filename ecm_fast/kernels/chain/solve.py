"""The solver of the chain path: positions eliminated exactly, the rest a band of width one.

As in `condensed` the contact force is known once the force f at the tip is, here from element to element, so the
nodes need no positions: unknown are their angles, the tip position r and f. With as many Gauss points as the order
that is the discrete solution of `newton`, to rounding. Inner nodes are eliminated within their element, and what is
left is tridiagonal in the angles at the elements' ends, bordered by f and r:

    | A   B    h |   A  angles; couples neighbors only
    | B'  -C   1 |   B  by the force: two columns; C its compliance at fixed angles
    | h'   1   H |   h, H  load stiffness, at the tip's angle only

One sweep from the clamp eliminates the angles with three right-hand sides. The leading minors of A obey a recurrence
without a division, so no step of the sweep waits for one; pivots are the ratios of two minors. Minors are taken in
units of each element's EI/length, and so grow no faster than the beam's compliance does.

Stability: f is eliminated after the angles, at fixed f, so A need not be positive where the equilibrium is stable. By
Sylvester's law of inertia it is stable exactly where all pivots together have two negative signs, those of f.
"""

import numpy as np

from ...mechanism.catalogue import LARGEST_PUSH
from .._jit import kernel
from ..condensed.formulation import LARGEST2, MAX_STEPS, ROUNDING2, SHRINK2
from ..general.tip import tendon_forces, tip_wrench
from ..layout import (
    C_BASIS,
    C_COUNT,
    C_ORDER,
    C_THETA0,
    COLUMNS,
    CONVERGED,
    E_RIGHT,
    G_ANGLE,
    G_NODE,
    H_DOUBT,
    H_DX,
    H_FORCE_X,
    H_FORCE_Z,
    H_NEGATIVE,
    H_SIZE,
    H_STIFFNESS,
    H_THETA,
    H_WRENCH,
    H_X,
    H_Z,
    INVALID_INPUT,
    L_FX,
    L_FZ,
    L_GRAVITY,
    L_LAM_L,
    L_LAM_R,
    L_PRESTRAIN,
    N_BEAM,
    N_ENDS,
    N_HEAD,
    N_SAMPLES,
    NOT_CONVERGED,
    T_LENGTH,
    T_WEIGHT_X,
    T_WEIGHT_Z,
)
from ..trig import sincos
from .element import assemble, dense_size, eliminate_inner
from .section import linear_elements, samples
from .sweep import border, eliminate, turn_back

__all__ = ["follow_chain", "solve_chain", "start_chain", "state_size"]


def state_size(n_elements: int, order: int) -> int:
    """Return how many numbers the state of one load case has."""
    blocks = -(-n_elements // COLUMNS)
    return N_HEAD + blocks * (N_ENDS + order * N_SAMPLES) + n_elements * dense_size(order)


@kernel
def start_chain(con, state):
    """Straighten the beam, under the loads that are there."""
    p, n = int(con[C_ORDER]), int(con[C_COUNT])
    s, c = sincos(con[C_THETA0])
    first_block = N_HEAD
    for first in range(0, n, COLUMNS):
        for j in range(min(COLUMNS, n - first)):
            state[first_block + E_RIGHT + j] = con[C_THETA0]
            for row in range(first_block + N_ENDS, first_block + N_ENDS + p * N_SAMPLES, N_SAMPLES):
                state[row + G_NODE + j] = con[C_THETA0]
                state[row + G_ANGLE + j] = con[C_THETA0]
        first_block += N_ENDS + p * N_SAMPLES
    state[H_X], state[H_Z], state[H_THETA] = con[T_LENGTH] * c, -con[T_LENGTH] * s, con[C_THETA0]
    # tendons at rest pull along the beam, nearly; Newton corrects that
    pull = state[L_LAM_L] + state[L_LAM_R]
    state[H_FORCE_X] = state[L_FX] + con[T_WEIGHT_X] - pull * c
    state[H_FORCE_Z] = state[L_FZ] + con[T_WEIGHT_Z] + pull * s


@kernel
def newton_chain(con, state):
    """Take one Newton step."""
    p, n = int(con[C_ORDER]), int(con[C_COUNT])
    state[H_NEGATIVE] = 0.0
    for i in range(H_DX, H_WRENCH):
        state[i] = 0.0
    tip_wrench(
        con, state, state[H_X], state[H_Z], state[H_THETA], state[H_WRENCH:H_STIFFNESS], state[H_STIFFNESS:N_HEAD]
    )
    _elements(con, state, p, n)
    inv, r, x, z = eliminate(con, state, p, n)
    step_x, step_z, turned, size = border(con, state, inv, r, x, z)
    largest = turn_back(con, state, p, n, turned, step_x, step_z)
    size = largest if largest > size else size  # a nan, which comes from the tip, must stay
    # a step that does not shrink, or a large first one, may lead to another branch: not vouched for
    if size > min(LARGEST2, SHRINK2 * state[H_SIZE]) and size > ROUNDING2:
        state[H_DOUBT] += 1.0
    if state[H_NEGATIVE] != 2.0:
        state[H_DOUBT] += 1.0
    state[H_SIZE] = size


@kernel
def _elements(con, state, p, n):
    """Residual and tangent of every element, at its ends; sums over the elements into the head."""
    first_point, first_block = C_BASIS + 2 * p * (p + 1), N_HEAD
    dense_at = N_HEAD + (n + COLUMNS - 1) // COLUMNS * (N_ENDS + p * N_SAMPLES)
    for first in range(0, n, COLUMNS):
        points = con[first_point : first_point + p * N_BEAM]
        block = state[first_block : first_block + N_ENDS + p * N_SAMPLES]
        count = min(COLUMNS, n - first)
        m = min(COLUMNS, (count + 7) // 8 * 8)  # whole vectors; the rest of a row has no weight
        if p == 1:
            linear_elements(con, points, block, m, state)
        else:
            for g in range(p):
                samples(con, points[g * N_BEAM :], block[N_ENDS + g * N_SAMPLES :], m, state)
            for j in range(count):
                dense = state[dense_at : dense_at + (p + 1) * (p + 4)].reshape(p + 1, p + 4)
                assemble(con, p, points, block, j, dense)
                eliminate_inner(p, points, block, j, dense, state)
                dense_at += (p + 1) * (p + 4)
        first_point += p * N_BEAM
        first_block += N_ENDS + p * N_SAMPLES


@kernel
def _converge(con, state, step_tol2):
    """Newton's iteration; returns whether the chain holds a stable equilibrium that it accepts.

    The rules are those of `condensed.accepts`. Where it does not accept, that is no verdict.
    """
    state[H_SIZE], state[H_DOUBT] = np.inf, 0.0
    for _ in range(MAX_STEPS):
        newton_chain(con, state)
        if not state[H_SIZE] > step_tol2 or state[H_DOUBT] > 0.0:
            break
    return accepts_chain(state, step_tol2)


@kernel
def accepts_chain(state, step_tol2):
    """Whether the state holds a stable equilibrium, the squared size of the last step at most `step_tol2`."""
    return state[H_SIZE] <= step_tol2 and state[H_DOUBT] == 0.0


@kernel
def solve_chain(con, lam, wrench, step_tol2, state, x, z, theta, status):
    """Solve load cases one after another, each from the straight beam.

    con : constants, see `chain_constants.condense_chain`
    lam : (n, 2), wrench : (n, 3) or (1, 3), step_tol2 : largest squared last step
    state : (state_size,)   work space
    x, z, theta, status : (n,)   overwritten; CONVERGED, or NOT_CONVERGED where the general path must decide
    """
    last_wrench = wrench.shape[0] - 1
    state[L_GRAVITY], state[L_PRESTRAIN] = 1.0, 1.0
    for i in range(lam.shape[0]):
        state[:L_FX], state[L_FX:L_GRAVITY] = lam[i], wrench[min(i, last_wrench)]
        start_chain(con, state)
        status[i] = CONVERGED if _converge(con, state, step_tol2) else NOT_CONVERGED
        x[i], z[i], theta[i] = state[H_X], state[H_Z], state[H_THETA]


@kernel
def follow_chain(con, state, step_tol2, lam_l, lam_r):
    """Follow one load case to new tendon forces; starts again from the straight beam where that fails.

    Returns x, z, theta, status; the pose is nan where the status is not CONVERGED.
    """
    state[L_LAM_L], state[L_LAM_R] = lam_l, lam_r
    left, right = tendon_forces(con, state)
    if not (0.0 <= lam_l < np.inf and 0.0 <= lam_r < np.inf and min(left, right) >= -LARGEST_PUSH):
        return np.nan, np.nan, np.nan, INVALID_INPUT
    found = accepts_chain(state, step_tol2) and _converge(con, state, step_tol2)
    if not found:
        start_chain(con, state)
        found = _converge(con, state, step_tol2)
    if found:
        return state[H_X], state[H_Z], state[H_THETA], CONVERGED
    return np.nan, np.nan, np.nan, NOT_CONVERGED
