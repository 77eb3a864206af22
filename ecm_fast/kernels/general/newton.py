"""The general solver: the equilibrium on the stable branch from the unloaded state, or a failure status.

First Newton goes from the straight beam to the full load at once; that is accepted only where it was a quiet
walk through stable states. Otherwise the load grows from zero in steps that the solver chooses, and every
step must end in a stable equilibrium near the one before. What acts without tendon forces and wrench comes first: what
strains the beam, then the weight. Only then do tendon forces and wrench grow, together.

With tendons guided along the body, a load step begins with its first order, from the tangent at the loads before.
Such a tendon presses on a body that does not press back yet: the tangent at the new loads is that of a column that
buckles, and Newton from there took seven times as many steps.
"""

import numpy as np

from ...mechanism.catalogue import LARGEST_PUSH
from .._jit import copy, kernel
from ..layout import (
    CONVERGED,
    INVALID_INPUT,
    L_GRAVITY,
    L_LAM_3,
    L_LAM_L,
    L_LAM_R,
    L_PRESTRAIN,
    N_LOADS,
    NOT_CONVERGED,
    O_FACTOR,
    O_ITERATIONS,
    O_KXX,
    O_PRELOAD,
    O_THETA,
    O_X,
    O_Z,
    S_GUIDES,
    SECTION_UNSTABLE,
    T_FURTHER,
    T_LENGTH,
    T_TOLERANCE,
    TENDON_ZERO_LENGTH,
    UNSTABLE,
)
from ..prepare import is_top_heavy
from .elements.dispatch import apply_step, element_residual, sizes
from .front import band_of, newton_step, solve_factored, work_size
from .section_failure import LOST, section_fails, softens
from .tip import tendon_forces, tip_wrench

__all__ = ["ROUNDING_FLOOR", "advance", "solve", "solve_work_size", "step_size"]

# below this a step that no longer shrinks is rounding (large EA against EI), not progress
ROUNDING_FLOOR = 1e-6
MAX_ITERATIONS = 12  # at fixed loads; steps must halve at least, so twelve reach 2e-4 of the first one
# a first step larger than this is no small correction
FULL_LOAD_LIMIT, LOAD_STEP_LIMIT = 1.0, 0.4
# shares of the way: tried first, and so small that the branch has ended there; a bound on time
FIRST_LOAD_STEP, LAST_LOAD_STEP, MAX_LOAD_STEPS = 0.125, 1e-8, 250
# a tendon this short, as a share of the beam's length, where the branch ends: it is what ended it
SHORT_TENDON = 0.05


def solve_work_size(n_nodes: int, n_elements: int, order: int) -> int:
    """Return how many numbers `solve` needs as work space."""
    return 9 * n_nodes + 4 * N_LOADS + work_size(n_elements, order)


@kernel
def solve(tables, stations, tip, q_rest, loads, q, work, out):
    """Solve one load case from the unloaded state.

    tables, stations, tip : as in `front.newton_step`
    q_rest : (3 n_nodes,)   the straight beam in its clamp
    loads : (N_LOADS,)      tendon forces [N], dead wrench [N, N, N m]; shares of what acts without them, both 1
    work : see `solve_work_size`
    q : (3 n_nodes,), out : (N_OUT,)   overwritten; an equilibrium for CONVERGED and UNSTABLE, else the last one found

    Returns the status, see `layout`.
    """
    out[:] = np.nan
    out[O_ITERATIONS], out[O_FACTOR], out[O_PRELOAD] = 0.0, 0.0, 0.0
    copy(q_rest, q)
    if not _possible(tip, loads):
        return INVALID_INPUT
    n = q.shape[0]
    rest, step = work[2 * n + 4 * N_LOADS :], work[:n]
    limit = FULL_LOAD_LIMIT
    if _is_guided(stations, tip):
        none = work[2 * n : 2 * n + N_LOADS]
        none[:] = 0.0
        size = _first_order(tables, stations, tip, none, loads, q, rest, step, out)
        limit = 0.5 * size if size <= FULL_LOAD_LIMIT else 0.0
        if limit > 0.0:
            apply_step(tables, q, step, rest[rest.shape[0] - n :])
    status = NOT_CONVERGED
    if not is_top_heavy(stations, tip, q_rest[2]):
        status = _correct(tables, stations, tip, loads, q, rest, step, out, limit, 0.5, np.inf)
    out[O_FACTOR], out[O_PRELOAD] = 1.0, 1.0
    if status != CONVERGED:
        status = _follow(tables, stations, tip, q_rest, loads, q, work, out)
    _put_pose(tip, loads, q, rest, out)
    return status


