"""The state of a control step, and its fallback to the general path.

Everything a control step needs lies in one array, whose address alone is passed: an argument that is an array costs
an allocation a call, an address costs none. `settings` are the largest squared last step, whether derivatives are
wanted, and up to which tendon force each step starts afresh from a polynomial (0: from the step before; below 0:
each starts from the straight beam).

Where the fast path does not vouch, the general path follows the last equilibrium to the new forces, in at most
`MOST_STEPS` Newton steps. What it does not finish is NOT_CONVERGED; the next call goes on from where it came to, or,
where the branch that was followed ends, from the equilibrium without tendon forces.
"""

import math

import numpy as np

from ...mechanism.catalogue import LARGEST_PUSH
from .._jit import copy, kernel, step_kernel
from ..general.newton import advance, solve_work_size
from ..general.sensitivity import tip_derivatives
from ..general.tip import force_slopes
from ..layout import (
    CONVERGED,
    L_FX,
    L_LAM_L,
    L_LAM_R,
    N_LOADS,
    N_OUT,
    N_STATION,
    N_TIP,
    NOT_CONVERGED,
    O_ITERATIONS,
    O_THETA,
    O_X,
    O_Z,
    R_LAM_L,
    R_LAM_R,
    R_LT,
    R_LX,
    R_LZ,
    R_RT,
    R_RX,
    R_RZ,
    TENDON_ZERO_LENGTH,
)
from .formulation import clear_record, constants_size, nodes_of, state_size
from .initial_guess import N_GUESS, recall
from .physics import forces

__all__ = [
    "CONSTANT",
    "MOST_STEPS",
    "general_step",
    "hand_over",
    "memory_size",
    "pieces",
    "pulls",
    "symmetric_from_lower",
    "trail_size",
]

# parts of the memory that no step changes
CONSTANT = ("settings", "con", "coefficients", "tables", "slopes", "stations", "tip", "start")
# Newton steps of the general path in one control step: 60 us at order 6 (measured), those of the fast path included
MOST_STEPS = 12
# forces that differ by less than this share from those of the call before ask for the same way
SAME = 0.01


def trail_size(n_nodes: int) -> int:
    """Return how many numbers an equilibrium of the general path has: `base` of `newton.advance`, and the nodes."""
    return N_LOADS + 1 + 3 * n_nodes


def pieces(order: int) -> dict[str, tuple[int, tuple[int, ...]]]:
    """Return where each part of the memory begins, and its shape."""
    shapes: dict[str, tuple[int, ...]] = {
        "settings": (3,),
        "con": (constants_size(order),),
        "state": (state_size(order),),
        "followed": (1,),
        "before": (7 + order,),
        "columns": (6,),
        "jacobian": (3, 2),
        "compliance": (3, 3),
        "coefficients": (5 + order, N_GUESS),
        "loads": (N_LOADS,),
        "tables": (3, order, order + 1),
        "slopes": (order, order),
        "stations": (order, N_STATION),
        "tip": (N_TIP,),
        "start": (trail_size(order + 1),),
        "trail": (trail_size(order + 1),),
        "out": (N_OUT,),
        "work": (solve_work_size(order + 1, 1, order),),
    }
    places, first = {}, 0
    for name, shape in shapes.items():
        places[name] = (first, shape)
        first += math.prod(shape)
    return places


def memory_size(order: int) -> int:
    """Return how many numbers the memory holds."""
    return sum(math.prod(shape) for _, shape in pieces(order).values())


@kernel
def symmetric_from_lower(con, state, columns, compliance, jacobian):
    """Compliance (3, 3) from its lower triangle `columns`, and the jacobian (3, 2) = compliance P of (40)."""
    for i in range(3):
        for k in range(i + 1):
            compliance[i, k] = compliance[k, i] = columns[i * (i + 1) // 2 + k]
    for i in range(3):
        c_x, c_z, c_t = compliance[i, 0], compliance[i, 1], compliance[i, 2]
        jacobian[i, 0] = c_x * state[R_LX] + c_z * state[R_LZ] + c_t * state[R_LT]
        jacobian[i, 1] = c_x * state[R_RX] + c_z * state[R_RZ] + c_t * state[R_RT]
    force_slopes(con, state[R_LAM_L], state[R_LAM_R], jacobian)


@step_kernel
def pulls(con, lam_l, lam_r):
    """Whether the tendons pull: readings finite and not below 0, and no cell so far off that a tendon pushes."""
    if not (0.0 <= lam_l < np.inf and 0.0 <= lam_r < np.inf):
        return False
    left, right = forces(con, 1, 0, lam_l, lam_r)
    return left >= -LARGEST_PUSH and right >= -LARGEST_PUSH


@kernel
def hand_over(con, state, before, tables, slopes, order, loads, trail):
    """Make the last equilibrium of the fast path, `before`, that of the general path, `trail`; `state` is used up."""
    recall(state, before, order)
    nodes_of(con, state, tables, slopes, order, trail[N_LOADS + 1 :])
    clear_record(state, 1, 0)
    trail[:L_FX], trail[L_FX:N_LOADS], trail[N_LOADS] = before[:L_FX], loads[L_FX:], 1.0


@kernel
def general_step(
    tables, stations, tip, start, trail, loads, work, out, compliance, jacobian, afresh, most, lam_l, lam_r
):
    """Take the step on the general path, from its last equilibrium `trail` or, `afresh`, from that without forces.

    start, trail : (trail_size,)   loads and nodes of an equilibrium; of `start` without tendon forces
    most : largest number of Newton steps

    Returns x, z, theta, status; what is not an equilibrium, and its derivatives, are nan.
    """
    if afresh:
        copy(start, trail)
    base, q = trail[: N_LOADS + 1], trail[N_LOADS + 1 :]
    if abs(lam_l - loads[L_LAM_L]) + abs(lam_r - loads[L_LAM_R]) > SAME * (lam_l + lam_r):
        base[N_LOADS] = 1.0  # another way than the last call's: try the whole of it first
    loads[L_LAM_L], loads[L_LAM_R] = lam_l, lam_r
    status = advance(tables, stations, tip, base, loads, q, work, out, most)
    if NOT_CONVERGED <= status <= TENDON_ZERO_LENGTH:
        ended = base[N_LOADS] == 0.0  # the branch that was followed leads no further
        if ended:
            copy(start, trail)
        if ended and not afresh:
            status = advance(tables, stations, tip, base, loads, q, work, out, most - out[O_ITERATIONS])
    if status != CONVERGED:
        compliance[:], jacobian[:] = np.nan, np.nan
        return np.nan, np.nan, np.nan, status
    n = q.shape[0]
    tip_derivatives(tables, stations, tip, loads, q, work[2 * n + 4 * N_LOADS :], work[:n], compliance, jacobian)
    return out[O_X], out[O_Z], out[O_THETA], status
