"""The fast path of a model with many elements, or with one that `condensation` does not take."""

import numpy as np
from numpy.typing import NDArray

from .discretization import Discretization
from .kernels import chain, condensed
from .kernels.chain_constants import condense_chain, constants_size
from .kernels.layout import H_SIZE, N_LOADS

__all__ = ["Chain"]

Array = NDArray[np.float64]


class Chain:
    """The chain of condensed elements of one mechanism, see `kernels.chain`; stands in for `Condensation`.

    Its constants are read only; every thread brings its own state.
    """

    advance = staticmethod(chain.follow_chain)

    def __init__(self, mesh: Discretization, con: Array) -> None:
        self.con = con
        self._state_size = chain.state_size(mesh.n_elements, mesh.order)

    @classmethod
    def of(cls, mesh: Discretization, stations: Array, tip: Array, q_rest: Array) -> "Chain | None":
        """Return the chain, or None where the mechanism or the discretization does not permit it."""
        if mesh.gauss != mesh.order:
            return None
        con = np.empty(constants_size(mesh.n_elements, mesh.order))
        fit = condensed.stretch_fit()
        applies = condense_chain(stations, tip, q_rest, mesh.basis, mesh.turn, *fit, con)
        return cls(mesh, con) if applies and np.isfinite(con).all() else None

    def new_state(self, loads: Array | None = None) -> Array:
        """Return work space for one thread; with loads (N_LOADS,), for `advance`, nothing solved yet."""
        state = np.zeros(self._state_size)
        state[H_SIZE] = np.inf
        if loads is not None:
            state[:N_LOADS] = loads
        return state

    def solve(self, loads: Array, pose: Array, status: NDArray[np.int64]) -> None:
        """Solve rows of loads (n, N_LOADS) into pose (n, 3) and status (n,); see `kernels.chain`."""
        chain.solve_chain(self.con, loads, self.new_state(), pose, status)
