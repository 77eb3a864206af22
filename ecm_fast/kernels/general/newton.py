"""The general solver: the equilibrium on the stable branch from the unloaded state, or a failure status.

First Newton goes from the straight beam to the full load at once; that is accepted only where it was a quiet
walk through stable states. Otherwise the load grows from zero in steps that the solver chooses, and every
step must end in a stable equilibrium near the one before.
"""

import numpy as np

from .._jit import copy, kernel
from ..layout import (
    CONVERGED,
    INVALID_INPUT,
    L_LAM_L,
    L_LAM_R,
    N_LOADS,
    NOT_CONVERGED,
    O_FACTOR,
    O_FREE_LENGTH,
    O_ITERATIONS,
    O_KXX,
    O_THETA,
    O_X,
    O_Z,
    T_FURTHER,
    T_LENGTH,
    T_TOLERANCE,
    TENDON_ZERO_LENGTH,
    UNSTABLE,
)
from .elements.dispatch import take
from .front import newton_step, work_size
from .tip import tip_wrench

__all__ = ["advance", "solve", "solve_work_size"]

# below this a step that no longer shrinks is rounding (large EA against EI), not progress
ROUNDING_FLOOR = 1e-6
MAX_ITERATIONS = 12
# a first step larger than this is no small correction
FULL_LOAD_LIMIT, LOAD_STEP_LIMIT = 1.0, 0.4
FIRST_LOAD_STEP, LAST_LOAD_STEP, MAX_LOAD_STEPS = 0.125, 1e-8, 250
# a tendon this short, as a share of the beam's length, where the branch ends: it is what ended it
SHORT_TENDON = 0.05


def solve_work_size(n_nodes: int, n_elements: int, order: int) -> int:
    """Return how many numbers `solve` needs as work space."""
    return 9 * n_nodes + N_LOADS + work_size(n_elements, order)


@kernel
def solve(tables, stations, tip, q_rest, loads, q, work, out):
    """Solve one load case from the unloaded state.

    tables, stations, tip : as in `front.newton_step`
    q_rest : (3 n_nodes,)   the straight beam in its clamp
    loads : (N_LOADS,)      tendon forces [N], dead wrench [N, N, N m], share of gravity
    work : see `solve_work_size`
    q : (3 n_nodes,), out : (N_OUT,)   overwritten; an equilibrium for CONVERGED and UNSTABLE, else the last one found

    Returns the status, see `layout`.
    """
    out[:] = np.nan
    out[O_ITERATIONS], out[O_FACTOR] = 0.0, 0.0
    copy(q_rest, q)
    if not _possible(loads):
        return INVALID_INPUT
    n = q.shape[0]
    status = _correct(tables, stations, tip, loads, q, work[2 * n + N_LOADS :], work[:n], out, FULL_LOAD_LIMIT, 0.5)
    out[O_FACTOR] = 1.0
    if status != CONVERGED:
        status = _follow(tables, stations, tip, q_rest, loads, q, work, out)
    _put_pose(tip, loads, q, work[2 * n + N_LOADS :], out)
    return status


@kernel
def advance(tables, stations, tip, q_rest, loads, q, work, out):
    """Follow an equilibrium `q` to loads that changed a little; solves from the unloaded state where that fails.

    Arguments and result as for `solve`, but `q` is where to start from.
    """
    n = q.shape[0]
    if _possible(loads):
        out[O_ITERATIONS], out[O_FACTOR] = 0.0, 1.0
        rest, step = work[2 * n + N_LOADS :], work[:n]
        if _correct(tables, stations, tip, loads, q, rest, step, out, LOAD_STEP_LIMIT, 0.5) == CONVERGED:
            _put_pose(tip, loads, q, rest, out)
            return CONVERGED
    return solve(tables, stations, tip, q_rest, loads, q, work, out)


@kernel
def _put_pose(tip, loads, q, work, out):
    """Write down the pose of Q: the tip section's, but for a joint that lets the head turn further."""
    n = q.shape[0]
    out[O_X], out[O_Z], out[O_THETA] = q[n - 3], q[n - 2], q[n - 1]
    if tip[T_FURTHER] != 0.0:
        _, out[O_THETA] = tip_wrench(tip, loads, q[n - 3], q[n - 2], q[n - 1], work[6:9], work)


