"""Equilibria with tendons given by their length: their forces are unknowns beside the nodes.

A tendon of compliance c and free length l0 is taut with l - c lam = l0 and lam > 0, or slack with lam = 0 and l <= l0.
With K the tangent at given forces and g the derivative of the lengths by the nodes, Newton's step for the forces is

    S d_lam = l + g d_q - c lam - l0,   S = g K^-1 g^T + c      over the tendons that are taut

with d_q the step of the nodes at given forces; they move on by -K^-1 g^T d_lam. The equilibrium is stable under given
lengths where K has as many negative pivots as S has negative eigenvalues: none, but where the lengths hold what the
forces would not.
"""

import numpy as np

from .._jit import copy, kernel
from ..layout import (
    CONVERGED,
    L_LAM_3,
    N_LOADS,
    N_TENDONS,
    NOT_CONVERGED,
    T_LENGTH,
    T_TOLERANCE,
    UNSTABLE,
)
from .elements.lagrange import apply_step
from .newton import ROUNDING_FLOOR, step_size
from .tendon_lengths import tendon_derivatives, tendon_lengths

__all__ = ["LENGTHS_DEPEND", "MOST_STRIDES", "converge", "lengths_work_size", "place_of", "solve_lengths"]

LENGTHS_DEPEND = 100
"""Beside the statuses of `layout`: the given lengths depend on each other, some tendon needs a compliance."""
N_SMALL = 2 * N_TENDONS * N_TENDONS + 6 * N_TENDONS + 16  # numbers of `_converge` that do not grow with the mesh
# Newton steps of a stride, strides, and the least stride as a share of the way, where the branch counts as ended
MOST_STEPS, MOST_STRIDES, LEAST_STRIDE = 14, 200, 1e-6
# largest step of the nodes, in rad and shares of the length, of the first Newton step and of all
LARGEST_STEP = 0.5
# a pivot of S below this share of what it was has no sign to rely on
DEPENDENT = 1e-11


def lengths_work_size(n_nodes: int) -> int:
    """Return how many numbers `solve_lengths` needs as work space, beside that of `newton.solve`."""
    return 2 * N_TENDONS * 3 * n_nodes + N_SMALL + 2 * 3 * n_nodes + N_LOADS + 2 * N_TENDONS


@kernel
def place_of(tendon):
    """Place of a tendon's force among the loads."""
    return tendon if tendon < 2 else L_LAM_3 + tendon - 2


@kernel
def _solve_taut(S, taut, L, step):
    """Solve S step = step over the taut tendons by L D L^T without pivoting; the others' entries are not touched.

    S : (N_TENDONS, N_TENDONS), L : the same, overwritten, with D on its diagonal

    Returns the number of negative pivots, or -1 where one has no sign to rely on.
    """
    negative = 0
    for j in range(N_TENDONS):
        if taut[j] == 0.0:
            continue
        for i in range(j, N_TENDONS):
            L[i, j] = S[i, j]
            for k in range(j):
                if taut[k] != 0.0:
                    L[i, j] -= L[i, k] * L[j, k] * L[k, k]
            if i > j:
                L[i, j] /= L[j, j]
        if not abs(L[j, j]) > DEPENDENT * abs(S[j, j]):
            return -1
        negative += 1 if L[j, j] < 0.0 else 0
    for j in range(N_TENDONS):
        if taut[j] != 0.0:
            for k in range(j):
                if taut[k] != 0.0:
                    step[j] -= L[j, k] * step[k]
    for j in range(N_TENDONS - 1, -1, -1):
        if taut[j] != 0.0:
            step[j] /= L[j, j]
            for i in range(j + 1, N_TENDONS):
                if taut[i] != 0.0:
                    step[j] -= L[i, j] * step[i]
    return negative


@kernel
def _force_step(S, excess, forces, given, taut, L, step):
    """Newton's step of the forces, with those tendons taut that pull then, and those slack that are long enough.

    excess : (N_TENDONS,) by how much each tendon is too long at the nodes after their step, with the forces as they are
    taut : (N_TENDONS,) 1 or 0, as before; overwritten

    Returns what `_solve_taut` does.
    """
    negative = 0
    for _ in range(4 * N_TENDONS):
        for i in range(N_TENDONS):
            step[i] = 0.0
            if given[i] != 0.0:
                step[i] = excess[i] if taut[i] != 0.0 else -forces[i]
        for i in range(N_TENDONS):
            if taut[i] != 0.0:
                for k in range(N_TENDONS):
                    if given[k] != 0.0 and taut[k] == 0.0:
                        step[i] -= S[i, k] * step[k]
        negative = _solve_taut(S, taut, L, step)
        if negative < 0:
            return negative
        worst, which = 0.0, -1
        for i in range(N_TENDONS):  # the force below 0 that is farthest, else a slack tendon that is too long
            if taut[i] != 0.0 and forces[i] + step[i] < worst:
                worst, which = forces[i] + step[i], i
        for i in range(N_TENDONS):
            if which < 0 and given[i] != 0.0 and taut[i] == 0.0:
                left = excess[i]
                for k in range(N_TENDONS):
                    left -= S[i, k] * step[k] if given[k] != 0.0 else 0.0
                if left > 0.0:
                    which = i
        if which < 0:
            break
        taut[which] = 1.0 - taut[which]
    return negative