@kernel
def advance(tables, stations, tip, base, loads, q, work, out, most):
    """Follow the equilibrium `q` under the loads `base` to the loads `loads`, in at most `most` Newton steps.

    base : (N_LOADS + 1,)   overwritten: loads of the last stable equilibrium on the way, so that another call goes on
                            from there, and the share of the rest of the way to try first; 0 where the branch ends
    q : (3 n_nodes,)        overwritten: that equilibrium; all else as for `solve`

    Returns the status: CONVERGED, INVALID_INPUT, TENDON_ZERO_LENGTH where a tendon without length is what ends the
    branch, else NOT_CONVERGED.
    """
    out[O_ITERATIONS] = 0.0
    if not _possible(tip, loads):
        return INVALID_INPUT
    reached, stride = _walk(tables, stations, tip, base, loads, q, work, out, 0.0, base[N_LOADS], True, most)
    for i in range(N_LOADS):
        base[i] = loads[i] if reached == 1.0 else base[i] + reached * (loads[i] - base[i])
    base[N_LOADS] = 1.0 if reached == 1.0 else min(1.0, stride / (1.0 - reached))
    rest = work[2 * q.shape[0] + 4 * N_LOADS :]
    if reached == 1.0:
        _put_pose(tip, loads, q, rest, out)
        return CONVERGED
    return TENDON_ZERO_LENGTH if stride == 0.0 and _tendon_is_short(tip, loads, q, rest) else NOT_CONVERGED


@kernel
def _put_pose(tip, loads, q, work, out):
    """Write down the pose of Q: the tip section's, but for a joint that lets the head turn further."""
    n = q.shape[0]
    out[O_X], out[O_Z], out[O_THETA] = q[n - 3], q[n - 2], q[n - 1]
    if tip[T_FURTHER] != 0.0:
        _, out[O_THETA] = tip_wrench(tip, loads, q[n - 3], q[n - 2], q[n - 1], work[6:9], work)


@kernel
def _possible(tip, loads):
    """Whether the mechanism can be built, every load is a finite number, and the tendons pull."""
    for i in range(N_LOADS):
        if not np.isfinite(loads[i]):
            return False
    lam_l, lam_r = tendon_forces(tip, loads)
    pull = min(loads[L_LAM_L], loads[L_LAM_R]) >= 0.0 and min(lam_l, lam_r) >= -LARGEST_PUSH
    for i in range(L_LAM_3, N_LOADS):
        pull = pull and loads[i] >= 0.0
    return pull and tip[T_LENGTH] > 0.0


@kernel
def _correct(tables, stations, tip, loads, q, work, step, out, limit, shrink, most):
    """Newton's iteration at fixed loads, from `q`: stops where a step exceeds `limit` or does not shrink enough.

    shrink : the largest ratio of two successive steps; below 1 every iterate must be stable too
    most : stops too where `out` counts that many iterations
    """
    before = np.inf
    for _ in range(MAX_ITERATIONS):
        if out[O_ITERATIONS] >= most:
            break
        not_positive, _ = newton_step(tables, stations, tip, loads, q, work, step, out[O_KXX:])
        size = step_size(step, tip[T_LENGTH])
        out[O_ITERATIONS] += 1.0
        at_floor = size < tip[T_TOLERANCE] or (size < ROUNDING_FLOOR and size > 0.5 * before)
        if not (at_floor or size <= limit):
            return NOT_CONVERGED
        if not_positive > 0 and shrink < 1.0:
            return UNSTABLE
        apply_step(tables, q, step, work[work.shape[0] - q.shape[0] :])
        if at_floor:
            return UNSTABLE if not_positive > 0 or softens(tables, stations, loads, q) else CONVERGED
        limit = shrink * size
        before = size
    return NOT_CONVERGED


