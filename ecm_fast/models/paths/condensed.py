"""The condensed path: the mechanisms it takes, and the kernels of each order."""

import functools
import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...kernels.condensed import formulation as condensed
from ...kernels.condensed import initial_guess as start
from ...kernels.condensed import step as kernels
from ...kernels.condensed import step_memory as stepper
from ...kernels.condensed.axial_law import stretch_polynomials
from ...kernels.layout import (
    CONVERGED,
    L_FX,
    L_GRAVITY,
    LANES,
    N_STATION,
    N_TIP,
    NOT_CONVERGED,
    R_EXTREME,
    R_FX,
    R_FZ,
    R_LAM_L,
    R_LAM_R,
    R_PIVOT,
    R_SIZE,
    R_TAU,
)
from ...mechanism.mesh.discretization import Discretization
from .general import StepCore, System, without_forces

__all__ = ["Columns", "Condensation", "Guess", "columns", "solve_mechanisms", "solve_nodes"]

Array = NDArray[np.float64]
ORDERS = (3, 4, 5, 6)  # below, one element is too coarse; above, more elements are quicker
Columns = tuple[Array, Array, Array, NDArray[np.int64], Array]
"""x, z, theta, status and a bound of the discretization error of many cases."""
Guess = tuple[Array, float]
"""Coefficients of `kernels.condensed.initial_guess.guess`, and up to which tendon force they hold."""
# a fit that is farther off than this, in rad and lengths, is a poor place to start from
POOR = 0.02
STRETCH = stretch_polynomials()


