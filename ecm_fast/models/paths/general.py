"""The control step on the general path."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...kernels.condensed.control_step import rescue
from ...kernels.general.newton import solve_work_size
from ...kernels.layout import N_OUT
from ...mesh.discretization import Discretization

__all__ = ["Step", "System", "robust_stepper"]

Array = NDArray[np.float64]
Step = Callable[[float, float], tuple[float, float, float, int]]
"""x, z, theta, status by the forces of the left and the right tendon."""
System = tuple[Array, Array, Array]
"""stations, tip, q_rest of the finite element model, see `kernels.prepare`."""


def robust_stepper(mesh: Discretization, system: System, loads: Array, afresh: bool) -> Step:
    """Return the control step of the robust solver; the derivatives are attributes of the function.

    loads : (N_LOADS,)   the dead wrench, which stays; overwritten
    afresh : each step starts from the straight beam, not from the step before
    """
    stations, tip, q_rest = system
    q, out, compliance, jacobian = q_rest.copy(), np.empty(N_OUT), np.empty((3, 3)), np.empty((3, 2))
    work = np.zeros(solve_work_size(mesh.nodes.size, mesh.n_elements, mesh.order))

    def step(lam_l: float, lam_r: float) -> tuple[float, float, float, int]:
        lam = float(lam_l), float(lam_r)
        result: tuple[float, float, float, int] = rescue(
            mesh.tables, stations, tip, q_rest, loads, q, work, out, compliance, jacobian, afresh, *lam
        )
        return result

    with_derivatives: Any = step
    with_derivatives.jacobian, with_derivatives.compliance = jacobian, compliance
    return step
