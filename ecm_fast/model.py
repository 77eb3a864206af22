"""The finite element model of a mechanism: a thin shell over the kernels."""

from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .condensation import Condensation, Guess, solve_mechanisms
from .discretization import Discretization
from .equilibrium import BatchResult, Equilibrium, Status
from .errors import InputError, shown
from .kernels.batch import solve_many
from .kernels.layout import (
    L_FX,
    L_GRAVITY,
    N_LOADS,
    N_OUT,
    N_STATION,
    N_TIP,
    O_FACTOR,
    O_ITERATIONS,
    O_THETA,
    O_X,
    O_Z,
)
from .kernels.newton import solve, solve_work_size
from .kernels.prepare import prepare
from .kernels.sensitivity import tip_derivatives
from .mechanism import Mechanism
from .parameters import PARAMETERS, pack
from .stepping import Step, robust_stepper


__all__ = ["FiniteElementModel"]

Array = NDArray[np.float64]
# fewer cases than this do not pay for fitting where they start
WORTH_A_GUESS = 2048


# Newton's method leaves at most this times the square of its last step (measured: 0.3 for tendons, 4 for wrenches)
QUADRATIC, MIN_TOLERANCE = 10.0, 1e-13


class FiniteElementModel:
    """Statics of a neck: from tendon forces and a dead wrench at Q to the pose of the tip.

    Parameters
    ----------
    mechanism : what is built
    elements : how many elements, or their relative lengths from the clamp; default one
    order : of the Lagrange shape functions, 1 to 6
    gauss : Gauss points per element; default as many as the order, which neither locks nor wastes

    Notes
    -----
    The default, one element of order 5, leaves an error below 1e-8 (m, rad) wherever tendon forces up to 160 N
    drive the neck. One element of order 3 to 6 is solved on the fast path (`kernels.condensed`), everything else,
    and every load that the fast path does not vouch for, by `kernels.newton`: the same discrete equations, the same
    solution to rounding. ``elements=20, order=1`` is the paper's discretization.

    A model is immutable in use but owns work arrays: each thread needs its own.

    Examples
    --------
    >>> model = FiniteElementModel(Mechanism.preset("slender"))
    >>> eq = model.solve((40.0, 10.0))
    >>> eq.stable
    True
    """

    def __init__(
        self,
        mechanism: Mechanism | None = None,
        elements: int | ArrayLike = 1,
        order: int = 5,
        gauss: int | None = None,
    ) -> None:
        self.mechanism = Mechanism() if mechanism is None else mechanism
        self.discretization = Discretization.of(elements, order, gauss)
        self._par = pack(self.mechanism)
        self._system = _work_arrays(self.discretization)
        stations, tip, q_rest, _, _ = self._system
        prepare(self._par, self.discretization.mesh, self.discretization.nodes, stations, tip, q_rest)

    @cached_property
    def _condensed(self) -> Condensation | None:
        """The fast path, made when first needed; None where it does not apply."""
        stations, tip, q_rest, _, _ = self._system
        return Condensation.of(self.discretization, stations, tip, q_rest)

    @property
    def tip(self) -> Array:
        """Constants of the head plate as the kernels take them, (N_TIP,), see `kernels.layout`; a copy."""
        return self._system[1].copy()

    def solve(self, lam: ArrayLike = (0.0, 0.0), wrench: ArrayLike = (0.0, 0.0, 0.0)) -> Equilibrium:
        """Return the equilibrium on the stable branch that grows from the unloaded state.

        Parameters
        ----------
        lam : (2,) tendon forces left, right, >= 0 [N]
        wrench : (3,) dead wrench at Q in world axes: fx, fz [N], tau [N m]

        Raises
        ------
        InputError : a shape is wrong, or a number is not finite or negative where it may not be.
        """
        loads = _loads(_numbers("tendon forces", lam)[None], _numbers("wrench", wrench)[None])
        bad = ~np.isfinite(loads[0])
        if bad.any():
            name = ("lam_l", "lam_r", "fx", "fz", "tau", "gravity")[int(np.argmax(bad))]
            raise InputError(f"{name} = {loads[0][bad][0]}: allowed is a finite number")
        stations, tip, q_rest, q, work = self._system
        tables, out = self.discretization.tables, np.empty(N_OUT)
        status = Status(solve(tables, stations, tip, q_rest, loads[0], q, work, out))
        compliance, jacobian = np.full((3, 3), np.nan), np.full((3, 2), np.nan)
        if status.converged:
            n = q.size
            rest, step = work[2 * n + N_LOADS :], work[:n]
            tip_derivatives(tables, stations, tip, loads[0], q, rest, step, compliance, jacobian)
        else:
            out[[O_X, O_Z, O_THETA]] = np.nan
        return Equilibrium(
            x=float(out[O_X]),
            z=float(out[O_Z]),
            theta=float(out[O_THETA]),
            status=status,
            iterations=int(out[O_ITERATIONS]),
            load_factor=float(out[O_FACTOR]),
            jacobian=jacobian,
            compliance=compliance,
            q=q.copy(),
            discretization=self.discretization,
        )

    def solve_batch(
        self,
        lam: ArrayLike,
        wrench: ArrayLike | None = None,
        *,
        parameters: ArrayLike | None = None,
        tolerance: float = 1e-10,
        threads: int = 1,
    ) -> BatchResult:
        """Solve many cases, each as `solve` does; a case that fails has its status and a pose of nan.

        Parameters
        ----------
        lam : (n, 2) tendon forces [N]
        wrench : (n, 3) dead wrenches at Q, or (3,) for all [N, N, N m]; default none
        parameters : (n, n_parameters) a parameter vector for each case instead of the model's mechanism
        tolerance : largest error that Newton's method may leave, in rad and shares of the length
        threads : how many threads share the cases

        Raises
        ------
        InputError : a shape is wrong, or a tendon force is negative; names the row.
        """
        loads = _many_loads(lam, wrench)
        par = self._par[None] if parameters is None else _numbers("parameters", parameters)
        n = len(loads)
        if parameters is not None:
            _check_parameters(par, n)
        accept = _tolerance(tolerance)
        pose, factor, status = np.empty((n, 3)), np.ones(n), np.full(n, Status.NOT_CONVERGED, dtype=np.int64)
        mesh = self.discretization
        guess = self._guess(loads) if parameters is None and n >= WORTH_A_GUESS else None

        def part(rows: slice) -> None:
            if parameters is not None:
                solve_mechanisms(mesh, par[rows], loads[rows], accept, pose[rows], status[rows])
            elif self._condensed is not None:
                self._condensed.solve(loads[rows], accept, pose[rows], status[rows], guess)
            todo = np.arange(n)[rows][status[rows] != Status.CONVERGED]
            if todo.size:
                own = par if parameters is None else par[todo]
                out, verdict = np.empty((todo.size, N_OUT)), np.empty(todo.size, dtype=np.int64)
                solve_many(mesh.tables, mesh.mesh, mesh.nodes, own, loads[todo], _work_arrays(mesh), out, verdict)
                pose[todo], factor[todo], status[todo] = out[:, [O_X, O_Z, O_THETA]], out[:, O_FACTOR], verdict

        _in_threads(part, n, threads)
        pose[status > Status.UNSTABLE] = np.nan
        x, z, theta = np.ascontiguousarray(pose.T)
        return BatchResult(x, z, theta, status, factor)

    def _guess(self, loads: Array) -> Guess | None:
        """Return polynomials for where to start, where many loads share a wrench and stay in the working range."""
        largest = loads[:, :L_FX].max()
        if self._condensed is None or not 0.0 < largest < np.inf or (loads[:, L_FX:] != loads[0, L_FX:]).any():
            return None
        return self._condensed.fit_guess(largest, loads[0, L_FX:L_GRAVITY])

    def stepper(
        self,
        wrench: ArrayLike = (0.0, 0.0, 0.0),
        *,
        tolerance: float = 1e-10,
        derivatives: bool = False,
        lam_max: float = 0.0,
    ) -> Step:
        """Return ``step(lam_l, lam_r) -> x, z, theta, status`` for a control loop.

        Each call starts from the equilibria of the calls before, takes a bounded number of Newton steps, allocates
        nothing, releases the interpreter's lock and never raises for a number. ``status`` is a value of `Status`: 0 is
        a stable equilibrium; where there is none, the pose is nan. Each thread needs a stepper of its own.

        Parameters
        ----------
        wrench : (3,) dead wrench at Q that stays [N, N, N m]
        tolerance : largest error that Newton's method may leave, in rad and shares of the length
        derivatives : each call also overwrites ``step.jacobian``, (3, 2), pose by tendon force, and
            ``step.compliance``, (3, 3), pose by wrench, exact to the square root of the tolerance
        lam_max : above 0, a call depends on nothing but its arguments: within ``[0, lam_max]`` N it starts from a
            polynomial fitted now, and takes one or two Newton steps whatever the call before was
        """
        loads = _loads(np.zeros((1, 2)), _numbers("wrench", wrench)[None])[0]
        accept = _tolerance(tolerance)
        stations, tip, q_rest, _, _ = self._system
        if self._condensed is not None:
            return self._condensed.stepper((stations, tip, q_rest), loads, accept, derivatives, lam_max)
        return robust_stepper(self.discretization, (stations, tip, q_rest), loads)

    def __repr__(self) -> str:
        mesh = self.discretization
        return f"FiniteElementModel({mesh.n_elements} element(s) of order {mesh.order}, {mesh.gauss} Gauss points each)"


