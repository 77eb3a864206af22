"""The result of one solve: pose, status, and convergence data."""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import NotConverged
from ..kernels import layout
from ..mechanism.mechanism import Mechanism
from ..mechanism.mesh.discretization import Discretization
from ..mechanism.mesh.families import FAMILIES
from .tendon_state import TendonState, unknown_state

__all__ = ["BatchResult", "Equilibrium", "Solution", "Status"]

Array = NDArray[np.float64]


class Status(IntEnum):
    """The verdict on a solve.

    CONVERGED : a stable equilibrium. Of `solve` and of batches it lies on the branch that grows from the unloaded
        state; of a control step on the branch that its calls have followed since it was made or reset. The two differ
        only where the neck has more than one stable equilibrium under the same loads.
    UNSTABLE : an equilibrium, but not a stable one: the neck buckles before it gets there
    NOT_CONVERGED : no equilibrium was found; of a control step, none within the Newton steps of one call
    TENDON_ZERO_LENGTH : a tendon is pulled up to its pulley
    INVALID_INPUT : a load, or the mechanism under this load, cannot be
    SECTION_UNSTABLE : the law of the section, not the neck as a column, loses its stability
    """

    CONVERGED = layout.CONVERGED
    UNSTABLE = layout.UNSTABLE
    NOT_CONVERGED = layout.NOT_CONVERGED
    TENDON_ZERO_LENGTH = layout.TENDON_ZERO_LENGTH
    INVALID_INPUT = layout.INVALID_INPUT
    SECTION_UNSTABLE = layout.SECTION_UNSTABLE

    @property
    def converged(self) -> bool:
        """Whether the pose is an equilibrium."""
        return self in (Status.CONVERGED, Status.UNSTABLE)

    def explain(self, load_factor: float = float("nan"), preload_factor: float = 1.0) -> str:
        """Say in one sentence what happened and what to do; the factors are those of `Equilibrium`."""
        if preload_factor < 1.0 and load_factor == 0.0 and self is not Status.INVALID_INPUT:
            return _AT_REST[preload_factor > 0.0].format(factor=preload_factor)
        return _EXPLAINED[self].format(factor=load_factor)


_EXPLAINED = {
    Status.CONVERGED: "stable equilibrium, on the branch that grows from the unloaded state",
    Status.UNSTABLE: "equilibrium, but not stable: the load passes the buckling load at {factor:.6g} of its size",
    Status.NOT_CONVERGED: "no equilibrium: the stable branch from the unloaded state was followed to {factor:.6g} of "
    "the load; beyond, the neck snaps to another state or the load is out of all proportion; lower the load",
    Status.TENDON_ZERO_LENGTH: "no equilibrium: at {factor:.6g} of the load a tendon is pulled up to its pulley and "
    "has no length left; lower the load or move the pulley",
    Status.INVALID_INPUT: "no equilibrium: a load is not a finite number, a tendon is told to push or would push by "
    "what the force cells are off, or effects leave a length, mass, radius, gain or stiffness that cannot be",
    Status.SECTION_UNSTABLE: "no stable equilibrium: at {factor:.6g} of the load the law of the section itself, not "
    "the neck as a column, loses its stability, as it does in shear under tension where N > GA gamma_x; lower the "
    "load, or let the shear stiffness grow with the axial force (effect shear_compression)",
}
_AT_REST = (
    "no stable equilibrium even without tendon forces, wrench and weight: the shape as cast, or a law of your own, "
    "strains the neck beyond what it carries",
    "no stable equilibrium even without tendon forces and wrench: at {factor:.6g} of its own weight (and of what else "
    "acts without them) the neck buckles or snaps; make it stiffer or lighter",
)
"""Failures before any load acts: before the weight does, and while it grows."""


class Solution(Protocol):
    """Solved case that a path of solving can be asked about."""

    def nodes(self) -> Array:
        """Return all nodes, (3 n_nodes,)."""

    def derivatives(self) -> tuple[Array, Array]:
        """Return jacobian (3, 2) and compliance (3, 3)."""

    def tendons(self, m: int) -> TendonState:
        """Return the state of the first `m` tendons."""

    def markers(self, mechanism: Mechanism) -> Array:
        """Return the poses of a mechanism's markers, (n, 3)."""

    def error(self) -> float:
        """Return the estimated discretization error of the tip pose, also where the branch ends below full load."""


