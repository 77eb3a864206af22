"""Discretization error of many equilibria, and the discretizations that keep an accuracy.

A case is refined in order first, then in elements, until its estimated error keeps the accuracy. Elements end where the
stiffness jumps: inside an element a jump leaves an error that falls only slowly with its length.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.general.batch import solve_many
from ..kernels.general.error import tip_errors
from ..kernels.general.newton import solve_work_size
from ..kernels.layout import L_FX, L_GRAVITY, N_OUT, N_STATION, N_TIP, O_FACTOR, O_PRELOAD, O_THETA, O_X, O_Z
from ..mechanism.mesh.discretization import Discretization
from ..mechanism.parameters import PLACES
from .body import lengths_of, piece_ends
from .equilibrium import Status
from .loads import LAM_PLACES, loads_of
from .paths.condensed import solve_nodes

__all__ = [
    "Solutions",
    "errors",
    "finer",
    "is_smooth",
    "jumps",
    "reached",
    "resolve",
    "solutions",
    "solve_refined",
    "stands",
    "work_arrays",
]

Array = NDArray[np.float64]
HIGHEST_ORDER, MOST_ELEMENTS = 6, 256  # the highest order with a fast path, and a bound on time
# the error of order 6 falls by 2^12 where elements are halved, in theory; 2^6 is counted on
FALL = 6.0
# errors above this are no measure of how much finer the elements must be
ROUGH = 1e-2
# a branch ends where the discretization error of its last equilibrium is below this, or where two discretizations
# differ by no more than this share of the load: near its end the tangent is singular, and the estimate large
BRANCH_END = 1e-3
# largest squared last Newton step that leaves nothing beside a discretization error
STEP_TOL2 = 1e-13
# more different places of jumps than this in one batch: no element ends at them
MOST_JUMPS = 8
# laws with a kink where a strain changes its sign: its place in an element decides over the error, and halving moves it
KINKS = [PLACES.effects_bimodulus, PLACES.effects_bending_amplitude]
# times as large as of smooth laws is the estimate then: 99 % of random worlds ask for 3.2 and 2.0
KINK = 3.0


_GROWING = [*LAM_PLACES, *range(L_FX, L_GRAVITY)]


Verdict = tuple[Any, Any, Any]
"""Status, load factor and estimated error of one case, or of many, (n,) each."""


class Solutions(NamedTuple):
    """Many solved cases with all their nodes.

    Attributes
    ----------
    q : (n, 3 n_nodes) the equilibrium, or the last one found on the branch
    status : (n,) values of `Status`
    pose : (n, 3) of the tip, that of the last one found on the branch where there is no equilibrium [m, m, rad]
    load_factor, preload_factor : (n,) see `Equilibrium`
    """

    q: Array
    status: NDArray[np.int64]
    pose: Array
    load_factor: Array
    preload_factor: Array


def work_arrays(mesh: Discretization) -> tuple[Array, Array, Array, Array, Array]:
    """Return stations, tip, q_rest, q and the work space of one thread."""
    n = 3 * mesh.nodes.size
    work = np.zeros(solve_work_size(mesh.nodes.size, mesh.n_elements, mesh.order))
    return np.zeros((len(mesh.mesh), N_STATION)), np.zeros(N_TIP), np.empty(n), np.empty(n), work


def reached(loads: Array, factor: Any) -> Array:
    """Return loads (n, N_LOADS) of which tendon forces and wrench have a share `factor` (n, 1), see `Equilibrium`."""
    loads = loads.copy()
    full = loads[..., _GROWING]
    loads[..., _GROWING] = np.multiply(full, factor, where=factor > 0.0, out=np.zeros_like(full))  # may be infinite
    return loads


def solutions(mesh: Discretization, par: Array, lam: Array, wrench: Array, step_tol2: float) -> Solutions:
    """Solve many cases into their nodes.

    par : (1 or n, n_parameters), lam : (n, 2), wrench : (1 or n, 3), step_tol2 : largest squared last Newton step
    """
    n = len(lam)
    q, status = np.empty((n, 3 * mesh.nodes.size)), np.full(n, Status.NOT_CONVERGED, dtype=np.int64)
    factor, preload_factor = np.ones(n), np.ones(n)
    solve_nodes(mesh, par, lam, wrench, step_tol2, q, status)
    pose = q[:, -3:].copy()
    todo = np.flatnonzero(status != Status.CONVERGED)
    if todo.size:
        mechanisms, loads = par if len(par) == 1 else par[todo], loads_of(lam, wrench)[todo]
        out, verdict, nodes = np.empty((todo.size, N_OUT)), status[todo], q[todo]
        solve_many(mesh.tables, mesh.mesh, mesh.nodes, mechanisms, loads, work_arrays(mesh), out, verdict, nodes)
        status[todo], q[todo], factor[todo] = verdict, nodes, out[:, O_FACTOR]
        preload_factor[todo] = out[:, O_PRELOAD]
        pose[todo] = out[:, [O_X, O_Z, O_THETA]]
    return Solutions(q, status, pose, factor, preload_factor)


def errors(mesh: Discretization, par: Array, loads: Array, found: Solutions) -> Array:
    """Estimate the discretization errors of the tip poses, (n,), in rad and shares of the length.

    par : (1 or n, n_parameters), loads : (n, N_LOADS)

    Where there is no equilibrium at full load, that of the last one on the branch: how far its end is to be trusted.
    Families without a kernel for it are solved again on elements of half the length; mechanisms whose stiffness jumps
    inside an element, on elements that end there too.
    """
    half = mesh.halved
    at = reached(loads, np.where(found.status <= Status.UNSTABLE, 1.0, found.load_factor)[:, None])
    kinks = np.where(par[:, KINKS].any(axis=1), KINK, 1.0)
    if mesh.family != "lagrange" or mesh.gauss != mesh.order:
        return kinks * _change(half, par, at, found.pose)
    error, known = np.empty(len(loads)), np.zeros(len(loads), dtype=np.int64)
    tip_errors(mesh.tables, mesh.halves, half.mesh, half.nodes, par, at, found.q, known, work_arrays(half), error)
    for i in np.flatnonzero(np.broadcast_to(par[:, PLACES.effects_soft_spot_size] != 0.0, len(loads))):
        one = par if len(par) == 1 else par[i : i + 1]
        fine = half.ending(jumps(one))
        if fine != half:
            error[i] = max(error[i], _change(fine, one, at[i : i + 1], found.pose[i : i + 1])[0])
    return kinks * error


def _change(mesh: Discretization, par: Array, loads: Array, pose: Array) -> Array:
    """Return what solving again on a finer mesh changes, twice as the kernel has it, (n,); inf where it fails."""
    again, status = np.empty((len(loads), N_OUT)), np.empty(len(loads), dtype=np.int64)
    no_nodes = np.empty((0, 3 * mesh.nodes.size))
    solve_many(mesh.tables, mesh.mesh, mesh.nodes, par, loads, work_arrays(mesh), again, status, no_nodes)
    length = lengths_of(par)[:, None]
    off = np.abs(again[:, [O_X, O_Z, O_THETA]] - pose) / np.hstack([length, length, np.ones_like(length)])
    return np.where(status <= Status.UNSTABLE, 2.0 * off.max(axis=1), np.inf)


def is_smooth(par: Array) -> NDArray[np.bool_]:
    """Return where the law of the section is smooth along the beam and in the strains, (n,); par : (n, n_parameters).

    Elsewhere a bound of the error that counts on the order of the elements says nothing.
    """
    return np.asarray(~par[:, [*KINKS, PLACES.effects_soft_spot_size]].any(axis=1))


def jumps(par: Array) -> tuple[float, ...]:
    """Return where the stiffness of any mechanism jumps, as shares of the mesh; none where they are too many.

    par : (n, n_parameters)
    """
    breaks = piece_ends(par)
    if breaks:
        return breaks
    spots = par[par[:, PLACES.effects_soft_spot_size] != 0.0]
    length = spots[:, PLACES.beam_length] + spots[:, PLACES.effects_beam_length]
    middle, half = spots[:, PLACES.effects_soft_spot_place], 0.5 * spots[:, PLACES.effects_soft_spot_width] / length
    ends = np.unique(np.concatenate([middle - half, middle + half]))
    inside = ends[(ends > 1e-6) & (ends < 1.0 - 1e-6)]
    return tuple(inside.tolist()) if inside.size <= MOST_JUMPS else ()


def finer(mesh: Discretization, error: float, accuracy: float, at: tuple[float, ...] = ()) -> Discretization | None:
    """Return the next finer discretization to try; None where there is none.

    error : estimated on `mesh`; at : shares of the length where elements end, see `jumps`
    """
    if mesh.n_elements == 1 and mesh.order < HIGHEST_ORDER and not at and error < ROUGH:
        return Discretization.from_elements(1, mesh.order + 1 if error < 30.0 * accuracy else HIGHEST_ORDER)
    if mesh.n_elements >= MOST_ELEMENTS:
        return None
    halvings = np.log2(error / accuracy) / FALL if accuracy < error < ROUGH and mesh.order == HIGHEST_ORDER else 1.0
    longest = max(mesh.shares) if mesh.n_elements > 1 or not at else 1.0
    longest *= 0.5 ** int(np.clip(np.ceil(halvings), 1, 3))
    pieces = np.diff([0.0, *at, 1.0])
    counts = np.ceil(pieces / longest * (1.0 - 1e-9)).astype(int)
    return Discretization.from_elements(np.repeat(pieces / counts, counts), HIGHEST_ORDER)


def stands(verdict: Verdict, accuracy: float, before: Verdict | None = None) -> NDArray[np.bool_]:
    """Return where a verdict stands, (n,): the error keeps the accuracy, or the branch ends for certain.

    before : of a coarser discretization
    """
    status, factor, error = verdict
    found = np.less_equal(status, Status.UNSTABLE)
    sure = np.equal(status, Status.INVALID_INPUT) | np.less_equal(error, np.where(found, accuracy, BRANCH_END))
    if before is not None:
        same = np.equal(status, before[0]) & (np.abs(np.subtract(factor, before[1])) < BRANCH_END)
        sure |= same & ~found
    return np.asarray(sure)


def resolve(
    mesh: Discretization, par: Array, lam: Array, wrench: Array, accuracy: Array | float
) -> tuple[Discretization, Array]:
    """Return one discretization on which every equilibrium keeps its accuracy, and the estimated errors on it, (n,).

    Parameters
    ----------
    mesh : where to start
    par : (1 or n, n_parameters), lam : (n, 2), wrench : (1 or n, 3)
    accuracy : in rad and shares of the length, one for all or (n,)

    Where none is fine enough, the finest, with errors above the accuracy. Errors are nan where there is no equilibrium.
    """
    at, loads = jumps(par), loads_of(lam, wrench)
    while True:
        found = solutions(mesh, par, lam, wrench, STEP_TOL2)
        error = np.where(found.status <= Status.UNSTABLE, errors(mesh, par, loads, found), np.nan)
        excess = np.nan_to_num(error / accuracy, nan=0.0)
        worst = int(np.argmax(excess)) if len(excess) else 0
        if not len(excess) or excess[worst] <= 1.0:
            return mesh, error
        asked = float(np.broadcast_to(accuracy, error.shape)[worst])
        next_ = finer(mesh, float(error[worst]), asked, at)
        if next_ is None:
            return mesh, error
        mesh = next_


def solve_refined(
    mesh: Discretization,
    par: Array,
    lam: Array,
    wrench: Array,
    step_tol2: float,
    accuracy: float,
    found: Verdict,
) -> tuple[Array, NDArray[np.int64], Array, Array]:
    """Solve cases on ever finer discretizations until the estimated error keeps the accuracy, or none is left.

    Parameters
    ----------
    mesh : where they were solved last
    found : status, load factor and estimated error there, (n,) each
    par : (1 or n, n_parameters), lam : (n, 2), wrench : (1 or n, 3), step_tol2 : largest squared last Newton step

    Returns
    -------
    Pose (n, 3), status (n,), load factor (n,) and error (n,).
    """
    n = len(lam)
    pose, at = np.empty((n, 3)), [jumps(each) for each in (par[None] if len(par) == 1 else par[:, None])]
    status, factor, error = (column.copy() for column in found)
    wrench = np.broadcast_to(wrench, (n, 3))
    todo, meshes = np.arange(n), np.array([mesh] * n, dtype=object)
    while todo.size:
        waiting: dict[Discretization, list[int]] = {}
        for i in todo:
            next_ = finer(meshes[i], float(error[i]), accuracy, at[i % len(at)])
            if next_ is not None:
                waiting.setdefault(next_, []).append(int(i))
        left: list[int] = []
        for next_, rows in waiting.items():
            some = par if len(par) == 1 else par[rows]
            new = solutions(next_, some, lam[rows], wrench[rows], step_tol2)
            estimate = errors(next_, some, loads_of(lam[rows], wrench[rows]), new)
            verdict = new.status, new.load_factor, estimate
            sure = stands(verdict, accuracy, (status[rows], factor[rows], error[rows]))
            pose[rows], (status[rows], factor[rows], error[rows]), meshes[rows] = new.pose, verdict, next_
            left += np.asarray(rows)[~sure].tolist()
        todo = np.array(sorted(left), dtype=np.intp)
    return pose, status, factor, error
