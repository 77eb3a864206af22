"""Lengths and forces of tendons at an equilibrium, and their derivatives."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["TendonState", "unknown_state"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TendonState:
    """Tendons at an equilibrium; m of them.

    Attributes
    ----------
    forces : (m,) tendon forces [N]
    lengths : (m,) of their paths: along the body; of a chord free and, up to a constant, around its pulley [m]
    jacobian : (3, m) d(x, z, theta)/d(reading of the force cell) [m/N, m/N, rad/N]
    moved : (m, 3 n_nodes) derivative of the nodes by tendon force
    dlength_dlam : (m, m) derivative of the lengths by the readings [m/N], symmetric where the gains are alike
    compliance : (3, 3) tip pose by a dead wrench at Q
    """

    forces: Array
    lengths: Array
    jacobian: Array
    moved: Array
    dlength_dlam: Array
    compliance: Array

    def jacobian_by_length(self, held: NDArray[np.int64], soft: Array) -> Array:
        """Return the derivative of the pose with some tendons held at their length, (3, m): of these by the length.

        held : their numbers; soft : (m,) compliances [m/N]. Slack tendons have 0
        """
        m, by = self.forces.size, self.jacobian.copy()
        by[:, held] = 0.0
        taut, rest = held[self.forces[held] > 0.0], np.setdiff1d(np.arange(m), held)
        if taut.size:
            change = self.dlength_dlam[np.ix_(taut, taut)] - np.diag(soft[taut])
            by[:, taut] = np.linalg.solve(change.T, self.jacobian[:, taut].T).T
            by[:, rest] -= by[:, taut] @ self.dlength_dlam[np.ix_(taut, rest)]
        return by


def unknown_state(m: int) -> TendonState:
    """Return the state of tendons where there is no equilibrium: nan."""
    shapes = (m,), (m,), (3, m), (m, 0), (m, m), (3, 3)
    return TendonState(*(np.full(shape, np.nan) for shape in shapes))
