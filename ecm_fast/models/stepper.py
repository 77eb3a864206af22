"""The control step of a model as an object that can be copied, sent to another process, and set back."""

import functools
import math
import threading
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError, real, shown
from ..kernels.history import begin, next_row, row_pieces
from ..kernels.layout import L_FX, L_GRAVITY
from ..kernels.prepare import prepare
from ..mechanism.mechanism import Mechanism
from ..mechanism.mesh.discretization import Discretization
from ..mechanism.vector import pack
from .batch import fast_path
from .equilibrium import Status
from .instruments.history import USER_ROWS, attachments, is_on_path, path_effects
from .loads import MIN_TOLERANCE, last_step, one_load
from .path_state import PathChoice, PathState, check_order
from .paths.condensed import STRETCH, Condensation
from .paths.general import StepCore, System, general_stepper
from .refinement import errors, solutions, work_arrays

__all__ = ["Stepper"]

Array = NDArray[np.float64]


class _NoDerivativesError(InputError, AttributeError):
    """Derivatives are asked of a stepper that makes none."""


class Stepper:
    """A control step: ``x, z, theta, status = step(lam_l, lam_r)``, made by `FiniteElementModel.stepper`.

    A call takes the readings of both force cells [N] and returns the pose of the head [m, m, rad] and its status. It
    starts from the equilibria of the calls before, takes a bounded number of Newton steps (one element of order 3 to 6:
    14 on the fast path and 12 on the general one), allocates nothing and never raises for a number.

    The equilibrium lies on the branch that the calls have followed since the stepper was made or reset. Where the neck
    has several stable equilibria under the same forces, as one that co-contraction has buckled, that is hysteresis, and
    `solve` may give another one; `followed` says whether an answer may be such a one, and `reset` leads back.

    ======================  ==============  =====================================================================
    status                  pose            meaning
    ======================  ==============  =====================================================================
    0 CONVERGED             finite          stable equilibrium: the only status under which a pose may be used
    2 NOT_CONVERGED         nan             no stable equilibrium was reached within the Newton steps of a call; the
                                            next call goes on from where this one came to. `solve` knows why
    3 TENDON_ZERO_LENGTH    nan             a tendon is pulled up to its pulley
    4 INVALID_INPUT         nan             a force, t or dwell is negative or no number, or a force cell so far off
                                            that a tendon would push; nothing has changed
    ======================  ==============  =====================================================================

    Every status is a value of `Status`, whose ``Status(status).explain()`` says it in a sentence.

    Where the mechanism has effects of the path (friction, hysteresis, memory, creep, Mullins, drift), a call is the
    next row of that path: ``step(lam_l, lam_r, t, dwell)`` with the time stamp and the time held before reading [s],
    both nan unless given. The answers are the poses that `predict` has for the same rows, and the state is the
    stepper's own: `state` returns it and `reset` sets it. What the camera adds, its drift included, is no part of the
    pose. A call then solves twice, each time from the straight neck. Other steppers take the two forces alone.

    Copies, deep copies and pickles are steppers of their own, made anew from mechanism, discretization and settings,
    that go on from the same state. Calls from several threads wait for each other; what they make is one sequence of
    calls, so threads that follow loads of their own need a stepper each. Derivatives are those of the last call,
    whichever thread made it.

    Parameters
    ----------
    mechanism, discretization : of the model
    wrench, tolerance, derivatives, lam_max, path : see `FiniteElementModel.stepper`
    """

    __slots__ = ("__call__", "__weakref__", "_arguments", "_core", "_first", "_past")

    if TYPE_CHECKING:

        def __call__(
            self, lam_l: float, lam_r: float, t: float = ..., dwell: float = ...
        ) -> tuple[float, float, float, int]:
            """Take a step, see above; at run time it is the compiled function itself."""

    def __init__(
        self,
        mechanism: Mechanism,
        discretization: Discretization,
        wrench: ArrayLike = (0.0, 0.0, 0.0),
        *,
        tolerance: float = 1e-9,
        derivatives: bool = False,
        lam_max: float = 0.0,
        path: PathChoice = None,
    ) -> None:
        loads, step_tol2 = one_load(np.zeros(2), wrench), last_step(tolerance)
        if not 0.0 <= real("lam_max", lam_max) < np.inf:
            raise InputError(f"lam_max = {shown(lam_max)}: allowed is a finite number, 0 or more")
        par = pack(mechanism)
        carries = path is None and is_on_path(par)
        if carries:
            _check_laws(par)
        check_order((), path, "a stepper")
        if isinstance(path, PathState):
            par = pack(path.hold(mechanism))
        settings = {"tolerance": tolerance, "derivatives": derivatives, "lam_max": lam_max, "path": path}
        self._arguments = mechanism, discretization, np.array(loads[2:5]), settings
        self._past: Array | None = None
        if carries:
            self._core, self._past = _path_core(discretization, par, loads, derivatives)
        else:
            self._core = _core(discretization, par, loads, step_tol2, derivatives, lam_max)
        self._first = tuple(part.copy() for part in self._core.kept)
        object.__setattr__(self, "__call__", self._core.call)  # a slot: a method would cost a tenth of a step

    @property
    def jacobian(self) -> Array:
        """Derivative of the last pose by the tendon forces, (3, 2) [m/N, m/N, rad/N]; the next call overwrites it.

        Effects of the path are held where they are.

        Raises
        ------
        InputError : the stepper was made without ``derivatives=True``.
        """
        self._check_derivatives("jacobian")
        return self._core.jacobian

    @property
    def compliance(self) -> Array:
        """Derivative of the last pose by a dead wrench at Q, (3, 3); the next call overwrites it.

        Raises
        ------
        InputError : the stepper was made without ``derivatives=True``.
        """
        self._check_derivatives("compliance")
        return self._core.compliance

    @property
    def followed(self) -> bool:
        """Whether the last answer may be owed to the calls before it; else it is that of `solve`."""
        return bool(self._core.followed[0])

    @property
    def error(self) -> float:
        """Estimated discretization error of the last pose, in rad and shares of the length; nan where there is none.

        A control step keeps its discretization, whatever the accuracy of its model: here it says what that leaves. It
        is made when asked for, at some 50 us, and costs a step nothing.
        """
        mechanism, mesh, _, settings = self._arguments
        held = self.state if self._past is not None else settings["path"]
        par = pack(held.hold(mechanism) if isinstance(held, PathState) else mechanism)[None]
        loads, q = self._core.last()
        found = solutions(mesh, par, loads[None, :L_FX], loads[None, L_FX:L_GRAVITY], last_step(MIN_TOLERANCE))
        if q is not None:  # the very state, on whatever branch
            found = found._replace(q=q[None], status=np.zeros(1, dtype=np.int64), pose=q[None, -3:])
        if found.status[0] > Status.UNSTABLE:
            return math.nan
        return float(errors(mesh, par, loads[None], found)[0])

    @property
    def state(self) -> PathState:
        """State that the path so far has left behind.

        Raises
        ------
        InputError : the mechanism has no effect of the path, or `path="ignore"` was given.
        """
        past = self._path("state")
        with self._core.lock:
            return PathState(*past.tolist())

    def reset(self, state: PathState | None = None) -> None:
        """Forget every call: the next one starts from the straight neck.

        state : of the path, from which it goes on; default: none yet, as in a new session
        """
        past = None if state is None else self._path("reset(state)")
        with self._core.lock:
            self._set(self._first)
            if past is not None and state is not None:
                past[:] = state.array()

    def __reduce__(self) -> tuple[Any, ...]:
        with self._core.lock:
            return _restored, self._arguments, tuple(part.copy() for part in self._core.kept)

    def __setstate__(self, kept: tuple[Array, ...]) -> None:
        self._set(kept)

    def _set(self, kept: tuple[Array, ...]) -> None:
        for part, value in zip(self._core.kept, kept, strict=True):
            part[...] = value

    def _path(self, what: str) -> Array:
        if self._past is None:
            raise InputError(f"{what}: this stepper carries no path, since its mechanism has no effect of the path")
        return self._past

    def _check_derivatives(self, name: str) -> None:
        if not self._arguments[3]["derivatives"]:
            raise _NoDerivativesError(f"step.{name} is made by a stepper with derivatives alone: say "
                                 "model.stepper(derivatives=True)")  # fmt: skip

    def __repr__(self) -> str:
        kind = "" if self._past is None else f" along a path, with {', '.join(path_effects(pack(self._arguments[0])))}"
        return f"<Stepper of {self._arguments[1].n_elements} element(s) of order {self._arguments[1].order}{kind}>"


