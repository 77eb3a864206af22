"""Derivatives of many tip poses by loads and by any parameters of the mechanism."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..kernels.general.newton import solve_work_size
from ..kernels.general.sensitivity import pose_sensitivities
from ..kernels.layout import N_STATION, N_TIP
from ..mechanism.catalogue import CATALOGUE
from ..mechanism.mesh.discretization import Discretization
from ..mechanism.parameters import N_BUILT_IN, find, index
from ..mechanism.sections import STIFFNESSES
from .equilibrium import Status
from .loads import loads_of, pushing
from .refinement import solutions

__all__ = ["Sensitivities", "sensitivities"]

Array = NDArray[np.float64]
# written out for Lagrange elements whose sections have the plain laws, the same along the beam; every other parameter
# takes the complex step
_PLAIN = ("precurvature", "precurvature_gradient", "neutral_axis_offset", "beam_length", "beam_mass")
_FURTHER = [
    index(entry.size.key) for name, entry in CATALOGUE.items() if entry.enters == "section" and name not in _PLAIN
]


@dataclass(frozen=True)
class Sensitivities:
    """Tip poses (x, z, theta) and their derivatives; every array has one row a case, nan where there is no pose.

    Attributes
    ----------
    pose : (n, 3) [m, m, rad]
    jacobian : (n, 3, 2) by the tendon forces [m/N, m/N, rad/N]
    compliance : (n, 3, 3) by the dead wrench fx, fz, tau
    dpose_dpar : (n, 3, k) by the parameters, in the order of `names`
    names : (k,) as they were asked for
    status : (n,) values of `Status`
    """

    pose: Array
    jacobian: Array = field(repr=False)
    compliance: Array = field(repr=False)
    dpose_dpar: Array = field(repr=False)
    names: tuple[str, ...]
    status: NDArray[np.int64] = field(repr=False)

    @property
    def by_load(self) -> Array:
        """Derivatives by the tendon forces and the dead wrench, (n, 3, 5)."""
        return np.concatenate([self.jacobian, self.compliance], axis=2)

    @property
    def converged(self) -> NDArray[np.bool_]:
        """Whether the pose is an equilibrium, stable or not, (n,)."""
        return np.less_equal(self.status, Status.UNSTABLE)

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether it is a stable one on the branch from the unloaded state, (n,)."""
        return np.equal(self.status, Status.CONVERGED)

    def __len__(self) -> int:
        return len(self.status)

    def __repr__(self) -> str:
        return f"Sensitivities({len(self)} cases by {', '.join(self.names) or 'loads'}; {self.stable.sum()} stable)"


def sensitivities(
    mesh: Discretization, names: Sequence[str], par: Array, lam: Array, wrench: Array, step_tol2: float
) -> Sensitivities:
    """Solve and differentiate many cases.

    Parameters
    ----------
    names : of parameters, ``EA`` or ``beam.EA``
    par : (1 or n, n_parameters), lam : (n, 2), wrench : (1 or n, 3), step_tol2 : largest squared last Newton step
    """
    n, k = len(lam), len(names)
    found = solutions(mesh, par, lam, wrench, step_tol2)
    refused = pushing(par, lam)
    if refused is not None:
        found.status[refused] = Status.INVALID_INPUT
    plain = mesh.family == "lagrange" and not (par[:, _FURTHER].any() or par[:, N_BUILT_IN:].any())
    stiffness, others, columns = _sort(names, plain=plain)
    out = np.empty((n, 3)), np.empty((n, 3, 2)), np.empty((n, 3, 3)), np.empty((n, 3, k))
    real, complex_ = _work(mesh, others.size)
    c_par = np.zeros(par.shape[1], dtype=complex)
    solved = loads_of(lam, wrench), found.q, found.status
    pose_sensitivities(
        mesh.tables, mesh.mesh, mesh.nodes, par, stiffness, others, *solved, real, (c_par, *complex_), *out
    )
    pose, jacobian, compliance, by = out
    return Sensitivities(pose, jacobian, compliance, by[:, :, columns], tuple(names), found.status)


def _sort(names: Sequence[str], *, plain: bool) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Return columns of EA, GA, EI (-1: not written out), places of the others, and the columns by `names`."""
    keys = [find(name).key for name in names]
    if len(set(keys)) < len(keys):
        raise InputError(f"a parameter is named twice in {', '.join(names)}")
    if "beam.axial_law" in keys:
        raise InputError("axial_law is a choice, not a number: there is no derivative by it")
    written_out = {f"beam.{name}" for name in STIFFNESSES} if plain else set()
    others = [key for key in keys if key not in written_out]
    last = [key for key in keys if key not in others]
    columns = [others.index(key) if key in others else len(others) + last.index(key) for key in keys]
    place = {key: len(others) + i for i, key in enumerate(last)}
    stiffness = [place.get(f"beam.{name}", -1) for name in STIFFNESSES]
    return (
        np.array(stiffness, dtype=np.int64),
        np.array([index(key) for key in others], dtype=np.int64),
        np.array(columns, dtype=np.int64),
    )


def _constants(mesh: Discretization, shape: tuple[int, ...], dtype: type = float) -> tuple[Array, Array, Array]:
    """Return room for stations, tip and q_rest."""
    sizes = (len(mesh.mesh), N_STATION), (N_TIP,), (3 * mesh.nodes.size,)
    stations, tip, q_rest = (np.zeros((*shape, *size), dtype=dtype) for size in sizes)
    return stations, tip, q_rest


def _work(mesh: Discretization, k: int) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Return work arrays of `pose_sensitivities`, real and complex ones, the vector left out."""
    n = 3 * mesh.nodes.size
    work = np.zeros(solve_work_size(mesh.nodes.size, mesh.n_elements, mesh.order))
    real = *_constants(mesh, ()), work, np.empty(n), np.empty((3, n)), np.empty((3, 3))
    room: tuple[Array, ...] = tuple(np.zeros(size, dtype=complex) for size in (n, n, 9))
    return real, (*_constants(mesh, (k,), complex), *room)
