"""The control step of a robot with named tendons, each driven by its force or by its length."""

import numpy as np

from .._jit import copy, kernel
from ..layout import CONVERGED, INVALID_INPUT, N_LOADS, N_TENDONS, NOT_CONVERGED, UNSTABLE
from .lengths import LENGTHS_DEPEND, converge, place_of, solve_lengths
from .newton import advance

__all__ = ["tendon_step"]

MOST_STRIDES_A_CALL = 8
"""Strides to given lengths in one call, of up to 14 Newton steps each, where one does not lead there."""


@kernel
def tendon_step(basis, stations, tip, start, trail, given, wanted, soft, loads, work, room, out, most):
    """Go on from the last equilibrium to that under new forces and lengths.

    basis, stations, tip, room : as in `lengths.solve_lengths`; work : as there, and room for all nodes
    start, trail : (N_LOADS + 1 + 3 n_nodes,)   loads, the share of a way to try first, and nodes of an equilibrium: of
        `start` without tendon forces, of `trail` the last one, overwritten
    given, wanted, soft : (N_TENDONS,) as in `lengths.solve_lengths`
    loads : (N_LOADS,)   overwritten: the loads; forces of tendons given by length are put in
    out : (N_OUT,)       overwritten; most : largest number of Newton steps at given forces

    Returns the status. Where a call ran out of Newton steps the next one goes on from where it came to, where the
    branch ended from `start`.
    """
    base, q = trail[: N_LOADS + 1], trail[N_LOADS + 1 :]
    kept, work = work[work.shape[0] - q.shape[0] :], work[: work.shape[0] - q.shape[0]]
    by_length = False
    for i in range(N_TENDONS):
        if given[i] != 0.0:
            by_length = True
            if not 0.0 < wanted[i] < np.inf:
                return INVALID_INPUT
            loads[place_of(i)] = base[place_of(i)]
    if by_length:
        copy(q, kept)
        status = converge(basis, stations, tip, given, wanted, soft, loads, q, work, room)
        if status == CONVERGED:
            copy(loads, base)
            return status
        copy(kept, q)
        for i in range(N_TENDONS):
            if given[i] != 0.0:
                loads[place_of(i)] = base[place_of(i)]
    base[N_LOADS] = 1.0
    status = advance(basis, stations, tip, base, loads, q, work, out, most)
    if status == CONVERGED and by_length:
        status, _ = solve_lengths(basis, stations, tip, given, wanted, soft, loads, q, work, room, MOST_STRIDES_A_CALL)
        copy(loads, base)
    if status != CONVERGED and status != INVALID_INPUT and base[N_LOADS] == 0.0:
        copy(start, trail)
    return NOT_CONVERGED if status in (LENGTHS_DEPEND, UNSTABLE) else status