@kernel
def _possible(loads):
    """Whether every load is a finite number and no tendon pushes."""
    for i in range(N_LOADS):
        if not np.isfinite(loads[i]):
            return False
    return loads[L_LAM_L] >= 0.0 and loads[L_LAM_R] >= 0.0


@kernel
def _correct(tables, stations, tip, loads, q, work, step, out, limit, shrink):
    """Newton's iteration at fixed loads, from `q`: stops where a step exceeds `limit` or does not shrink enough.

    shrink : the largest ratio of two successive steps; below 1 every iterate must be stable too
    """
    before = np.inf
    for _ in range(MAX_ITERATIONS):
        not_positive, out[O_FREE_LENGTH] = newton_step(tables, stations, tip, loads, q, work, step, out[O_KXX:])
        size = _step_size(step, tip[T_LENGTH])
        out[O_ITERATIONS] += 1.0
        at_floor = size < tip[T_TOLERANCE] or (size < ROUNDING_FLOOR and size > 0.5 * before)
        if not (at_floor or size <= limit):
            return NOT_CONVERGED
        if not_positive > 0 and shrink < 1.0:
            return UNSTABLE
        take(tables, q, step, work[work.shape[0] - q.shape[0] :])
        if at_floor:
            return UNSTABLE if not_positive > 0 else CONVERGED
        limit = shrink * size
        before = size
    return NOT_CONVERGED


@kernel
def _step_size(step, length):
    """Largest entry of a step, lengths as shares of the beam's length; inf when one is not finite."""
    size = 0.0
    for i in range(step.shape[0]):
        entry = abs(step[i]) if i % 3 == 2 else abs(step[i]) / length
        if not entry < np.inf:
            return np.inf
        size = max(size, entry)
    return size


@kernel
def _follow(tables, stations, tip, q_rest, loads, q, work, out):
    """Let all loads grow from zero along the stable branch; where it ends, say why."""
    copy(q_rest, q)
    out[O_FACTOR] = 0.0
    reached = _walk(tables, stations, tip, loads, q, work, out, 0.0)
    out[O_FACTOR] = reached
    if reached == 1.0:
        return CONVERGED
    if out[O_FREE_LENGTH] < SHORT_TENDON * tip[T_LENGTH]:
        return TENDON_ZERO_LENGTH
    if reached > 0.0 and _walk(tables, stations, tip, loads, q, work, out, reached) == 1.0:
        return UNSTABLE
    return NOT_CONVERGED


@kernel
def _walk(tables, stations, tip, loads, q, work, out, start):
    """Follow equilibria from the load factor `start`, at `q`, towards 1; returns the factor reached.

    From 0 on every equilibrium must be stable; from farther on, where the stable branch ends, none may be. Each load
    step starts at the equilibrium before, and its length follows how well that went.
    """
    n = q.shape[0]
    step, last = work[:n], work[n : 2 * n]
    scaled, rest = work[2 * n : 2 * n + N_LOADS], work[2 * n + N_LOADS :]
    stable = start == 0.0
    wanted = CONVERGED if stable else UNSTABLE
    reached, stride = start, FIRST_LOAD_STEP
    free_length = out[O_FREE_LENGTH]
    copy(q, last)
    for i in range(MAX_LOAD_STEPS):
        # the unloaded state itself needs solving for a beam cast with a curvature: one step, however large
        unloaded = i == 0 and start == 0.0
        factor = 0.0 if unloaded else min(1.0, reached + stride)
        limit = np.inf if unloaded else LOAD_STEP_LIMIT
        for k in range(N_LOADS):
            scaled[k] = factor * loads[k]
        copy(last, q)
        status = _correct(tables, stations, tip, scaled, q, rest, step, out, limit, 0.5 if stable else 1.0)
        if status == wanted:
            copy(q, last)
            reached, free_length = factor, out[O_FREE_LENGTH]
            if reached == 1.0:
                break
            stride *= 1.5
        else:
            stride *= 0.4
            if stride < LAST_LOAD_STEP or unloaded:
                break
    copy(last, q)
    out[O_FREE_LENGTH] = free_length
    return reached
