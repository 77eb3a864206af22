"""Solutions of single solves: nodes, derivatives and discretization error, computed when asked for."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels.general.sensitivity import tip_derivatives
from ..kernels.layout import R_FX, R_FZ, R_LAM_L, R_LAM_R, R_TAU
from ..kernels.prepare import prepare
from ..mechanism.mechanism import Mechanism
from ..mechanism.mesh.discretization import Discretization
from ..mechanism.vector import check_tail
from .body import lengths_of
from .equilibrium import Status
from .loads import loads_of
from .paths.condensed import Condensation
from .refinement import Solutions, errors, work_arrays
from .robot.markers import marker_poses
from .robot.tendons import by_length, tendon_state
from .robot.tendons import without_given as _without
from .tendon_state import TendonState

__all__ = ["CondensedSolution", "NodalSolution"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class NodalSolution:
    """One solved case by all its nodes, see `equilibrium.Solution`.

    Attributes
    ----------
    mesh : the discretization
    par : (n_parameters,) the mechanism
    loads : (N_LOADS,) those at which `q` is in equilibrium
    q : (3 n_nodes,)
    wanted : (m,) free lengths of tendons given by length [m], nan for those given by force; None: all by force
    """

    mesh: Discretization
    par: Array
    loads: Array
    q: Array
    wanted: Array | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self.mesh, self.par, self.loads, self.q, self.wanted)

    def nodes(self) -> Array:
        """Return all nodes, (3 n_nodes,)."""
        return self.q

    def derivatives(self) -> tuple[Array, Array]:
        """Return jacobian (3, 2) and compliance (3, 3)."""
        mesh, (stations, tip, q_rest, step, work) = self.mesh, work_arrays(self.mesh)
        jacobian, compliance = np.empty((3, 2)), np.empty((3, 3))
        prepare(self.par, mesh.mesh, mesh.nodes, stations, tip, q_rest)
        tip_derivatives(mesh.tables, stations, tip, self.loads, self.q, work, step, compliance, jacobian)
        return jacobian, compliance

    def tendons(self, m: int) -> TendonState:
        """Return the state of the first `m` tendons."""
        return tendon_state(self.mesh, self.par, self.loads, self.q, m)

    def markers(self, mechanism: Mechanism) -> Array:
        """Return the poses of the mechanism's markers, (n, 3): solved again on elements that end there."""
        return marker_poses(mechanism, self.mesh, self.par, self.loads, self.wanted)

    def error(self) -> float:
        """Return the estimated discretization error of the tip pose."""
        if self.wanted is not None:  # the forces change with the mesh, too: twice what halving changes, as elsewhere
            again = by_length(self.mesh.halved, self.par, _without(self.loads, self.wanted), self.wanted)
            off = np.abs(again.q[-3:] - self.q[-3:]) / [*2 * [lengths_of(self.par[None])[0]], 1.0]
            return 2.0 * float(off.max()) if again.status <= Status.UNSTABLE else float("inf")
        found = Solutions(self.q[None], np.zeros(1, dtype=np.int64), self.q[None, -3:], np.ones(1), np.ones(1))
        return float(errors(self.mesh, self.par[None], self.loads[None], found)[0])


@dataclass(eq=False)
class CondensedSolution:
    """One case solved on the condensed path, see `equilibrium.Solution`.

    Attributes
    ----------
    condensation : the path
    par : (n_parameters,) the mechanism
    state : (state_size,) what the kernels leave of the case, see `kernels.layout`
    """

    condensation: Condensation
    par: Array
    state: Array

    def __reduce__(self) -> tuple[Any, ...]:
        return self._nodal().__reduce__()

    def nodes(self) -> Array:
        """Return all nodes, (3 n_nodes,)."""
        return self.condensation.nodes(self.state)

    def derivatives(self) -> tuple[Array, Array]:
        """Return jacobian (3, 2) and compliance (3, 3)."""
        return self.condensation.derivatives(self.state)

    def error(self) -> float:
        """Return the estimated discretization error of the tip pose."""
        return self._nodal().error()

    def tendons(self, m: int) -> TendonState:
        """Return the state of the first `m` tendons."""
        return self._nodal().tendons(m)

    def markers(self, mechanism: Mechanism) -> Array:
        """Return the poses of the mechanism's markers, (n, 3)."""
        return self._nodal().markers(mechanism)

    def _nodal(self) -> NodalSolution:
        """Return the same solution by its nodes."""
        row = self.state[[R_LAM_L, R_LAM_R, R_FX, R_FZ, R_TAU]]
        loads = loads_of(row[None, :2], row[None, 2:])[0]
        return NodalSolution(self.condensation.mesh, self.par, loads, self.nodes())


def _restored(mesh: Discretization, par: Array, loads: Array, q: Array, wanted: Array | None) -> NodalSolution:
    """Return a solution from a pickle, or raise where its effects of the user's own are not those of this process."""
    check_tail(par[None])
    return NodalSolution(mesh, par, loads, q, wanted)
