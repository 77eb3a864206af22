"""The result of one solve: pose, status, and convergence data."""

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from ..errors import NotConverged
from ..kernels import layout
from ..mesh.discretization import Discretization
from ..mesh.families import FAMILIES

__all__ = ["BatchResult", "Equilibrium", "Status"]

Array = NDArray[np.float64]


class Status(IntEnum):
    """The verdict on a solve."""

    CONVERGED = layout.CONVERGED
    UNSTABLE = layout.UNSTABLE
    NOT_CONVERGED = layout.NOT_CONVERGED
    TENDON_ZERO_LENGTH = layout.TENDON_ZERO_LENGTH
    INVALID_INPUT = layout.INVALID_INPUT

    @property
    def converged(self) -> bool:
        """Whether the pose is an equilibrium."""
        return self in (Status.CONVERGED, Status.UNSTABLE)

    def explain(self, load_factor: float = float("nan")) -> str:
        """Say in one sentence what happened and what to do; `load_factor` is how much of the load was reached."""
        return _EXPLAINED[self].format(factor=load_factor)


_EXPLAINED = {
    Status.CONVERGED: "stable equilibrium, on the branch that grows from the unloaded state",
    Status.UNSTABLE: "equilibrium, but not stable: the load passes the buckling load at {factor:.6g} of its size",
    Status.NOT_CONVERGED: "no equilibrium: the stable branch from the unloaded state was followed to {factor:.6g} of "
    "the load; beyond, the neck snaps to another state or the load is out of all proportion; lower the load",
    Status.TENDON_ZERO_LENGTH: "no equilibrium: at {factor:.6g} of the load a tendon is pulled up to its pulley and "
    "has no length left; lower the load or move the pulley",
    Status.INVALID_INPUT: "no equilibrium: a load is not a finite number, or a tendon is told to push",
}


@dataclass(frozen=True)
class Equilibrium:
    """One solve.

    Attributes
    ----------
    x, z, theta : tip pose [m, m, rad]; nan unless `converged`
    status : the verdict; `message` says it in words
    iterations : Newton steps taken, over all load steps
    load_factor : how much of the load the stable branch carries: 1 when it carries all, else where it ends
    jacobian : (3, 2) d(x, z, theta)/d(lam_l, lam_r) [m/N, m/N, rad/N]; nan for a slack tendon whose attachment lies
        inside its pulley, since it has no direction
    compliance : (3, 3) d(x, z, theta)/d(fx, fz, tau) [m/N ... rad/(N m)], symmetric
    q : (3 n_nodes,) x, z, theta of every node, clamp first [m, m, rad]; of an inner node some families keep other
        unknowns than places, see `families.Family`
    """

    x: float
    z: float
    theta: float
    status: Status
    iterations: int
    load_factor: float
    jacobian: Array = field(repr=False)
    compliance: Array = field(repr=False)
    q: Array = field(repr=False)
    discretization: Discretization = field(repr=False)

    @property
    def converged(self) -> bool:
        """Whether the pose is an equilibrium, stable or not."""
        return self.status.converged

    @property
    def stable(self) -> bool:
        """Whether the pose is a stable equilibrium on the branch from the unloaded state."""
        return self.status is Status.CONVERGED

    @property
    def message(self) -> str:
        """The verdict in one sentence."""
        return self.status.explain(self.load_factor)

    @property
    def pose(self) -> Array:
        """Tip pose (3,): x, z, theta [m, m, rad]."""
        return np.array([self.x, self.z, self.theta])

    def raise_if_failed(self) -> "Equilibrium":
        """Return itself when stable.

        Raises
        ------
        NotConverged : the status is anything else; the text is `message`.
        """
        if not self.stable:
            raise NotConverged(self.message)
        return self

    def shape(self, n: int = 50) -> Array:
        """Return x, z, theta at `n` places evenly along the undeformed beam, shape (n, 3), clamp first."""
        mesh = self.discretization
        ends = np.concatenate([[0.0], np.cumsum(mesh.shares)])
        places = np.linspace(0.0, 1.0, n)
        element = np.clip(np.searchsorted(ends, places, side="right") - 1, 0, mesh.n_elements - 1)
        xi = (places - ends[element]) / np.asarray(mesh.shares)[element]
        nodes = element[:, None] * mesh.order + np.arange(mesh.order + 1)
        return FAMILIES[mesh.family].centerline(mesh.order, mesh.gauss, self.q.reshape(-1, 3)[nodes], xi)

    def __repr__(self) -> str:
        pose = f"x={self.x:.6g} m, z={self.z:.6g} m, theta={self.theta:.6g} rad"
        return f"Equilibrium({pose}; {self.status.name.lower()}, {self.iterations} iterations)"


@dataclass(frozen=True)
class BatchResult:
    """Many solves; every array has one row a case.

    Attributes
    ----------
    x, z, theta : (n,) tip poses [m, m, rad]; nan unless converged
    status : (n,) values of `Status`
    load_factor : (n,) see `Equilibrium`
    """

    x: Array
    z: Array
    theta: Array
    status: NDArray[np.int64]
    load_factor: Array

    @property
    def pose(self) -> Array:
        """Tip poses, (n, 3)."""
        return np.stack([self.x, self.z, self.theta], axis=1)

    @property
    def converged(self) -> NDArray[np.bool_]:
        """Where the pose is an equilibrium, stable or not, (n,)."""
        return np.less_equal(self.status, Status.UNSTABLE)

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Where it is a stable one on the branch from the unloaded state, (n,)."""
        return np.equal(self.status, Status.CONVERGED)

    def counts(self) -> dict[str, int]:
        """How many cases ended with each status."""
        if not self.status.any():  # seen much faster than counted
            return {status.name.lower(): len(self) if status is Status.CONVERGED else 0 for status in Status}
        numbers = np.bincount(self.status, minlength=len(Status)).tolist()
        return {status.name.lower(): numbers[status] for status in Status}

    def __len__(self) -> int:
        return len(self.status)

    def __repr__(self) -> str:
        kinds = ", ".join(f"{count} {name}" for name, count in self.counts().items() if count)
        return f"BatchResult({len(self)} cases: {kinds or 'none'})"
