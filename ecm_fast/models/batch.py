"""Batches of cases: the condensed path where it applies, the general path for the rest, in threads."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..kernels.general.batch import solve_many
from ..kernels.layout import N_OUT, O_FACTOR, O_THETA, O_X, O_Z
from ..mesh.discretization import Discretization
from .equilibrium import BatchResult, Status
from .loads import pushing
from .paths.chain import Chain
from .paths.condensed import Columns, Condensation, columns, solve_mechanisms
from .refinement import loads_of, work_arrays

__all__ = ["fast_path", "solve_cases"]

Array = NDArray[np.float64]
# fewer cases than this do not pay for fitting where they start
WORTH_A_GUESS = 1024


def fast_path(mesh: Discretization, stations: Array, tip: Array, q_rest: Array) -> Condensation | Chain | None:
    """Return the fast path of one mechanism, from what `prepare` made of it; None where none applies."""
    return Condensation.of(mesh, stations, tip, q_rest) or Chain.of(mesh, stations, tip, q_rest)


def solve_cases(
    mesh: Discretization,
    fast: Condensation | Chain | None,
    par: Array,
    lam: Array,
    wrench: Array,
    last2: float,
    threads: int,
    result: BatchResult | None = None,
) -> BatchResult:
    """Solve every case, or say why not.

    Parameters
    ----------
    fast : the fast path of the one mechanism
    par : (1, n_parameters) that mechanism; or (n, n_parameters), one for each case
    lam : (n, 2), wrench : (1 or n, 3), last2 : largest squared last step of Newton's method
    result : overwritten and returned; none: a new one
    """
    n = len(lam)
    if result is None:
        result = BatchResult(*columns(n), np.ones(n))
    else:
        result.load_factor.fill(1.0)
        if fast is None:  # else it overwrites every status
            result.status.fill(Status.NOT_CONVERGED)
    out, factor = (result.x, result.z, result.theta, result.status), result.load_factor
    guess = fast.fit_guess(lam.max(), wrench[0]) if fast and len(wrench) == 1 and n >= WORTH_A_GUESS else None

    def part(rows: slice) -> None:
        own = out[0][rows], out[1][rows], out[2][rows], out[3][rows]
        loads = lam[rows], wrench if len(wrench) == 1 else wrench[rows]
        if fast is not None:
            fast.solve(*loads, last2, own, guess)
        elif len(par) == n:
            solve_mechanisms(mesh, par[rows], *loads, last2, own)
        todo = rows.start + np.flatnonzero(own[3] != Status.CONVERGED)
        if todo.size:
            _finish(mesh, todo, par, lam, wrench, out, factor)
            for column in own[:3]:
                column[own[3] > Status.UNSTABLE] = np.nan

    _in_threads(part, n, threads)
    refused = pushing(par, lam)
    if refused is not None:
        result.status[refused], result.load_factor[refused] = Status.INVALID_INPUT, 0.0
        for column in out[:3]:
            column[refused] = np.nan
    return result


def _finish(
    mesh: Discretization, todo: NDArray[np.intp], par: Array, lam: Array, wrench: Array, out: Columns, factor: Array
) -> None:
    """Solve the cases `todo` with the robust solver."""
    loads = loads_of(lam[todo], wrench if len(wrench) == 1 else wrench[todo])
    result, verdict = np.empty((todo.size, N_OUT)), np.empty(todo.size, dtype=np.int64)
    own, no_nodes = par if len(par) == 1 else par[todo], np.empty((0, 3 * mesh.nodes.size))
    solve_many(mesh.tables, mesh.mesh, mesh.nodes, own, loads, work_arrays(mesh), result, verdict, no_nodes)
    for column, place in zip(out, (O_X, O_Z, O_THETA), strict=False):
        column[todo] = result[:, place]
    out[3][todo], factor[todo] = verdict, result[:, O_FACTOR]


def _in_threads(part: Callable[[slice], None], n: int, threads: int) -> None:
    """Call `part` with slices that cover n rows, on as many threads."""
    share = max(1, -(-n // max(1, threads)))
    chunks = [slice(first, min(n, first + share)) for first in range(0, n, share)]
    if len(chunks) < 2:
        for chunk in chunks:
            part(chunk)
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(len(chunks)) as pool:
        list(pool.map(part, chunks))
