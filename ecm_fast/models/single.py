"""Single load cases of one mechanism: the condensed path where it applies, the general path, and refinement."""

import threading
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..kernels.general.newton import solve
from ..kernels.layout import (
    L_FX,
    L_GRAVITY,
    N_LOADS,
    N_OUT,
    O_FACTOR,
    O_ITERATIONS,
    O_PRELOAD,
    O_THETA,
    O_X,
    O_Z,
)
from ..kernels.prepare import prepare
from ..mechanism.mechanism import Mechanism
from ..mechanism.mesh.discretization import Discretization
from .batch import fast_path
from .equilibrium import Equilibrium, Status
from .loads import MIN_TOLERANCE, last_step, pushing
from .paths.chain import Chain
from .paths.condensed import ColdSolve, Condensation
from .refinement import finer, is_smooth, jumps, reached, stands, work_arrays
from .robot.tendons import by_length
from .solution import CondensedSolution, NodalSolution

__all__ = ["SingleSolver"]

Array = NDArray[np.float64]
Loads = Array | tuple[float, ...]
"""The kernels' loads of one case, (N_LOADS,); or without what follows the prestrain, which is 0 then."""


class SingleSolver:
    """Solves one load case at a time, from any thread.

    Parameters
    ----------
    mechanism : what results name
    mesh : the discretization
    par : (n_parameters,) of the mechanism without its markers
    """

    def __init__(self, mechanism: Mechanism, mesh: Discretization, par: Array) -> None:
        self.mechanism, self.mesh, self.par = mechanism, mesh, par
        self.system = work_arrays(mesh)
        self._finer: dict[Discretization, SingleSolver] = {}
        self._thread = threading.local()
        stations, tip, q_rest, _, _ = self.system
        prepare(par, mesh.mesh, mesh.nodes, stations, tip, q_rest)

    @cached_property
    def fast(self) -> Condensation | Chain | None:
        """The fast path, made when first needed; None where it does not apply."""
        return fast_path(self.mesh, *self.system[:3])

    def solve(self, loads: Loads, wanted: Array | None, accuracy: float | None) -> Equilibrium:
        """Solve one case.

        wanted : free lengths of tendons given by length, see `tendons.by_length`; None: all are given by force
        accuracy : discretization error that is kept by refining what needs it; None: nothing is refined
        """
        eq = None
        if wanted is None:
            eq, sure = self._solve_condensed(loads, accuracy)
            if eq is not None and sure:
                return eq
        loads = np.concatenate([loads, np.zeros(N_LOADS - len(loads))])
        eq, mesh = eq or self._solve(loads, wanted, accuracy), self.mesh
        if accuracy is None:
            return eq
        verdict, before, at = eq.verdict, None, jumps(self.par[None])
        while not stands(verdict, accuracy, before):
            finer_mesh = finer(mesh, verdict[2], accuracy, at)
            if finer_mesh is None:
                break
            mesh = finer_mesh
            eq = self._on(mesh)._solve(loads, wanted, accuracy)
            before, verdict = verdict, eq.verdict
        return eq

    @cached_property
    def _cells_are_off(self) -> bool:
        """Whether a force cell reads another force than acts, so that a reading may mean a tendon that pushes."""
        return pushing(self.par[None], np.zeros((1, 2))) is not None

    @cached_property
    def _is_smooth(self) -> bool:
        """Whether the condensed path's bound of the error holds, see `refinement.is_smooth`."""
        return bool(is_smooth(self.par[None])[0])

    @property
    def _cold(self) -> ColdSolve | None:
        """The condensed path's solve of one load case, of the calling thread; None where it does not apply."""
        if not hasattr(self._thread, "cold"):
            fast = self.fast
            self._thread.cold = fast.cold(last_step(MIN_TOLERANCE)) if isinstance(fast, Condensation) else None
        cold: ColdSolve | None = self._thread.cold
        return cold

    def _solve_condensed(self, loads: Loads, accuracy: float | None) -> tuple[Equilibrium | None, bool]:
        """Solve one load case on the condensed path, and say whether it surely keeps the accuracy; None: no verdict."""
        cold = self._cold
        if cold is None or (self._cells_are_off and pushing(self.par[None], np.array([loads[:L_FX]]))):
            return None, False
        x, z, theta, bound, steps = cold(*loads[:L_GRAVITY])
        if steps == 0:
            return None, False
        assert isinstance(self.fast, Condensation)
        solution = CondensedSolution(self.fast, self.par, cold.state())
        eq = object.__new__(Equilibrium)
        vars(eq).update(  # its own constructor sets field by field, which takes a fifth of the whole solve
            x=x,
            z=z,
            theta=theta,
            status=Status.CONVERGED,
            iterations=steps,
            load_factor=1.0,
            preload_factor=1.0,
            discretization=self.mesh,
            accuracy=accuracy,
            solution=solution,
            mechanism=self.mechanism,
        )
        return eq, accuracy is None or (self._is_smooth and bound <= accuracy)

    def _on(self, mesh: Discretization) -> "SingleSolver":
        """Return the solver of the same mechanism on another discretization."""
        if mesh not in self._finer:
            self._finer[mesh] = SingleSolver(self.mechanism, mesh, self.par)
        return self._finer[mesh]

    def _solve(self, loads: Array, wanted: Array | None, accuracy: float | None) -> Equilibrium:
        """Solve one load case on the general path."""
        if wanted is not None:
            return self._solve_lengths(loads, wanted, accuracy)
        stations, tip, q_rest = self.system[:3]
        # of this call alone: other threads may be solving
        q, work, out = np.empty_like(self.system[3]), np.zeros_like(self.system[4]), np.empty(N_OUT)
        status = Status(solve(self.mesh.tables, stations, tip, q_rest, loads, q, work, out))
        if not status.converged:
            out[[O_X, O_Z, O_THETA]] = np.nan
            loads = reached(loads, out[O_FACTOR])
        return Equilibrium(
            x=float(out[O_X]),
            z=float(out[O_Z]),
            theta=float(out[O_THETA]),
            status=status,
            iterations=int(out[O_ITERATIONS]),
            load_factor=float(out[O_FACTOR]),
            preload_factor=float(out[O_PRELOAD]),
            discretization=self.mesh,
            accuracy=accuracy,
            solution=NodalSolution(self.mesh, self.par, loads, q),
            mechanism=self.mechanism,
        )

    def _solve_lengths(self, loads: Array, wanted: Array, accuracy: float | None) -> Equilibrium:
        """Solve one case with tendons given by length."""
        found = by_length(self.mesh, self.par, loads, wanted)
        status = Status(found.status)
        x, z, theta = found.q[-3:].tolist() if status.converged else 3 * [np.nan]
        return Equilibrium(
            x=x,
            z=z,
            theta=theta,
            status=status,
            iterations=found.iterations,
            load_factor=found.factor,
            preload_factor=1.0,
            discretization=self.mesh,
            accuracy=accuracy,
            solution=NodalSolution(self.mesh, found.par, found.loads, found.q, wanted),
            mechanism=self.mechanism,
            lengths_given=wanted,
        )