@kernel
def converge(basis, stations, tip, given, wanted, soft, loads, q, work, room):
    """Newton's iteration for nodes and forces at once; arguments as for `solve_lengths`, with `loads` overwritten.

    Returns the status, and whether the start was too far.
    """
    n = q.shape[0]
    nodal = room[: 2 * N_TENDONS * n].reshape(2, N_TENDONS, n)
    gradient, moved = nodal[0], nodal[1]
    small = room[2 * N_TENDONS * n :]
    S, L = small[:64].reshape(N_TENDONS, N_TENDONS), small[64:128].reshape(N_TENDONS, N_TENDONS)
    length, gain, excess, forces = small[128:136], small[136:144], small[144:152], small[152:160]
    taut, d_lam = small[160:168], small[168:176]
    step, spare = small[N_SMALL : N_SMALL + n], small[176:185].reshape(3, 3)
    before = np.inf
    for i in range(N_TENDONS):
        forces[i] = loads[place_of(i)] if given[i] != 0.0 else 0.0
        taut[i] = 1.0 if given[i] != 0.0 and forces[i] > 0.0 else 0.0
    for _ in range(MOST_STEPS):
        pivots = tendon_derivatives(basis, stations, tip, loads, q, work, step, length, gradient, gain, moved, spare)
        for i in range(N_TENDONS):
            excess[i] = 0.0
            if given[i] == 0.0:
                continue
            excess[i] = length[i] - soft[i] * forces[i] - wanted[i]
            for a in range(n):
                excess[i] += gradient[i, a] * step[a]
            for k in range(N_TENDONS):
                S[i, k] = soft[i] if i == k else 0.0
                if given[k] != 0.0:
                    for a in range(n):
                        S[i, k] -= gradient[i, a] * moved[k, a]
        negative = _force_step(S, excess, forces, given, taut, L, d_lam)
        if negative < 0:
            return LENGTHS_DEPEND
        for i in range(N_TENDONS):
            if given[i] != 0.0:
                forces[i] = forces[i] + d_lam[i] if taut[i] != 0.0 else 0.0
                loads[place_of(i)] = forces[i]
                for a in range(n):
                    step[a] += d_lam[i] * moved[i, a]
        size = step_size(step, tip[T_LENGTH])
        at_floor = size < tip[T_TOLERANCE] or (size < ROUNDING_FLOOR and size > 0.5 * before)
        if not (at_floor or (size <= LARGEST_STEP and size <= 0.7 * before)):
            return NOT_CONVERGED
        before = size
        apply_step(basis, q, step, work[work.shape[0] - n :])
        if at_floor:
            return CONVERGED if pivots == negative else UNSTABLE
    return NOT_CONVERGED


@kernel
def solve_lengths(basis, stations, tip, given, wanted, soft, loads, q, work, room, most):
    """Follow an equilibrium until tendons have their given lengths.

    basis : of Lagrange elements; stations, tip : as in `front.newton_step`, gain 1 and zero 0 for these tendons
    given : (N_TENDONS,) 1 where the length is given, 0 where the force is
    wanted, soft : (N_TENDONS,) free length [m] and compliance [m/N] of the former
    loads : (N_LOADS,)    those of the equilibrium `q`; overwritten with those found
    q : (3 n_nodes,)      a stable equilibrium; overwritten
    work : see `newton.solve_work_size`; room : see `lengths_work_size`
    most : largest number of strides

    Returns a status of `layout`, or `LENGTHS_DEPEND`, and which share of the way was gone. The lengths go from those of
    `q` to the wanted ones in strides that the solver chooses.
    """
    n = q.shape[0]
    kept = room[room.shape[0] - n - N_LOADS - N_TENDONS :]
    last_q, last_loads, target = kept[:n], kept[n : n + N_LOADS], kept[n + N_LOADS :]
    begin = room[room.shape[0] - n - N_LOADS - 2 * N_TENDONS : room.shape[0] - n - N_LOADS - N_TENDONS]
    gradient = room[: n * N_TENDONS].reshape(N_TENDONS, n)
    tendon_lengths(basis, stations, tip, q, begin, gradient, target)
    for i in range(N_TENDONS):  # a tendon that pulls already is as long as its compliance lets it be
        begin[i] -= soft[i] * loads[place_of(i)] if given[i] != 0.0 else 0.0
    copy(q, last_q)
    copy(loads, last_loads)
    reached, stride, status = 0.0, 1.0, NOT_CONVERGED
    for _ in range(most):
        share = min(1.0, reached + stride)
        for i in range(N_TENDONS):
            target[i] = wanted[i] if share == 1.0 else begin[i] + share * (wanted[i] - begin[i])
        copy(last_q, q)
        copy(last_loads, loads)
        status = converge(basis, stations, tip, given, target, soft, loads, q, work, room)
        if status == CONVERGED:
            reached, stride = share, 1.5 * stride
            copy(q, last_q)
            copy(loads, last_loads)
            if share == 1.0:
                return status, 1.0
        else:
            stride *= 0.4
        if stride < LEAST_STRIDE or status == LENGTHS_DEPEND:
            break
    copy(last_q, q)
    copy(last_loads, loads)
    return (status if status in (LENGTHS_DEPEND, UNSTABLE) else NOT_CONVERGED), reached
