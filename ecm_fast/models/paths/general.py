"""The control step on the general path."""

import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...kernels.condensed.control_step import rescue
from ...kernels.general.newton import solve_work_size
from ...kernels.layout import N_OUT
from ...mesh.discretization import Discretization

__all__ = ["Step", "StepCore", "System", "robust_stepper"]

Array = NDArray[np.float64]
Step = Callable[[float, float], tuple[float, float, float, int]]
"""x, z, theta, status by the forces of the left and the right tendon."""
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
    lock : held by calls that let go of the interpreter's lock
    """

    call: Callable[..., tuple[float, float, float, int]]
    kept: tuple[Array, ...]
    jacobian: Array
    compliance: Array
    system: tuple[Array, dict[str, int]]
    lock: threading.Lock


def robust_stepper(mesh: Discretization, system: System, loads: Array, afresh: bool) -> StepCore:
    """Return the control step of the robust solver.

    loads : (N_LOADS,)   the dead wrench, which stays
    afresh : each step starts from the straight beam, not from the step before
    """
    constants = np.concatenate([system[0].ravel(), system[1]])  # of its own, in one array
    places = {"stations": 0, "tip": system[0].size}
    stations, tip, q_rest = constants[: system[0].size].reshape(system[0].shape), constants[system[0].size :], system[2]
    loads, q, out, compliance, jacobian = (
        loads.copy(),
        q_rest.copy(),
        np.empty(N_OUT),
        np.empty((3, 3)),
        np.empty((3, 2)),
    )
    lock = threading.Lock()
    work = np.zeros(solve_work_size(mesh.nodes.size, mesh.n_elements, mesh.order))

    def step(lam_l: float, lam_r: float) -> tuple[float, float, float, int]:
        lam = float(lam_l), float(lam_r)
        with lock:
            result: tuple[float, float, float, int] = rescue(
                mesh.tables, stations, tip, q_rest, loads, q, work, out, compliance, jacobian, afresh, *lam
            )
        return result

    return StepCore(step, (q, jacobian, compliance), jacobian, compliance, (constants, places), lock)
