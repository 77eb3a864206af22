"""The finite element model of a mechanism: a thin shell over the kernels."""

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .discretization import Discretization
from .equilibrium import BatchResult, Equilibrium, Status
from .errors import InputError, shown
from .kernels.batch import solve_many
from .kernels.layout import (
    L_FX,
    L_GRAVITY,
    L_LAM_L,
    L_LAM_R,
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
from .kernels.newton import advance, solve, solve_work_size
from .kernels.prepare import prepare
from .kernels.sensitivity import tip_derivatives
from .mechanism import Mechanism
from .parameters import PARAMETERS, pack

if TYPE_CHECKING:
    from .condensation import Condensation

__all__ = ["FiniteElementModel"]

Array = NDArray[np.float64]
Step = Callable[[float, float], tuple[float, float, float, int]]
NAN = float("nan")


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
    def _condensed(self) -> "Condensation | None":
        """The fast path, made when first needed; None where it does not apply."""
        from .condensation import Condensation

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
        threads: int = 1,
    ) -> BatchResult:
        """Solve many cases, each as `solve` does; a case that fails has its status and a pose of nan.

        Parameters
        ----------
        lam : (n, 2) tendon forces [N]
        wrench : (n, 3) dead wrenches at Q [N, N, N m]; default none
        parameters : (n, n_parameters) a parameter vector for each case instead of the model's mechanism
        threads : how many threads share the cases

        Raises
        ------
        InputError : a shape is wrong, or a tendon force is negative; names the row.
        """
        tensions = _numbers("tendon forces", lam)
        loads = _loads(tensions, np.zeros((len(tensions), 3)) if wrench is None else _numbers("wrenches", wrench))
        par = self._par[None] if parameters is None else _numbers("parameters", parameters)
        n = len(loads)
        if parameters is not None:
            _check_parameters(par, n)
        pose, factor, status = np.empty((n, 3)), np.ones(n), np.empty(n, dtype=np.int64)
        fast = self._condensed if parameters is None else None

        def part(rows: slice) -> None:
            todo = np.arange(n)[rows]
            if fast is not None:
                fast.solve(loads[rows], pose[rows], status[rows])
                todo = todo[status[rows] != Status.CONVERGED]
            if todo.size:
                own = par if parameters is None else par[todo]
                out, verdict = np.empty((todo.size, N_OUT)), np.empty(todo.size, dtype=np.int64)
                mesh = self.discretization
                solve_many(mesh.tables, mesh.mesh, mesh.nodes, own, loads[todo], _work_arrays(mesh), out, verdict)
                pose[todo], factor[todo], status[todo] = out[:, [O_X, O_Z, O_THETA]], out[:, O_FACTOR], verdict

        _in_threads(part, n, threads)
        pose[status > Status.UNSTABLE] = np.nan
        x, z, theta = np.ascontiguousarray(pose.T)
        return BatchResult(x, z, theta, status, factor)

    def stepper(self, wrench: ArrayLike = (0.0, 0.0, 0.0)) -> Step:
        """Return ``step(lam_l, lam_r) -> x, z, theta, status`` for a control loop.

        Each call starts from the equilibrium of the one before, takes a bounded number of Newton steps, allocates no
        array, releases the interpreter's lock and never raises. ``status`` is a value of `Status`: 0 is a stable
        equilibrium; where there is none, the pose is nan. Each thread needs a stepper of its own.

        Parameters
        ----------
        wrench : (3,) dead wrench at Q that stays [N, N, N m]
        """
        loads = _loads(np.zeros((1, 2)), _numbers("wrench", wrench)[None])[0]
        stations, tip, q_rest, _, _ = self._system
        _, _, _, q, work = _work_arrays(self.discretization)
        q[:] = q_rest
        tables, out = self.discretization.tables, np.empty(N_OUT)

        def robust_step(lam_l: float, lam_r: float) -> tuple[float, float, float, int]:
            loads[L_LAM_L], loads[L_LAM_R] = lam_l, lam_r
            status = advance(tables, stations, tip, q_rest, loads, q, work, out)
            if status <= Status.UNSTABLE:
                return float(out[O_X]), float(out[O_Z]), float(out[O_THETA]), status
            return NAN, NAN, NAN, status

        if self._condensed is None:
            return robust_step
        fast, con, state = self._condensed.advance, self._condensed.con, self._condensed.new_state(loads)

        def step(lam_l: float, lam_r: float) -> tuple[float, float, float, int]:
            result = fast(con, state, lam_l, lam_r)
            return result if result[3] == 0 else robust_step(lam_l, lam_r)

        return step

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