class Condensation:
    """The condensed formulation of one mechanism on one mesh, see `kernels.condensed`.

    Its constants are read only; every thread brings its own state.
    """

    def __init__(self, mesh: Discretization, con: Array) -> None:
        self.con = con
        self.mesh = mesh
        self._points = kernels.gauss_points(mesh.order)
        self._straight = np.empty((5 + mesh.order, start.N_GUESS)), 0.0

    @classmethod
    def from_system(cls, mesh: Discretization, stations: Array, tip: Array, q_rest: Array) -> "Condensation | None":
        """Return the condensed formulation, or None where the mechanism or the discretization does not permit it."""
        if not permits(mesh):
            return None
        con = np.empty(condensed.constants_size(mesh.order))
        applies = condensed.condense(stations, tip, q_rest, mesh.turn, mesh.slopes, STRETCH, con)
        return cls(mesh, con) if applies and np.isfinite(con).all() else None

    def solve(self, lam: Array, wrench: Array, step_tol2: float, out: Columns, guess: Guess | None = None) -> Array:
        """Solve tendon forces (n, 2) under dead wrenches (n, 3) or (1, 3), see `kernels.condensed.step.solve_loads`.

        step_tol2 : largest squared last step of Newton's method
        out : x, z, theta, status, bound of the error, each (n,), overwritten
        guess : what `fit_guess` returned for loads with this wrench; none: the beam starts straight

        Returns the state of the last lanes.
        """
        coefficients, lam_max = self._straight if guess is None else guess
        state = np.zeros(LANES * condensed.state_size(self.mesh.order))
        kernels.solve_loads(self._points, self.con, coefficients, lam_max, lam, wrench, step_tol2, state, *out)
        return state

    def nodes(self, state: Array) -> Array:
        """Return all nodes, (3 n_nodes,), of a solved case's state."""
        mesh, q = self.mesh, np.empty(3 * self.mesh.nodes.size)
        condensed.nodes_of(self.con, state, mesh.tables, mesh.slopes, mesh.order, q)
        return q

    def derivatives(self, state: Array) -> tuple[Array, Array]:
        """Return jacobian (3, 2) and compliance (3, 3) of a solved case's state."""
        jacobian, compliance = np.empty((3, 2)), np.empty((3, 3))
        kernels.derivatives(self._points, self.con, state.copy(), compliance, jacobian)
        return jacobian, compliance

    def cold(self, step_tol2: float) -> "ColdSolve":
        """Return the solve of one load case at a time."""
        return ColdSolve(self, step_tol2)

    def fit_guess(self, lam_max: float, wrench: Array) -> Guess | None:
        """Return polynomials for where a solve with tendon forces up to `lam_max` under `wrench` should start.

        None where the fast path does not accept the 64 solutions they are fitted to.
        """
        at, basis, to_coefficients = _guess_fit()
        lam = 0.5 * lam_max * (1.0 + at)
        out = columns(LANES)
        state = self.solve(lam, wrench[None], 1e-13, out).reshape(-1, LANES)
        if (out[3] != CONVERGED).any():
            return None
        rows = state[start.unknowns(self.mesh.order)].T
        coefficients = to_coefficients @ rows
        scale = np.abs(rows).max(axis=0)
        scale[start.ANGLES :] = 1.0
        if np.any(np.abs(basis @ coefficients - rows) > POOR * scale):
            return None
        return np.ascontiguousarray(coefficients.T), lam_max

    def stepper(self, system: System, loads: Array, step_tol2: float, derivatives: bool, lam_max: float) -> StepCore:
        """Return the compiled control step, see `kernels.condensed.step.control_step`.

        system : stations, tip, q_rest of the finite element model, for the general path
        lam_max : below 0: each step starts from the straight beam
        """
        order = self.mesh.order
        memory = np.zeros(stepper.memory_size(order))
        parts = {
            name: memory[first : first + int(np.prod(shape))].reshape(shape)
            for name, (first, shape) in stepper.pieces(order).items()
        }
        parts["con"][:], parts["loads"][:], parts["tables"][:] = self.con, loads, self.mesh.tables
        parts["slopes"][:] = self.mesh.slopes
        parts["stations"][:], parts["tip"][:], _ = system
        parts["start"][:] = parts["trail"][:] = without_forces(self.mesh, system, loads)
        parts["state"][[R_FX, R_FZ, R_TAU]] = loads[L_FX:L_GRAVITY]
        guess = self.fit_guess(lam_max, loads[L_FX:L_GRAVITY]) if lam_max > 0.0 else None
        if guess is not None:
            parts["coefficients"][:] = guess[0]
        # without a fit each step starts straight: it must still depend on nothing but its arguments
        parts["settings"][:] = step_tol2, derivatives, -1.0 if guess is None and lam_max > 0.0 else lam_max
        places = {name: first for name, (first, _) in stepper.pieces(order).items()}
        kept = tuple(part for name, part in parts.items() if name not in stepper.CONSTANT)
        step: Any = functools.partial(compiled_step(order), memory.ctypes.data)
        # the address is all that the compiled step knows of: the function must keep the memory alive
        step.memory = memory

        def last() -> tuple[Array, Array | None]:
            state, at = parts["state"], parts["loads"].copy()
            at[:L_GRAVITY] = state[[R_LAM_L, R_LAM_R, R_FX, R_FZ, R_TAU]]
            solved = state[R_SIZE] <= step_tol2 and state[R_PIVOT] > 0.0 and state[R_EXTREME] <= 1.0
            return at, self.nodes(state) if solved else None

        derivatives_of = parts["jacobian"], parts["compliance"]
        return StepCore(step, kept, *derivatives_of, (memory, places), parts["followed"], threading.Lock(), last)


class ColdSolve:
    """Solves one load case at a time, each from the straight beam."""

    def __init__(self, condensation: Condensation, step_tol2: float) -> None:
        con, order = condensation.con, condensation.mesh.order
        self._size = con.size
        self._memory = np.concatenate([con, np.zeros(condensed.state_size(order)), [step_tol2]])
        self._solve, self._address = compiled_cold_solve(order), self._memory.ctypes.data

    def __call__(
        self, lam_l: float, lam_r: float, f_x: float, f_z: float, tau: float
    ) -> tuple[float, float, float, float, int]:
        """Return x, z, theta, a bound of the error, and how many Newton steps it took; 0: no verdict."""
        found: tuple[float, float, float, float, int] = self._solve(self._address, lam_l, lam_r, f_x, f_z, tau)
        return found

    def state(self) -> Array:
        """Return a copy of the state of the case solved last, (state_size,)."""
        return self._memory[self._size : -1].copy()