def _restored(mechanism: Mechanism, discretization: Discretization, wrench: Array, settings: dict[str, Any]) -> Stepper:
    return Stepper(mechanism, discretization, wrench, **settings)


def _check_laws(par: Array) -> None:
    user_laws = [name for name in path_effects(par) if name in USER_ROWS]
    if user_laws:
        name = user_laws[0]
        raise InputError(f"{name}: a law of rows of your own is given all rows at once, which a stepper has not: use "
                         'predict, or leave effects of the path out with path="ignore"')  # fmt: skip


def _prepared(mesh: Discretization, par: Array) -> System:
    """Return stations, tip and q_rest of a mechanism."""
    stations, tip, q_rest, _, _ = work_arrays(mesh)
    prepare(par, mesh.mesh, mesh.nodes, stations, tip, q_rest)
    return stations, tip, q_rest


def _core(
    mesh: Discretization, par: Array, loads: Array, step_tol2: float, derivatives: bool, lam_max: float
) -> StepCore:
    """Return the step of a mechanism on its quickest path."""
    system = _prepared(mesh, par)
    fast = fast_path(mesh, *system)
    if fast is None:
        return general_stepper(mesh, system, loads, lam_max != 0.0)
    return fast.stepper(system, loads, step_tol2, derivatives, lam_max)


