"""Tendons of a solved case: lengths, forces and their derivatives; and cases with tendons given by length."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import InputError
from ...kernels.general.lengths import LENGTHS_DEPEND, MOST_STRIDES, lengths_work_size
from ...kernels.general.lengths import solve_lengths as follow
from ...kernels.general.newton import solve, solve_work_size
from ...kernels.general.tendon_lengths import tendon_derivatives
from ...kernels.general.tip import tendon_forces
from ...kernels.layout import CONVERGED, N_OUT, N_TENDONS, O_ITERATIONS
from ...kernels.prepare import prepare
from ...mechanism.body import TENDON
from ...mechanism.mechanism import Mechanism
from ...mechanism.mesh.discretization import Discretization
from ...mechanism.parameters import FIRST_TENDON
from ..loads import LAM_PLACES, forces_by_name, numbers
from ..refinement import work_arrays
from ..tendon_state import TendonState

__all__ = ["ByLength", "by_length", "given_lengths", "tendon_state", "without_given"]

Array = NDArray[np.float64]
FREEDOM = 3  # of a pose in the plane


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
    forces = _forces(par, tip, loads, m)
    return TendonState(forces, length[:m], by_reading[:, -3:].T, moved, gradient @ by_reading.T, compliance)


class ByLength(NamedTuple):
    """A case with tendons given by length.

    Attributes
    ----------
    status : of `kernels.layout`
    q : (3 n_nodes,), loads : (N_LOADS,) the equilibrium, or the last one found, and the forces there
    par : (n_parameters,) of the mechanism, without the errors of force cells that nobody reads
    factor : share of the way to the given lengths that was gone; 0 where there is no equilibrium without their forces
    iterations : Newton steps to the equilibrium without their forces
    """

    status: int
    q: Array
    loads: Array
    par: Array
    factor: float
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
    loads, factor = loads.copy(), 0.0
    status = solve(mesh.tables, stations, tip, q_rest, loads, q, work, out)
    if status == CONVERGED:
        room = np.zeros(lengths_work_size(mesh.nodes.size))
        status, factor = follow(mesh.tables, stations, tip, given, target, soft, loads, q, work, room, MOST_STRIDES)
    if status == LENGTHS_DEPEND:
        raise InputError("the given lengths depend on each other: more inextensible tendons than the pose has freedom; "
                         "give one of them a compliance [m/N], or its force instead")  # fmt: skip
    return ByLength(int(status), q, loads, par, float(factor), int(out[O_ITERATIONS]))


def _forces(par: Array, tip: Array, loads: Array, m: int) -> Array:
    """Return tendon forces, (m,), from the readings of the force cells among the loads."""
    if par[FIRST_TENDON + TENDON["route"]] == 0.0:
        return np.array(tendon_forces(tip, loads))[:m]
    rows = par[FIRST_TENDON : FIRST_TENDON + TENDON.size * m].reshape(m, TENDON.size)
    return np.asarray((1.0 + rows[:, TENDON["gain"]]) * loads[list(LAM_PLACES[:m])] + rows[:, TENDON["zero"]])


def without_given(loads: Array, wanted: Array) -> Array:
    """Return loads (N_LOADS,) without the forces of tendons given by length, see `by_length`."""
    loads = loads.copy()
    loads[np.array(LAM_PLACES[: len(wanted)])[np.isfinite(wanted)]] = 0.0
    return loads


def given_lengths(mechanism: Mechanism, lengths: ArrayLike | Mapping[str, float], loads: ArrayLike) -> Array:
    """Return free lengths of tendons given by length, (m,) [m], nan for those given by force; or raise.

    lengths : by name, or (m,) with nan; loads : of which the forces of tendons given by length must be 0
    """
    names = mechanism.tendon_names
    if mechanism.has_pair:
        raise InputError("lengths: allowed for [[tendon]]s, whose paths are known; the pair of [tendons] "
                         "is given by force")  # fmt: skip
    if isinstance(lengths, Mapping):
        forces_by_name(lengths, names)
        lengths = [lengths.get(name, np.nan) for name in names]
    wanted = numbers("lengths", lengths)
    if wanted.shape != (len(names),):
        raise InputError(f"lengths have shape {wanted.shape}: allowed is ({len(names)},): {', '.join(names)}")
    wrong = np.isinf(wanted) | (wanted <= 0.0)
    if wrong.any():
        which = int(np.argmax(wrong))
        raise InputError(f"length of {names[which]} = {wanted[which]} m: allowed is a number above 0")
    forces = np.asarray(loads)[[place for place in LAM_PLACES[: len(names)] if place < np.size(loads)]]
    twice = np.flatnonzero(np.isfinite(wanted[: len(forces)]) & (forces != 0.0))
    if twice.size:
        raise InputError(f"tendon {names[twice[0]]} is given by force and by length: allowed is one of them")
    chords = [tendon.name for tendon, length in zip(mechanism.named_tendons, wanted, strict=True)
              if tendon.route == "chord" and np.isfinite(length) and tendon.compliance == 0.0]  # fmt: skip
    if len(chords) > FREEDOM:
        raise InputError(f"chords given by length without compliance: {', '.join(chords)}, more than the {FREEDOM} "
                         "freedoms of the pose; give one a compliance [m/N], or its force")  # fmt: skip
    return wanted
