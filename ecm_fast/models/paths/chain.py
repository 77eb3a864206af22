"""The chain path: models with many elements, or with one that the condensed path does not take."""

import functools
import threading
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...kernels.chain import solve as chain
from ...kernels.chain.constants import condense_chain, constants_size
from ...kernels.layout import CONVERGED, H_SIZE, INVALID_INPUT, N_LOADS
from ...mechanism.mesh.discretization import Discretization
from .condensed import STRETCH, Columns, Guess
from .general import StepCore, System, general_stepper

__all__ = ["Chain"]

Array = NDArray[np.float64]


class Chain:
    """The chain of condensed elements of one mechanism, see `kernels.chain`; stands in for `Condensation`.

    Its constants are read only; every thread brings its own state.
    """

    def __init__(self, mesh: Discretization, con: Array) -> None:
        self.con = con
        self.mesh = mesh

    @classmethod
    def from_system(cls, mesh: Discretization, stations: Array, tip: Array, q_rest: Array) -> "Chain | None":
        """Return the chain, or None where the mechanism or the discretization does not permit it."""
        if mesh.gauss != mesh.order or mesh.family != "lagrange":
            return None
        con = np.empty(constants_size(mesh.n_elements, mesh.order))
        applies = condense_chain(stations, tip, q_rest, mesh.basis, mesh.turn, STRETCH, con)
        return cls(mesh, con) if applies and np.isfinite(con).all() else None

    def new_state(self) -> Array:
        """Return work space for one thread, nothing solved yet."""
        state = np.zeros(chain.state_size(self.mesh.n_elements, self.mesh.order))
        state[H_SIZE] = np.inf
        return state

    def solve(self, lam: Array, wrench: Array, step_tol2: float, out: Columns, guess: Guess | None = None) -> None:
        """Solve tendon forces (n, 2) under dead wrenches (n, 3) or (1, 3), as `Condensation.solve` does."""
        chain.solve_chain(self.con, lam, wrench, step_tol2, self.new_state(), *out[:4])

    def fit_guess(self, lam_max: float, wrench: Array) -> Guess | None:
        """Return None: a chain always starts straight."""
        return None

    def stepper(self, system: System, loads: Array, step_tol2: float, derivatives: bool, lam_max: float) -> StepCore:
        """Return the control step; with derivatives it is the general path's, which has them."""
        general = general_stepper(self.mesh, system, loads, lam_max != 0.0)
        if derivatives:
            return general
        con, state = self.con, self.new_state()
        state[:N_LOADS] = loads
        lock = threading.Lock()

        def step(lam_l: float, lam_r: float) -> tuple[float, float, float, int]:
            with lock:
                if lam_max != 0.0:
                    state[H_SIZE] = np.inf  # nothing to follow
                lam = float(lam_l), float(lam_r)
                found: tuple[float, float, float, int] = chain.follow_chain(con, state, step_tol2, *lam)
                return found if found[3] in (CONVERGED, INVALID_INPUT) else general.call(*lam)

        last = functools.partial(_last, state)
        return replace(general, call=step, kept=(state, *general.kept), lock=lock, last=last)


def _last(state: Array) -> tuple[Array, Array | None]:
    """Return the loads of the last step, (N_LOADS,); a chain's nodes are not at hand."""
    return state[:N_LOADS].copy(), None