@kernel
def _is_guided(stations, tip):
    """Whether a tendon is guided along the body, whose clamp does not give way."""
    for i in range(stations.shape[0]):
        if stations[i, S_GUIDES] > 0.0:
            return tip[T_FURTHER] == 0.0
    return False


@kernel
def _first_order(tables, stations, tip, before, loads, q, work, step, out):
    """Put the first order of the way from the equilibrium `q` under `before` to that under `loads` into `step`.

    Returns its size, inf where the tangent at `before` is not that of a stable equilibrium.
    """
    n_gauss, n_a = sizes(tables)
    n, m = q.shape[0], 3 * n_a
    not_positive, _ = newton_step(tables, stations, tip, before, q, work, step, out[O_KXX:])
    out[O_ITERATIONS] += 1.0
    if not_positive > 0:
        return np.inf
    step[:] = 0.0
    for e in range(stations.shape[0] // n_gauss):
        first = e * (m - 3)
        points = stations[e * n_gauss : (e + 1) * n_gauss]
        element_residual(tables, points, loads, q[first : first + m], step[first : first + m])
    tip_wrench(tip, loads, q[n - 3], q[n - 2], q[n - 1], work[:3], work[3:9])
    for i in range(3):
        step[n - 3 + i] -= work[i]
    for i in range(n):
        step[i] = -step[i]
    solve_factored(band_of(work, m, n), m - 3, out[O_KXX:], step, 3)
    return step_size(step, tip[T_LENGTH])


@kernel
def step_size(step, length):
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
    """Let what acts grow from nothing along the stable branch, stage after stage; where the branch ends, say why."""
    n = q.shape[0]
    base, goal = work[2 * n + N_LOADS : 2 * n + 2 * N_LOADS], work[2 * n + 2 * N_LOADS : 2 * n + 3 * N_LOADS]
    out[O_FACTOR], out[O_PRELOAD] = 0.0, 0.0
    base[:], goal[:] = 0.0, 0.0
    goal[L_PRESTRAIN] = loads[L_PRESTRAIN]
    copy(q_rest, q)
    # a beam cast with a curvature gets there in one step, however large
    reached, _ = _walk(tables, stations, tip, base, goal, q, work, out, 0.0, np.inf, True, np.inf)
    if reached == 1.0:
        base[L_PRESTRAIN], goal[L_GRAVITY] = loads[L_PRESTRAIN], loads[L_GRAVITY]
        out[O_PRELOAD], _ = _walk(tables, stations, tip, base, goal, q, work, out, 0.0, 1.0, True, np.inf)
        if out[O_PRELOAD] == 1.0:
            base[L_GRAVITY] = loads[L_GRAVITY]
        else:  # the neck does not carry its weight alone, perhaps it does with the loads
            base[L_PRESTRAIN], goal[L_GRAVITY] = 0.0, 0.0
            copy(q_rest, q)
            _walk(tables, stations, tip, base, goal, q, work, out, 0.0, np.inf, True, np.inf)
            base[L_PRESTRAIN] = loads[L_PRESTRAIN]
        copy(loads, goal)
        reached, _ = _walk(tables, stations, tip, base, goal, q, work, out, 0.0, FIRST_LOAD_STEP, True, np.inf)
        if reached == 1.0:
            out[O_FACTOR] = 1.0
            return CONVERGED
    if out[O_PRELOAD] == 1.0:
        out[O_FACTOR] = reached
    if _tendon_is_short(tip, loads, q, work[2 * n + 4 * N_LOADS :]):
        return TENDON_ZERO_LENGTH
    now = work[2 * n : 2 * n + N_LOADS]
    for i in range(N_LOADS):
        now[i] = base[i] + reached * (goal[i] - base[i])
    if section_fails(tables, stations, now, q, LOST, True):
        return SECTION_UNSTABLE
    if reached == 0.0 or base[L_PRESTRAIN] == 0.0:
        return NOT_CONVERGED
    reached, _ = _walk(tables, stations, tip, base, goal, q, work, out, reached, FIRST_LOAD_STEP, False, np.inf)
    return UNSTABLE if reached == 1.0 else NOT_CONVERGED


@kernel
def _tendon_is_short(tip, loads, q, work):
    """Whether a tendon that pulls under `loads` has next to no free length at `q`, or ends within its pulley."""
    n = q.shape[0]
    free, _ = tip_wrench(tip, loads, q[n - 3], q[n - 2], q[n - 1], work[6:9], work)
    return not free >= SHORT_TENDON * tip[T_LENGTH]


@kernel
def _walk(tables, stations, tip, base, goal, q, work, out, start, stride, stable, most):
    """Follow equilibria on the way from the loads `base` to `goal`.

    Returns the share of the way that was reached, and the share to try next, 0 where the branch ends.

    start : share at which `q` is an equilibrium
    stride : share to try first; inf: the whole way, however large Newton's steps are
    stable : every equilibrium must be stable; otherwise none may be
    most : stops where `out` counts that many Newton steps

    Each load step starts at the equilibrium before, and its length follows how well that went.
    """
    n = q.shape[0]
    step, last = work[:n], work[n : 2 * n]
    now, before = work[2 * n : 2 * n + N_LOADS], work[2 * n + 3 * N_LOADS : 2 * n + 4 * N_LOADS]
    rest = work[2 * n + 4 * N_LOADS :]
    wanted, shrink = CONVERGED if stable else UNSTABLE, 0.5 if stable else 1.0
    limit = LOAD_STEP_LIMIT if stride < np.inf else np.inf
    guided = stride < np.inf and stable and _is_guided(stations, tip)
    reached, stride = start, 1.0 if guided else stride
    copy(q, last)
    for _ in range(MAX_LOAD_STEPS):
        stride = min(stride, 1.0 - reached)
        factor = 1.0 if reached + stride >= 1.0 - LAST_LOAD_STEP else reached + stride
        for i in range(N_LOADS):
            now[i] = goal[i] if factor == 1.0 else base[i] + factor * (goal[i] - base[i])
        copy(last, q)
        if guided:
            for i in range(N_LOADS):
                before[i] = base[i] + reached * (goal[i] - base[i])
            size = _first_order(tables, stations, tip, before, now, q, rest, step, out)
            if not size < np.inf:
                stride = 0.0
                break
            share = min(1.0, LOAD_STEP_LIMIT / max(size, LOAD_STEP_LIMIT))  # of loads, which enter linearly
            factor = factor if share == 1.0 else reached + share * (factor - reached)
            stride = share * stride
            for i in range(N_LOADS):
                now[i] = goal[i] if factor == 1.0 else base[i] + factor * (goal[i] - base[i])
            for i in range(n):
                step[i] *= share
            apply_step(tables, q, step, rest[rest.shape[0] - n :])
        if _correct(tables, stations, tip, now, q, rest, step, out, limit, shrink, most) == wanted:
            copy(q, last)
            reached = factor
            stride *= 1.5
        else:
            stride *= 0.4
        limit = LOAD_STEP_LIMIT
        stride = stride if stride >= LAST_LOAD_STEP else 0.0
        if reached == 1.0 or stride == 0.0 or out[O_ITERATIONS] >= most:
            break
    copy(last, q)
    return reached, stride
