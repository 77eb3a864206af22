"""Batches of cases: the condensed path where it applies, the general path for the rest, in threads."""

import functools
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..mechanism.mesh.discretization import Discretization
from .equilibrium import BatchResult, Status
from .loads import loads_of, pushing
from .paths.chain import Chain
from .paths.condensed import Condensation, columns, solve_mechanisms
from .refinement import errors, is_smooth, solutions, solve_refined, stands

__all__ = ["fast_path", "solve_cases"]

Array = NDArray[np.float64]
# fewer cases than this do not pay for fitting where they start
WORTH_A_GUESS = 1024


def fast_path(mesh: Discretization, stations: Array, tip: Array, q_rest: Array) -> Condensation | Chain | None:
    """Return the fast path of one mechanism, from what `prepare` made of it; None where none applies."""
    return Condensation.from_system(mesh, stations, tip, q_rest) or Chain.from_system(mesh, stations, tip, q_rest)


def solve_cases(
    mesh: Discretization,
    fast: Condensation | Chain | None,
    par: Array,
    lam: Array,
    wrench: Array,
    step_tol2: float,
    threads: int,
    result: BatchResult | None = None,
    accuracy: float | None = None,
) -> BatchResult:
    """Solve every case, or say why not.

    Parameters
    ----------
    fast : the fast path of the one mechanism
    par : (1, n_parameters) that mechanism; or (n, n_parameters), one for each case
    lam : (n, 2), wrench : (1 or n, 3), step_tol2 : largest squared last step of Newton's method
    result : overwritten and returned; none: a new one
    accuracy : discretization error that is kept by refining what needs it; None: nothing is refined
    """
    n = len(lam)
    if result is None:
        x, z, theta, status, _ = columns(n)
        result = BatchResult(x, z, theta, status, np.ones(n), accuracy)
    else:
        result.load_factor.fill(1.0)
        if fast is None:  # else it overwrites every status
            result.status.fill(Status.NOT_CONVERGED)
    out, factor, doubt = (result.x, result.z, result.theta, result.status), result.load_factor, np.empty(n)
    guess = fast.fit_guess(lam.max(), wrench[0]) if fast and len(wrench) == 1 and n >= WORTH_A_GUESS else None
    settled: list[tuple[NDArray[np.intp], Array]] = []
    smooth = is_smooth(par)

    def part(rows: slice) -> None:
        results = out[0][rows], out[1][rows], out[2][rows], out[3][rows], doubt[rows]
        if not isinstance(fast, Condensation):
            results[4].fill(np.inf)
        loads = lam[rows], wrench if len(wrench) == 1 else wrench[rows]
        if fast is not None:
            fast.solve(*loads, step_tol2, results, guess)
        elif len(par) == n:
            solve_mechanisms(mesh, par[rows], *loads, step_tol2, results)
        open_ = results[3] != Status.CONVERGED
        if accuracy is not None:
            open_ |= ~((results[4] <= accuracy) & (smooth if len(smooth) == 1 else smooth[rows]))
        todo = rows.start + np.flatnonzero(open_)
        if todo.size:
            error = _finish(mesh, todo, par, lam, wrench, step_tol2, out, factor, accuracy)
            settled.append((todo, error))
            for column in results[:3]:
                column[results[3] > Status.UNSTABLE] = np.nan

    _in_threads(part, n, threads)
    refused = pushing(par, lam)
    if refused is not None:
        result.status[refused], result.load_factor[refused] = Status.INVALID_INPUT, 0.0
        for column in out[:3]:
            column[refused] = np.nan
    known = [] if accuracy is None else settled
    cases = mesh, par, lam.copy(), wrench.copy(), step_tol2
    preload_factors = functools.partial(_preload_factors, *cases, result.load_factor)
    result.postpone(accuracy, functools.partial(_errors, *cases, known), preload_factors)
    return result


def _finish(
    mesh: Discretization,
    todo: NDArray[np.intp],
    par: Array,
    lam: Array,
    wrench: Array,
    step_tol2: float,
    out: tuple[Array, Array, Array, NDArray[np.int64]],
    factor: Array,
    accuracy: float | None,
) -> Array:
    """Solve the cases `todo` on the general path, or refine what may be inaccurate; return the errors if estimated."""
    vectors, loads = par if len(par) == 1 else par[todo], (lam[todo], wrench if len(wrench) == 1 else wrench[todo])
    found = solutions(mesh, vectors, *loads, step_tol2)
    pose, status, load_factor, error = found.pose, found.status, found.load_factor, np.full(todo.size, np.nan)
    if accuracy is not None:
        error = errors(mesh, vectors, loads_of(*loads), found)
        left = np.flatnonzero(~stands((status, load_factor, error), accuracy))
        if left.size:
            rest = (
                vectors if len(vectors) == 1 else vectors[left],
                loads[0][left],
                loads[1] if len(loads[1]) == 1 else loads[1][left],
            )
            verdict = status[left], load_factor[left], error[left]
            pose[left], status[left], load_factor[left], error[left] = solve_refined(
                mesh, *rest, step_tol2, accuracy, verdict
            )
    for column, values in zip(out, (*pose.T, status), strict=True):
        column[todo] = values
    factor[todo] = load_factor
    return np.where(status <= Status.UNSTABLE, error, np.nan)


def _errors(
    mesh: Discretization,
    par: Array,
    lam: Array,
    wrench: Array,
    step_tol2: float,
    known: list[tuple[NDArray[np.intp], Array]],
) -> Array:
    """Return the estimated discretization errors of many cases, (n,), nan where there is no equilibrium.

    known : places of cases, and their errors
    """
    error, rest = np.empty(len(lam)), np.ones(len(lam), dtype=np.bool_)
    for rows, values in known:
        error[rows], rest[rows] = values, False
    cases = par if len(par) == 1 else par[rest], lam[rest], wrench if len(wrench) == 1 else wrench[rest]
    found = solutions(mesh, *cases, step_tol2)
    estimate = errors(mesh, cases[0], loads_of(*cases[1:]), found)
    error[rest] = np.where(found.status <= Status.UNSTABLE, estimate, np.nan)
    return error


def _preload_factors(
    mesh: Discretization, par: Array, lam: Array, wrench: Array, step_tol2: float, load_factor: Array
) -> Array:
    """Return what the necks carry of what acts without tendon forces and wrench, (n,)."""
    preload_factor, rest = np.ones(len(lam)), np.flatnonzero(load_factor == 0.0)
    some, cases = par if len(par) == 1 else par[rest], (lam[rest], wrench if len(wrench) == 1 else wrench[rest])
    preload_factor[rest] = solutions(mesh, some, *cases, step_tol2).preload_factor
    return preload_factor


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
