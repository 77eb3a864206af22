"""The fast path of a model: which mechanisms it takes, and the kernels of its order."""

from importlib import import_module

import numpy as np
from numpy.typing import NDArray

from .discretization import Discretization
from .kernels import condensed

__all__ = ["Condensation"]

Array = NDArray[np.float64]
ORDERS = (3, 4, 5, 6)
_FIT = condensed.stretch_fit()


class Condensation:
    """The condensed formulation of one mechanism, see `kernels.condensed`.

    Its constants are read only; every thread brings its own state.
    """

    def __init__(self, mesh: Discretization, con: Array) -> None:
        self.con = con
        self._order = mesh.order
        self._kernels = import_module(f".kernels.condensed{mesh.order}", __package__)
        self.advance = self._kernels.advance

    @classmethod
    def of(cls, mesh: Discretization, stations: Array, tip: Array, q_rest: Array) -> "Condensation | None":
        """Return the condensed formulation, or None where the mechanism or the discretization does not permit it."""
        if mesh.n_elements != 1 or mesh.order not in ORDERS or mesh.gauss != mesh.order:
            return None
        con = np.empty(condensed.constants_size(mesh.order))
        applies = condensed.condense(stations, tip, q_rest, mesh.turn, *_FIT, con)
        return cls(mesh, con) if applies and np.isfinite(con).all() else None

    def new_state(self, loads: Array | None = None) -> Array:
        """Return work space for one thread; with loads (N_LOADS,), for `advance`, nothing solved yet."""
        state = np.zeros(condensed.state_size(self._order))
        if loads is not None:
            condensed.start_lane(self.con, loads, state, 0)
        return state

    def solve(self, loads: Array, pose: Array, status: NDArray[np.int64]) -> None:
        """Solve rows of loads (n, N_LOADS) into pose (n, 3) and status (n,); see `kernels.condensed`."""
        self._kernels.solve_block(self.con, loads, self.new_state(), pose, status)