def _path_core(mesh: Discretization, par: Array, loads: Array, derivatives: bool) -> tuple[StepCore, Array]:
    """Return the step that carries the path, and the array with the path's state.

    First comes the pose without effects of the path, which leads them; then the constants of the mechanism they leave,
    and the pose with these. Both start from the straight neck and are solved to rounding, as rows of `predict` are.
    """
    step_tol2, system = last_step(MIN_TOLERANCE), _prepared(mesh, par)
    fast = Condensation.from_system(mesh, *system)
    plain = _core(mesh, par, loads, step_tol2, False, -1.0)
    along = general_stepper(mesh, system, loads, True) if fast is None else fast.stepper(system, loads, step_tol2,
                                                                                      derivatives, -1.0)  # fmt: skip
    constants, places = along.system
    order = 0 if fast is None else mesh.order
    pieces = row_pieces(len(par), len(mesh.mesh), mesh.nodes.size, order)
    memory = np.zeros(max(first + math.prod(shape) for first, shape in pieces.values()))
    parts = {name: memory[first : first + math.prod(shape)].reshape(shape) for name, (first, shape) in pieces.items()}
    where = places["stations"], places["tip"], places.get("con", 0)
    parts["sizes"][:] = len(par), len(mesh.mesh), mesh.nodes.size, order, *where
    attached, pulleys, parts["rest"][:] = attachments(par[None])
    parts["attached"][:], parts["pulleys"][:] = attached, pulleys
    parts["par"][:], parts["mesh"][:], parts["nodes"][:], parts["stretch"][:] = par, mesh.mesh, mesh.nodes, STRETCH
    if order:
        parts["turn"][:], parts["slopes"][:] = mesh.turn, mesh.slopes
    past = parts["past"]
    begin(past, parts["rest"])
    lock, nan = threading.Lock(), math.nan
    carry: Any = functools.partial(_compiled_row(), memory.ctypes.data, constants.ctypes.data)
    carry.memory = memory, constants  # which the addresses must not outlive

    def step(lam_l: float, lam_r: float, t: float = nan, dwell: float = nan) -> tuple[float, float, float, int]:
        with lock:
            if not (0.0 <= lam_l < math.inf and 0.0 <= lam_r < math.inf):
                return along.call(nan, nan)
            x, z, theta, _ = plain.call(lam_l, lam_r)
            possible = carry(float(lam_l), float(lam_r), float(t), float(dwell), x, z, theta)
            return along.call(lam_l, lam_r) if possible else along.call(nan, nan)

    kept = past, *along.kept
    return StepCore(step, kept, along.jacobian, along.compliance, along.system, along.followed, lock, along.last), past


@functools.cache
def _compiled_row() -> Any:
    """Return `next_row`, compiled once and for numbers of any kind."""
    next_row.compile(f"(int64, int64, {', '.join(7 * ['float64'])})")
    next_row.disable_compile()
    return next_row