@functools.cache
def _guess_fit() -> tuple[Array, Array, Array]:
    """Return scaled tendon forces to fit at, (LANES, 2), the monomials there, and the least squares fit to them."""
    u = np.cos(np.pi * (np.arange(8) + 0.5) / 8)
    at = np.stack(np.meshgrid(u, u), axis=-1).reshape(LANES, 2)
    basis = start.monomials(at[:, 0], at[:, 1])
    return at, basis, np.linalg.pinv(basis)


def permits(mesh: Discretization) -> bool:
    """Whether a mesh has kernels of its own."""
    lagrange = mesh.family == "lagrange" and mesh.gauss == mesh.order
    return lagrange and mesh.n_elements == 1 and mesh.order in ORDERS


@functools.cache
def compiled_cold_solve(order: int) -> Any:
    """Return the solve of one load case of an order, compiled for numbers of any kind."""
    solve = kernels.cold_solve(order)
    solve.compile("(int64, float64, float64, float64, float64, float64)")
    solve.disable_compile()
    return solve


@functools.cache
def compiled_step(order: int) -> Any:
    """Return the control step of an order, compiled for numbers of any kind: it never compiles again in a loop."""
    advance = kernels.control_step(order)
    advance.compile("(int64, float64, float64)")
    advance.disable_compile()
    return advance


def columns(n: int) -> Columns:
    """Return room for x, z, theta, status and bound of the error of n cases, none of them solved."""
    return np.empty(n), np.empty(n), np.empty(n), np.full(n, NOT_CONVERGED, dtype=np.int64), np.full(n, np.nan)


def solve_mechanisms(
    mesh: Discretization, par: Array, lam: Array, wrench: Array, step_tol2: float, out: Columns
) -> None:
    """Solve cases that each have a parameter vector, (n, n_parameters), where the mesh permits it.

    See `Condensation.solve` and `kernels.condensed.step.solve_mechanisms`.
    """
    if not permits(mesh):
        return
    order = mesh.order
    con, state = np.empty(condensed.constants_size(order)), np.zeros(LANES * condensed.state_size(order))
    system = np.empty((order, N_STATION)), np.empty(N_TIP), np.empty(3 * (order + 1))
    constants = mesh.mesh, mesh.nodes, mesh.turn, mesh.slopes, STRETCH
    lanes = np.empty(LANES * con.size)
    points = kernels.gauss_points(order)
    kernels.solve_mechanisms(points, par, *constants, lam, wrench, step_tol2, system, con, lanes, state, *out)


def solve_nodes(
    mesh: Discretization, par: Array, lam: Array, wrench: Array, step_tol2: float, q: Array, status: NDArray[np.int64]
) -> None:
    """Solve cases into all their nodes, where the mesh permits it; see `kernels.condensed.step.solve_nodes`.

    par : (1 or n, n_parameters), lam : (n, 2), wrench : (1 or n, 3), q : (n, 3 n_nodes), status : (n,)
    """
    if not permits(mesh):
        return
    order = mesh.order
    con, state = np.empty(condensed.constants_size(order)), np.zeros(condensed.state_size(order))
    system = np.empty((order, N_STATION)), np.empty(N_TIP), np.empty(3 * (order + 1))
    constants = mesh.mesh, mesh.nodes, mesh.turn, mesh.slopes, STRETCH, mesh.tables
    points = kernels.gauss_points(order)
    kernels.solve_nodes(points, par, *constants, lam, wrench, step_tol2, system, con, state, q, status)
