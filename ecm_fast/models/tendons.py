"""Tendons of a solved case: lengths, forces and their derivatives; and cases with tendons given by length."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..kernels.general.lengths import LENGTHS_DEPEND, lengths_work_size
from ..kernels.general.lengths import solve_lengths as follow
from ..kernels.general.newton import solve, solve_work_size
from ..kernels.general.tendons import tendon_derivatives
from ..kernels.layout import CONVERGED, N_OUT, N_TENDONS, O_ITERATIONS
from ..kernels.prepare import prepare
from ..mechanism.body import TENDON
from ..mechanism.parameters import FIRST_TENDON
from ..mesh.discretization import Discretization
from .loads import LAM_PLACES
from .refinement import work_arrays

__all__ = ["TendonState", "by_length", "tendon_state"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TendonState:
    """Tendons at an equilibrium; m of them.

    Attributes
    ----------
    lengths : (m,) of their paths: along the body, of a chord free and wrapped around its pulley up to a constant [m]
    jacobian : (3, m) d(x, z, theta)/d(reading of the force cell) [m/N, m/N, rad/N]
    moved : (m, 3 n_nodes) derivative of the nodes by tendon force
    dlength_dlam : (m, m) derivative of the lengths by the readings [m/N], symmetric where the gains are alike
    dlength_dq : (m, 3 n_nodes) derivative of the lengths by the nodes
    compliance : (3, 3) tip pose by a dead wrench at Q
    """

    lengths: Array
    jacobian: Array
    moved: Array
    dlength_dlam: Array
    dlength_dq: Array
    compliance: Array


def tendon_state(mesh: Discretization, par: Array, loads: Array, q: Array, m: int) -> TendonState:
    """Return the state of the first `m` tendons at an equilibrium.

    par : (n_parameters,), loads : (N_LOADS,), q : (3 n_nodes,)
    """
    if mesh.family != "lagrange":
        raise InputError(f"family {mesh.family}: lengths of tendons are known of Lagrange's elements alone")
    stations, tip, q_rest, step, work = work_arrays(mesh)
    prepare(par, mesh.mesh, mesh.nodes, stations, tip, q_rest)
    length, gain, compliance = np.empty(N_TENDONS), np.empty(N_TENDONS), np.empty((3, 3))
    gradient, moved = np.empty((N_TENDONS, q.size)), np.empty((N_TENDONS, q.size))
    tendon_derivatives(mesh.tables, stations, tip, loads, q, work, step, length, gradient, gain, moved, compliance)
    moved, gradient = moved[:m], gradient[:m]
    by_reading = gain[:m, None] * moved
    return TendonState(length[:m], by_reading[:, -3:].T, moved, gradient @ by_reading.T, gradient, compliance)


class ByLength(NamedTuple):
    """A case with tendons given by length.

    Attributes
    ----------
    status : of `kernels.layout`, or `LENGTHS_DEPEND`
    q : (3 n_nodes,), loads : (N_LOADS,) the equilibrium, or the last one found, and the forces there
    iterations : Newton steps until the first equilibrium, with the given forces alone
    """

    status: int
    q: Array
    loads: Array
    iterations: int


def by_length(mesh: Discretization, par: Array, loads: Array, wanted: Array) -> ByLength:
    """Solve a case with some tendons given by their free length.

    par : (n_parameters,), loads : (N_LOADS,) with 0 for these tendons
    wanted : (m,) free lengths [m], nan for tendons given by force
    """
    par = par.copy()
    given, target, soft = np.zeros(N_TENDONS), np.zeros(N_TENDONS), np.zeros(N_TENDONS)
    for i in np.flatnonzero(np.isfinite(wanted)):
        row = par[FIRST_TENDON + TENDON.size * i :]
        given[i], target[i], soft[i] = 1.0, wanted[i], row[TENDON["compliance"]]
        row[TENDON["gain"]] = row[TENDON["zero"]] = 0.0  # of a cell that nobody reads
    stations, tip, q_rest, q, _ = work_arrays(mesh)
    work, out = np.zeros(solve_work_size(mesh.nodes.size, mesh.n_elements, mesh.order)), np.empty(N_OUT)
    prepare(par, mesh.mesh, mesh.nodes, stations, tip, q_rest)
    loads = loads.copy()
    status = solve(mesh.tables, stations, tip, q_rest, loads, q, work, out)
    if status == CONVERGED:
        room = np.zeros(lengths_work_size(mesh.nodes.size))
        status = follow(mesh.tables, stations, tip, given, target, soft, loads, q, work, room)
    if status == LENGTHS_DEPEND:
        raise InputError("the given lengths depend on each other: more inextensible tendons than the pose has freedom; "
                         "give one of them a compliance [m/N], or its force instead")  # fmt: skip
    return ByLength(int(status), q, loads, int(out[O_ITERATIONS]))


def forces_of(loads: Array, m: int) -> Array:
    """Return the tendon forces among the kernels' loads, (m,)."""
    return loads[list(LAM_PLACES[:m])]