@dataclass(frozen=True)
class Equilibrium:
    """One solve. What is not among the first six attributes is computed when it is first asked for.

    Attributes
    ----------
    x, z, theta : tip pose [m, m, rad]; nan unless `converged`
    status : the verdict; `message` says it in words
    iterations : Newton steps taken, over all load steps
    load_factor : share of tendon forces and wrench that the stable branch carries: 1 when it carries all, else where
        it ends; 0 where the neck does not stand without them. They grow together, after the weight, which is there in
        full, as are the beam's shape as cast, a side force and the zeros of the force cells
    preload_factor : share of the weight, and of what else acts without tendon forces and wrench, that the neck carries
        without them
    discretization : what it was solved on; finer than the model's where the accuracy asked for needs that
    accuracy : the discretization error that was asked for, in rad and shares of the length; None where the
        discretization was given by hand
    error : estimate of the discretization error: the largest of abs(dx)/L, abs(dz)/L and abs(dtheta); nan unless
        `converged`. Over random mechanisms and loads the true error is below it in 99 %
    mechanism : what was solved
    lengths_given : (m,) free lengths of tendons given by length [m], nan for those given by force
    jacobian : (3, 2) d(x, z, theta)/d(lam_l, lam_r), of named tendons (3, m) [m/N, m/N, rad/N]; nan for a slack tendon
        whose attachment lies inside its pulley, since it has no direction
    forces, lengths : (m,) of the tendons, in their order [N, m]; of a chord up to a constant
    dlength_dlam : (m, m) derivative of the lengths by the tendon forces [m/N]
    dpose_dlength : (3, m) derivative of the pose by the lengths of tendons given by length; nan for those given by
        force, 0 for a slack one
    markers : pose (3,) of every marker by its name [m, m, rad]
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
    preload_factor: float
    discretization: Discretization = field(repr=False)
    accuracy: float | None = field(repr=False)
    solution: Solution = field(repr=False, compare=False)
    mechanism: Mechanism = field(repr=False, compare=False)
    lengths_given: Array | None = field(default=None, repr=False, compare=False)

    @cached_property
    def q(self) -> Array:
        """All nodes, (3 n_nodes,)."""
        return self.solution.nodes()

    @cached_property
    def _derivatives(self) -> tuple[Array, Array]:
        if self.converged and self.mechanism.has_pair:
            return self.solution.derivatives()
        return self._tendons.jacobian, self._tendons.compliance

    @cached_property
    def _tendons(self) -> TendonState:
        m = len(self.mechanism.tendon_names)
        return self.solution.tendons(m) if self.converged else unknown_state(m)

    @property
    def forces(self) -> Array:
        """Tendon forces, (m,) [N]; those that were found for tendons given by length."""
        return self._tendons.forces

    @property
    def lengths(self) -> Array:
        """Lengths of the tendons' paths, (m,) [m]."""
        return self._tendons.lengths

    @property
    def dlength_dlam(self) -> Array:
        """Derivative of the lengths by the tendon forces, (m, m) [m/N]."""
        return self._tendons.dlength_dlam

    @property
    def dpose_dlength(self) -> Array:
        """Derivative of the pose by the given lengths, (3, m)."""
        m = len(self.mechanism.tendon_names)
        given = np.isfinite(np.full(m, np.nan) if self.lengths_given is None else self.lengths_given)
        soft = np.array([tendon.compliance for tendon in self.mechanism.named_tendons])
        return np.where(given, self._tendons.jacobian_by_length(np.flatnonzero(given), soft), np.nan)

    @cached_property
    def markers(self) -> dict[str, Array]:
        """Pose (3,) of every marker by its name [m, m, rad]."""
        names = [marker.name for marker in self.mechanism.markers]
        missing = np.full((len(names), 3), np.nan)
        poses = self.solution.markers(self.mechanism) if self.converged and names else missing
        return dict(zip(names, poses, strict=True))

    @property
    def jacobian(self) -> Array:
        """Derivative of the pose by the tendon forces, (3, 2)."""
        return self._derivatives[0]

    @property
    def compliance(self) -> Array:
        """Derivative of the pose by a dead wrench at Q, (3, 3)."""
        return self._derivatives[1]

    @cached_property
    def error(self) -> float:
        """Estimated discretization error, in rad and shares of the length."""
        return self.solution.error() if self.converged else float("nan")

    @property
    def verdict(self) -> tuple[Status, float, float]:
        """Status, load factor, and the estimated error there, see `refinement.stands`."""
        return self.status, self.load_factor, self.error if self.converged else self.solution.error()

    @property
    def accurate(self) -> bool:
        """Whether the error is estimated to keep the accuracy that was asked for; true where none was."""
        return self.accuracy is None or not self.converged or self.error <= self.accuracy

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
        """The verdict in one sentence, and whether the accuracy asked for is kept where it is not."""
        verdict = self.status.explain(self.load_factor, self.preload_factor)
        if self.accurate:
            return verdict
        return f"{verdict}; discretization error about {self.error:.1g}, accuracy asked for {self.accuracy:g}"

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
        inexact = "" if self.accurate else f", error {self.error:.1g}"
        return f"Equilibrium({pose}; {self.status.name.lower()}{inexact}, {self.iterations} iterations)"


