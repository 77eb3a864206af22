"""The state of a control step, and its fallback to the general path.

Everything a control step needs lies in one array, whose address alone is passed: an argument that is an array costs
an allocation a call, an address costs none. `settings` are the largest squared last step, whether derivatives are
wanted, and up to which tendon force each step starts afresh from a polynomial (0: from the step before; below 0:
each starts from the straight beam).
"""

import math

import numpy as np

from .._jit import copy, kernel
from ..general.newton import advance, solve_work_size
from ..general.sensitivity import tip_derivatives
from ..general.tip import force_slopes
from ..layout import (
    L_LAM_L,
    L_LAM_R,
    N_LOADS,
    N_OUT,
    N_STATION,
    N_TIP,
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
    UNSTABLE,
)
from .formulation import constants_size, state_size
from .initial_guess import N_GUESS

__all__ = ["CONSTANT", "memory_size", "pieces", "rescue", "unfold"]

# parts of the memory that no step changes
CONSTANT = ("settings", "con", "coefficients", "tables", "stations", "tip", "q_rest")


def pieces(order: int) -> dict[str, tuple[int, tuple[int, ...]]]:
    """Return where each part of the memory begins, and its shape."""
    shapes: dict[str, tuple[int, ...]] = {
        "settings": (3,),
        "con": (constants_size(order),),
        "state": (state_size(order),),
        "before": (7 + order,),
        "columns": (6,),
        "jacobian": (3, 2),
        "compliance": (3, 3),
        "coefficients": (5 + order, N_GUESS),
        "loads": (N_LOADS,),
        "tables": (3, order, order + 1),
        "stations": (order, N_STATION),
        "tip": (N_TIP,),
        "q_rest": (3 * (order + 1),),
        "q": (3 * (order + 1),),
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
def unfold(con, state, columns, compliance, jacobian):
    """Compliance (3, 3) from its lower triangle `columns`, and the jacobian (3, 2) = compliance P of (40)."""
    for i in range(3):
        for k in range(i + 1):
            compliance[i, k] = compliance[k, i] = columns[i * (i + 1) // 2 + k]
    for i in range(3):
        c_x, c_z, c_t = compliance[i, 0], compliance[i, 1], compliance[i, 2]
        jacobian[i, 0] = c_x * state[R_LX] + c_z * state[R_LZ] + c_t * state[R_LT]
        jacobian[i, 1] = c_x * state[R_RX] + c_z * state[R_RZ] + c_t * state[R_RT]
    force_slopes(con, state[R_LAM_L], state[R_LAM_R], jacobian)


@kernel
def rescue(tables, stations, tip, q_rest, loads, q, work, out, compliance, jacobian, afresh, lam_l, lam_r):
    """Take the step with the robust solver, from its own last equilibrium `q` or, `afresh`, from the straight beam.

    Returns x, z, theta, status; what is not an equilibrium, and its derivatives, are nan.
    """
    if afresh:
        copy(q_rest, q)
    loads[L_LAM_L], loads[L_LAM_R] = lam_l, lam_r
    status = advance(tables, stations, tip, q_rest, loads, q, work, out)
    if status > UNSTABLE:
        compliance[:], jacobian[:] = np.nan, np.nan
        return np.nan, np.nan, np.nan, status
    n = q.shape[0]
    tip_derivatives(tables, stations, tip, loads, q, work[2 * n + N_LOADS :], work[:n], compliance, jacobian)
    return out[O_X], out[O_Z], out[O_THETA], status
