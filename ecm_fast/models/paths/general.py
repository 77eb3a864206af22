"""The control step on the general path."""

import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...kernels.condensed.step_memory import general_step, trail_size
from ...kernels.general.newton import solve, solve_work_size
from ...kernels.layout import CONVERGED, N_LOADS, N_OUT
from ...mechanism.mesh.discretization import Discretization

__all__ = ["StepCore", "System", "general_stepper", "without_forces"]

Array = NDArray[np.float64]
System = tuple[Array, Array, Array]
"""stations, tip, q_rest of the finite element model, see `kernels.prepare`."""


@dataclass(frozen=True)
class StepCore:
    """A control step as a function, and what belongs to it.

    Attributes
    ----------
    call : the function; calls from several threads wait for each other
    kept : what a call leaves for the next one
    jacobian, compliance : (3, 2), (3, 3) overwritten by each call, where it makes derivatives
    system : where the function takes its constants from, by name: an array and where in it each part begins
    followed : (1,) 1 where the last answer may be owed to the calls before, 0 where it depends on its arguments alone
    lock : held by calls that let go of the interpreter's lock
    last : returns the loads of the last call, (N_LOADS,), and its nodes, or None where these are not at hand
    """

    call: Callable[..., tuple[float, float, float, int]]
    kept: tuple[Array, ...]
    jacobian: Array
    compliance: Array
    system: tuple[Array, dict[str, int]]
    followed: Array
    lock: threading.Lock
    last: Callable[[], tuple[Array, Array | None]]


def general_stepper(mesh: Discretization, system: System, loads: Array, afresh: bool) -> StepCore:
    """Return the control step of the general path.

    loads : (N_LOADS,)   the dead wrench, which stays
    afresh : each step starts from the straight beam, not from the step before
    """
    constants = np.concatenate([system[0].ravel(), system[1]])  # of its own, in one array
    places = {"stations": 0, "tip": system[0].size}
    stations, tip = constants[: system[0].size].reshape(system[0].shape), constants[system[0].size :]
    loads, start = loads.copy(), without_forces(mesh, system, loads)
    trail, out, compliance, jacobian = start.copy(), np.empty(N_OUT), np.empty((3, 3)), np.empty((3, 2))
    followed = np.array([0.0 if afresh else 1.0])
    lock = threading.Lock()
    work = np.zeros(solve_work_size(mesh.nodes.size, mesh.n_elements, mesh.order))

    def step(lam_l: float, lam_r: float) -> tuple[float, float, float, int]:
        lam = float(lam_l), float(lam_r)
        with lock:
            result: tuple[float, float, float, int] = general_step(
                mesh.tables, stations, tip, start, trail, loads, work, out, compliance, jacobian, afresh, np.inf, *lam
            )
        return result

    def last() -> tuple[Array, Array | None]:
        return loads.copy(), None

    kept = trail, loads, jacobian, compliance
    return StepCore(step, kept, jacobian, compliance, (constants, places), followed, lock, last)


def without_forces(mesh: Discretization, system: System, loads: Array) -> Array:
    """Return loads and nodes of the equilibrium without tendon forces, (trail_size,), from which a control step starts.

    loads : (N_LOADS,), its tendon forces 0
    Where there is none, the straight beam under no load at all.
    """
    stations, tip, q_rest = system
    trail = np.zeros(trail_size(mesh.nodes.size))
    work = np.zeros(solve_work_size(mesh.nodes.size, mesh.n_elements, mesh.order))
    nodes = trail[N_LOADS + 1 :]
    status = solve(mesh.tables, stations, tip, q_rest, loads, nodes, work, np.empty(N_OUT))
    trail[:N_LOADS], trail[N_LOADS] = loads if status == CONVERGED else 0.0, 1.0
    if status != CONVERGED:
        nodes[:] = q_rest
    return trail
