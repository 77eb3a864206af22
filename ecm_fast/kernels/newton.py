"""The solver: the equilibrium on the stable branch that grows from the unloaded state, or a status that says why not.

First Newton goes from the straight beam to the full load at once; that is accepted only where it was a quiet
walk through stable states. Otherwise the load grows from zero in steps that the solver chooses, and every
step must end in a stable equilibrium near the one before.
"""

import numpy as np

from ._jit import kernel
from .front import newton_step, work_size
from .layout import (
    CONVERGED,
    N_LOADS,
    NON_FINITE,
    NOT_CONVERGED,
    O_FACTOR,
    O_FREE_LENGTH,
    O_ITERATIONS,
    O_KXX,
    O_THETA,
    O_X,
    O_Z,
    T_LENGTH,
    TENDON_ZERO_LENGTH,
    UNSTABLE,
)

__all__ = ["solve", "solve_work_size"]

# the last step's size, in rad and shares of the length; Newton squares it once more
TOLERANCE = 1e-9
# below this a step that no longer shrinks is rounding (large EA against EI), not progress
ROUNDING_FLOOR = 1e-6
MAX_ITERATIONS = 12
# a first step larger than this is no small correction
FULL_LOAD_LIMIT, LOAD_STEP_LIMIT = 0.8, 0.2
FIRST_LOAD_STEP, LAST_LOAD_STEP, MAX_LOAD_STEPS = 0.125, 1e-8, 2000
# a tendon this short, as a share of the beam's length, where the branch ends: it is what ended it
SHORT_TENDON = 0.05


def solve_work_size(n_nodes: int, n_elements: int, order: int) -> int:
    """Return how many numbers `solve` needs as work space."""
    return 9 * n_nodes + N_LOADS + work_size(n_elements, order)


@kernel
def solve(basis, stations, tip, q_rest, loads, q, work, out):
    """Solve one load case from the unloaded state.

    basis, stations, tip : as in `front.newton_step`
    q_rest : (3 n_nodes,)   the straight beam in its clamp
    loads : (N_LOADS,)      tendon forces [N], dead wrench [N, N, N m], share of gravity
    work : see `solve_work_size`
    q : (3 n_nodes,), out : (N_OUT,)   overwritten; an equilibrium for CONVERGED and UNSTABLE, else the last one found

    Returns the status, see `layout`.
    """
    out[:] = np.nan
    out[O_ITERATIONS], out[O_FACTOR] = 0.0, 0.0
    q[:] = q_rest
    for i in range(N_LOADS):
        if not np.isfinite(loads[i]):
            return NON_FINITE
    n = q.shape[0]
    status = _correct(basis, stations, tip, loads, q, work[3 * n + N_LOADS :], work[:n], out, FULL_LOAD_LIMIT, 0.5)
    out[O_FACTOR] = 1.0
    if status != CONVERGED:
        status = _follow(basis, stations, tip, q_rest, loads, q, work, out)
    out[O_X], out[O_Z], out[O_THETA] = q[n - 3], q[n - 2], q[n - 1]
    return status


@kernel
def _correct(basis, stations, tip, loads, q, work, step, out, limit, shrink):
    """Newton's iteration at fixed loads, from `q`: stops where a step exceeds `limit` or does not shrink enough.

    shrink : the largest ratio of two successive steps; below 1 every iterate must be stable too
    """
    before = np.inf
    for _ in range(MAX_ITERATIONS):
        not_positive, out[O_FREE_LENGTH] = newton_step(basis, stations, tip, loads, q, work, step, out[O_KXX:])
        size = _step_size(step, tip[T_LENGTH])
        out[O_ITERATIONS] += 1.0
        at_floor = size < TOLERANCE or (size < ROUNDING_FLOOR and size > 0.5 * before)
        if not (at_floor or size <= limit):
            return NOT_CONVERGED
        if not_positive > 0 and shrink < 1.0:
            return UNSTABLE
        for i in range(q.shape[0]):
            q[i] += step[i]
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
def _follow(basis, stations, tip, q_rest, loads, q, work, out):
    """Let all loads grow from zero along the stable branch; where it ends, say why."""
    n = q.shape[0]
    q[:] = q_rest
    out[O_FACTOR] = 0.0
    work[n : 2 * n] = q_rest
    reached = _walk(basis, stations, tip, loads, q, work, out, 0.0, True)
    out[O_FACTOR] = reached
    if reached == 1.0:
        return CONVERGED
    if out[O_FREE_LENGTH] < SHORT_TENDON * tip[T_LENGTH]:
        return TENDON_ZERO_LENGTH
    if reached > 0.0 and _walk(basis, stations, tip, loads, q, work, out, reached, False) == 1.0:
        return UNSTABLE
    return NOT_CONVERGED


@kernel
def _walk(basis, stations, tip, loads, q, work, out, start, stable):
    """Follow equilibria from the load factor `start`, at `q`, towards 1; returns the factor reached.

    stable : every equilibrium must be stable; otherwise none may be

    Each load step starts on the line through the last two equilibria, and its length follows how well that went.
    """
    n = q.shape[0]
    step, last, before = work[:n], work[n : 2 * n], work[2 * n : 3 * n]
    scaled, rest = work[3 * n : 3 * n + N_LOADS], work[3 * n + N_LOADS :]
    wanted = CONVERGED if stable else UNSTABLE
    reached, stride, stride_before = start, FIRST_LOAD_STEP, 0.0
    free_length = out[O_FREE_LENGTH]
    last[:] = q
    for i in range(MAX_LOAD_STEPS):
        # the unloaded state itself may need solving: a beam cast with a curvature
        factor = start if i == 0 and start == 0.0 else min(1.0, reached + stride)
        scaled[:] = loads
        scaled *= factor
        ahead = (factor - reached) / stride_before if stride_before > 0.0 else 0.0
        for k in range(n):
            q[k] = last[k] + ahead * (last[k] - before[k])
        status = _correct(basis, stations, tip, scaled, q, rest, step, out, LOAD_STEP_LIMIT, 0.5 if stable else 1.0)
        if status == wanted:
            stride_before = factor - reached
            before[:] = last
            last[:] = q
            reached, free_length = factor, out[O_FREE_LENGTH]
            if reached == 1.0:
                break
            stride *= 1.5
        else:
            stride *= 0.4
            if stride < LAST_LOAD_STEP or (i == 0 and start == 0.0):
                break
    q[:] = last
    out[O_FREE_LENGTH] = free_length
    return reached