def _work_arrays(mesh: Discretization) -> tuple[Array, Array, Array, Array, Array]:
    """Return stations, tip, q_rest, q and the work space of one thread."""
    n = 3 * mesh.nodes.size
    work = np.zeros(solve_work_size(mesh.nodes.size, mesh.n_elements, mesh.order))
    return np.empty((len(mesh.mesh), N_STATION)), np.empty(N_TIP), np.empty(n), np.empty(n), work


def _in_threads(part: Callable[[slice], None], n: int, threads: int) -> None:
    """Call `part` with slices that cover n rows, on as many threads."""
    share = max(1, -(-n // max(1, threads)))
    chunks = [slice(first, min(n, first + share)) for first in range(0, n, share)]
    if len(chunks) < 2:
        for chunk in chunks:
            part(chunk)
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(len(chunks)) as pool:
        list(pool.map(part, chunks))


def _check_parameters(par: Array, n: int) -> None:
    """Raise where parameter vectors (n, n_parameters) cannot be meant; names the row and the parameter."""
    if par.shape != (n, len(PARAMETERS)):
        raise InputError(f"parameters has shape {par.shape}: allowed is ({n}, {len(PARAMETERS)})")
    lower, upper = (np.array([getattr(entry, bound) for entry in PARAMETERS]) for bound in ("lower", "upper"))
    outside = ~((par >= lower) & (par <= upper))
    if outside.any():
        row, place = np.argwhere(outside)[0]
        entry = PARAMETERS[place]
        raise InputError(f"row {row} of parameters: {entry.key} = {par[row, place]}: allowed is {entry.allowed}")


def _tolerance(value: float) -> float:
    """Return the largest squared last step that leaves an error of at most `value`."""
    if not MIN_TOLERANCE <= value <= 1e-3:
        raise InputError(f"tolerance = {shown(value)}: allowed is a number from {MIN_TOLERANCE:g} to 1e-3")
    return value / QUADRATIC


def _many_loads(lam: ArrayLike, wrench: ArrayLike | None) -> Array:
    """Return the load rows of many cases."""
    tensions = _numbers("tendon forces", lam)
    dead = np.zeros(3) if wrench is None else _numbers("wrenches", wrench)
    if dead.shape == (3,):
        dead = np.broadcast_to(dead, (len(tensions), 3))
    return _loads(tensions, dead)


def _numbers(name: str, values: ArrayLike) -> Array:
    """Return values as a contiguous array of at least one axis."""
    try:
        return np.atleast_1d(np.ascontiguousarray(values, dtype=np.float64))
    except (TypeError, ValueError):
        raise InputError(f"{name} = {shown(values)}: allowed is an array of numbers") from None


def _loads(lam: Array, wrench: Array) -> Array:
    """Return the kernels' load rows, (n, N_LOADS), or raise where they cannot be meant."""
    if lam.ndim != 2 or lam.shape[1] != 2:
        raise InputError(f"tendon forces have shape {lam.shape}: allowed is two, left and right, a case")
    if wrench.shape != (len(lam), 3):
        raise InputError(f"wrenches have shape {wrench.shape}: allowed is ({len(lam)}, 3): fx, fz, tau a case")
    negative = lam < 0.0
    if negative.any():
        row, side = np.argwhere(negative)[0]
        raise InputError(f"lam_{'lr'[side]} = {lam[row, side]} N in row {row}: allowed is >= 0, a tendon only pulls")
    loads = np.empty((len(lam), N_LOADS))
    loads[:, :L_FX], loads[:, L_FX:L_GRAVITY], loads[:, L_GRAVITY] = lam, wrench, 1.0
    return loads
