"""Batches of load cases or of mechanisms on the general path."""

from .._jit import kernel
from ..prepare import prepare
from .newton import solve

__all__ = ["solve_many"]


@kernel
def solve_many(tables, mesh, nodes, par, loads, system, out, status, all_q):
    """Solve case after case, each from the unloaded state.

    tables, mesh, nodes : the discretization, see `Discretization`
    par : (1 or n, n_parameters)   one mechanism for all cases, or one for each
    loads : (n, N_LOADS)
    system : work arrays of one thread: stations, tip, q_rest, q, work
    out : (n, N_OUT), status : (n,)   overwritten
    all_q : (n, 3 n_nodes)   overwritten with the nodes; or (0, 3 n_nodes) where they are not wanted
    """
    stations, tip, q_rest, q, work = system
    for i in range(loads.shape[0]):
        if i < par.shape[0]:
            prepare(par[i], mesh, nodes, stations, tip, q_rest)
        status[i] = solve(tables, stations, tip, q_rest, loads[i], q, work, out[i])
        if i < all_q.shape[0]:
            all_q[i] = q