@dataclass(frozen=True)
class BatchResult:
    """Many solves; every array has one row a case.

    Attributes
    ----------
    x, z, theta : (n,) tip poses [m, m, rad]; nan unless converged
    status : (n,) values of `Status`
    load_factor : (n,) see `Equilibrium`
    preload_factor : (n,) see `Equilibrium`; found on the model's own discretization when it is first asked for
    accuracy : the discretization error that was asked for; None where the discretization was given by hand
    error : (n,) estimated discretization errors of the poses, in rad and shares of the length, see `Equilibrium`; nan
        unless converged. What was not refined is solved again when they are first asked for, at some 30 us a case
    """

    x: Array
    z: Array
    theta: Array
    status: NDArray[np.int64]
    load_factor: Array
    accuracy: float | None = None
    _later: dict[str, Array | Callable[[], Array]] = field(default_factory=dict, repr=False, compare=False)

    def postpone(self, accuracy: float | None, error: Callable[[], Array], preload_factor: Callable[[], Array]) -> None:
        """Take an accuracy, and functions that return errors and factors, (n,), to call when they are asked for."""
        object.__setattr__(self, "accuracy", accuracy)
        self._later.update(error=error, preload_factor=preload_factor)

    def _asked(self, name: str) -> Array:
        value = self._later[name]
        if callable(value):
            value = self._later[name] = value()
        return value

    @property
    def error(self) -> Array:
        """Estimated discretization errors, (n,)."""
        return self._asked("error")

    @property
    def preload_factor(self) -> Array:
        """Shares of the weight, and of what else acts without tendon forces and wrench, that the necks carry, (n,)."""
        return self._asked("preload_factor")

    @property
    def accurate(self) -> NDArray[np.bool_]:
        """Whether the error is estimated to keep the accuracy that was asked for, (n,); everywhere where none was."""
        if self.accuracy is None:
            return np.ones(len(self), dtype=np.bool_)
        return np.less_equal(self.error, self.accuracy) | ~self.converged

    @property
    def pose(self) -> Array:
        """Tip poses, (n, 3)."""
        return np.stack([self.x, self.z, self.theta], axis=1)

    @property
    def converged(self) -> NDArray[np.bool_]:
        """Whether the pose is an equilibrium, stable or not, (n,)."""
        return np.less_equal(self.status, Status.UNSTABLE)

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether it is a stable one on the branch from the unloaded state, (n,)."""
        return np.equal(self.status, Status.CONVERGED)

    def counts(self) -> dict[str, int]:
        """Number of cases by status."""
        if not self.status.any():  # seen much faster than counted
            return {status.name.lower(): len(self) if status is Status.CONVERGED else 0 for status in Status}
        numbers = np.bincount(self.status, minlength=len(Status)).tolist()
        return {status.name.lower(): numbers[status] for status in Status}

    def __len__(self) -> int:
        return len(self.status)

    def __repr__(self) -> str:
        kinds = ", ".join(f"{count} {name}" for name, count in self.counts().items() if count)
        return f"BatchResult({len(self)} cases: {kinds or 'none'})"
