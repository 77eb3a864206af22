"""The finite element model of a mechanism."""

import threading
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError, real
from ..mechanism.mechanism import Mechanism
from ..mechanism.mesh.discretization import Discretization, lowest_order
from ..mechanism.mesh.families import find_family
from ..mechanism.vector import pack
from .batch import solve_cases
from .body import divide
from .equilibrium import BatchResult, Equilibrium
from .instruments.history import path_effects
from .inverse import Inverse, force_grid
from .loads import finite_load, in_order, last_step, many_loads, one_load, parameter_rows
from .path_state import PathChoice, PathState, check_order, check_rows
from .paths.condensed import Condensation
from .refinement import resolve
from .robot.stepper import TendonStepper
from .robot.tendons import given_lengths
from .sensitivity import Sensitivities, sensitivities
from .single import SingleSolver
from .stepper import Stepper

__all__ = ["FiniteElementModel"]

Array = NDArray[np.float64]


class FiniteElementModel:
    """Statics of a neck: from tendon forces and a dead wrench at Q to the pose of the tip.

    Parameters
    ----------
    mechanism : what is built
    elements : how many elements, or their relative lengths from the clamp; default as many as `accuracy` needs
    order : of the shape functions, 1 to 6; default what `accuracy` needs, if the family goes that far
    gauss : Gauss points per element; default as many as neither lock nor waste
    family : ``"lagrange"``, ``"se2"`` or ``"strain"``, see `mechanism.mesh.families`
    accuracy : largest discretization error of the tip pose, in rad and shares of the length. Starts with one element
        of the lowest order that keeps it for mechanisms like the presets under tendons up to 160 N or wrenches up to
        (330 N, 80 N, 11 N m): 3 to 6 for 2e-4, 1e-5, 5e-7 and 1e-8. `solve` and `solve_batch` refine what needs more,
        order first, then elements. Where elements, order or Gauss points are given, or the family is another than
        Lagrange's, that discretization is kept: results carry their `error`, and nothing is refined

    Notes
    -----
    The default, one element of order 5, leaves an error below 1e-6, and below 1e-9 where tendons alone drive the neck.
    One element of order 3 to 6 is solved on the fast path of `kernels.condensed`, any other number and
    order on that of `kernels.chain`, and what neither takes or accepts by `kernels.general`: the same discrete
    equations, the same solution to rounding. ``elements=20, order=1`` is the paper's discretization.
    Families other than Lagrange's are for studies: they go the general path throughout.

    A model may be used by several threads at once, copied, pickled and sent to other processes.

    Poses that depend on the order of loads (effects of the path: friction, hysteresis, memory, creep, Mullins, drift)
    are those of `stepper` and of `predict`. The other methods refuse such a mechanism unless their argument `path`
    is ``"ignore"``, which leaves these effects out, or the state of a stepper, at which they are held.

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
        elements: int | ArrayLike | None = None,
        order: int | None = None,
        gauss: int | None = None,
        *,
        family: str = "lagrange",
        accuracy: float = 1e-6,
    ) -> None:
        self.mechanism = Mechanism() if mechanism is None else mechanism
        by_hand = elements is not None or order is not None or gauss is not None or family != "lagrange"
        self.accuracy = None if by_hand else accuracy
        if order is None:
            order = min(lowest_order(accuracy), find_family(family).highest_order)
        by_pieces = divide(pack(replace(self.mechanism, markers=())), elements)
        self.discretization = Discretization.from_elements(by_pieces, order, gauss, family)
        self._prepare()

    def _prepare(self) -> None:
        """Make what follows from the mechanism and the discretization."""
        self._statics = replace(self.mechanism, markers=())  # which are no part of it
        self._par = pack(self._statics)
        self._names = self.mechanism.tendon_names
        self._path_effects = path_effects(self._par)
        self._single = SingleSolver(self.mechanism, self.discretization, self._par)
        self._inverse: tuple[tuple[float, ...], Inverse] | None = None
        self._lock = threading.Lock()

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if not name.startswith("_")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._prepare()

    @property
    def path(self) -> Literal["condensed", "chain", "general"]:
        """The quickest way of solving that the mechanism and its discretization permit."""
        fast = self._single.fast
        return "general" if fast is None else "condensed" if isinstance(fast, Condensation) else "chain"

    @property
    def tip(self) -> Array:
        """Constants of the head plate as the kernels take them, (N_TIP,), see `kernels.layout`; a copy."""
        return self._single.system[1].copy()

    def at_state(self, path: PathChoice, what: str) -> "FiniteElementModel":
        """Return the model that `what`, which knows no order of loads, may solve: with `path`, see `solve`.

        Raises
        ------
        InputError : there are effects of the path, and `path` is None; names them, and `what`.
        """
        check_order(self._path_effects, path, what)
        if not isinstance(path, PathState):
            return self
        held = copy(self)
        held.__setstate__({"mechanism": path.hold(self.mechanism)})
        return held

    def solve(
        self,
        lam: ArrayLike | Mapping[str, float] | None = None,
        wrench: ArrayLike = (0.0, 0.0, 0.0),
        *,
        lengths: ArrayLike | Mapping[str, float] | None = None,
        path: PathChoice = None,
    ) -> Equilibrium:
        """Return the equilibrium on the stable branch that grows from the unloaded state.

        Parameters
        ----------
        lam : tendon forces, >= 0 [N]: (2,) left, right; of named tendons (m,) in the order of the file, or by name,
            where what is not given is 0. Default: none pulls
        wrench : (3,) dead wrench at Q in world axes: fx, fz [N], tau [N m]
        lengths : free lengths [m] of named tendons given by length instead of force: by name, or (m,) with nan for the
            others. Such a tendon is as long as that, plus its compliance times its force, or slack and shorter
        path : ``"ignore"`` or `Stepper.state`, where poses depend on the order of loads

        Raises
        ------
        InputError : a shape is wrong, a number is not finite or negative where it may not be, or the mechanism has
            effects of the path and `path` is not given.
        """
        model = self.at_state(path, "solve")
        if model is not self:
            return model.solve(lam, wrench, lengths=lengths, path="ignore")
        if not isinstance(lam, tuple):
            lam = in_order(lam, self._names)
        loads = finite_load(lam, wrench, self._names)
        wanted = None if lengths is None else given_lengths(self.mechanism, lengths, loads)
        return self._single.solve(loads, wanted, self.accuracy)

    def solve_batch(
        self,
        lam: ArrayLike,
        wrench: ArrayLike | None = None,
        *,
        parameters: ArrayLike | None = None,
        tolerance: float = 1e-9,
        threads: int = 1,
        out: BatchResult | None = None,
        path: PathChoice = None,
    ) -> BatchResult:
        """Solve many cases, each as `solve` does; a case that fails has its status and a pose of nan.

        Parameters
        ----------
        lam : (n, 2) tendon forces [N]; of named tendons (n, m)
        wrench : (n, 3) dead wrenches at Q, or (3,) for all [N, N, N m]; default none
        parameters : (n, n_parameters) a parameter vector for each case instead of the model's mechanism
        tolerance : largest error that Newton's method may leave, in rad and shares of the length
        threads : how many threads share the cases
        out : the result of as many other cases, overwritten and returned: batch after batch, fresh memory costs a
            third of the solving
        path : as for `solve`; with `parameters` None or ``"ignore"``

        Raises
        ------
        InputError : a shape is wrong, a tendon force is negative (names the row), or there are effects of the path and
            `path` is not given.
        """
        if parameters is None and (model := self.at_state(path, "solve_batch")) is not self:
            return model.solve_batch(lam, wrench, tolerance=tolerance, threads=threads, out=out)
        tensions, dead = many_loads(lam, wrench, self._names)
        step_tol2, mesh = last_step(tolerance), self.discretization
        if out is not None and len(out) != len(tensions):
            raise InputError(f"out has {len(out)} cases: allowed is {len(tensions)}, as many as there are loads")
        if parameters is None:
            fast, par = self._single.fast, self._par[None]
        else:
            fast, par = None, parameter_rows(parameters, len(tensions))
            check_rows(par, path, "solve_batch")
        return solve_cases(mesh, fast, par, tensions, dead, step_tol2, threads, out, self.accuracy)

    def sensitivities(
        self,
        names: Sequence[str],
        lam: ArrayLike,
        wrench: ArrayLike | None = None,
        *,
        parameters: ArrayLike | None = None,
        tolerance: float = 1e-9,
        path: PathChoice = None,
    ) -> Sensitivities:
        """Solve many cases, and differentiate their poses by loads and by any parameters of the mechanism.

        Exact, by the implicit function theorem on the factor of Newton's last step: no parameter costs a solve.

        Parameters
        ----------
        names : of the parameters, e.g. ``["EA", "precurvature"]``; none is allowed
        lam, wrench, parameters, tolerance, path : as for `solve_batch`

        Raises
        ------
        InputError : no such parameter, or as `solve_batch` does.
        """
        if parameters is None and (model := self.at_state(path, "sensitivities")) is not self:
            return model.sensitivities(names, lam, wrench, tolerance=tolerance)
        tensions, dead = many_loads(lam, wrench, self._names)
        par = self._par[None]
        if parameters is not None:
            par = parameter_rows(parameters, len(tensions))
            check_rows(par, path, "sensitivities")
        mesh = self.discretization
        if self.accuracy is not None:
            mesh, _ = resolve(mesh, par, tensions, dead, self.accuracy)
        return sensitivities(mesh, names, par, tensions, dead, last_step(tolerance))

    def inverse(
        self,
        *,
        theta: float | None = None,
        x: float | None = None,
        z: float | None = None,
        co_contraction: float | None = None,
        wrench: ArrayLike = (0.0, 0.0, 0.0),
        lam_max: float = 160.0,
        path: PathChoice = None,
    ) -> Array:
        """Return the tendon forces (2,) [N] that meet two wishes.

        Parameters
        ----------
        theta, x, z : tip angle and position [rad, m, m]
        co_contraction : mean of both tendon forces [N]
        wrench : (3,) dead wrench at Q [N, N, N m]
        lam_max : largest allowed tendon force [N]; the smallest is 0
        path : as for `solve`

        Raises
        ------
        OutOfReach : no allowed forces meet both; the text gives the nearest that can be had and its forces.
        InputError : not two wishes, a number that is not finite, or effects of the path without `path`.
        """
        self.mechanism.check_pair("inverse")
        model = self.at_state(path, "inverse")
        if model is not self:
            return model.inverse(
                theta=theta, x=x, z=z, co_contraction=co_contraction, wrench=wrench, lam_max=lam_max, path="ignore"
            )
        key = (*one_load(np.zeros(2), wrench).tolist(), real("lam_max", lam_max))
        with self._lock:  # the control step is one for all threads
            if self._inverse is None or self._inverse[0] != key:
                grid = force_grid(lam_max)
                poses = self.solve_batch(grid, wrench, path="ignore").pose
                step = self.stepper(wrench, tolerance=1e-12, derivatives=True, path="ignore")
                self._inverse = key, Inverse(step, grid, poses, self.mechanism.beam.length, lam_max)
            return self._inverse[1](theta=theta, x=x, z=z, co_contraction=co_contraction)

    def stepper(
        self,
        wrench: ArrayLike = (0.0, 0.0, 0.0),
        *,
        tolerance: float = 1e-9,
        derivatives: bool = False,
        lam_max: float = 0.0,
        path: PathChoice = None,
    ) -> Stepper:
        """Return ``step(lam_l, lam_r) -> x, z, theta, status`` for a control loop.

        Each call starts from the equilibria of the calls before, takes a bounded number of Newton steps, allocates
        nothing and never raises for a number. ``status`` is a value of `Status`: 0 is a stable equilibrium, and no
        other pose may be used; see `Stepper`. Where the mechanism has effects of the path, calls follow it.

        Parameters
        ----------
        wrench : (3,) dead wrench at Q that stays [N, N, N m]
        tolerance : largest error that Newton's method may leave, in rad and shares of the length
        derivatives : each call also overwrites ``step.jacobian``, (3, 2), pose by tendon force, and
            ``step.compliance``, (3, 3), pose by wrench, exact to the square root of the tolerance
        lam_max : above 0, a call depends on nothing but its arguments: within ``[0, lam_max]`` N it starts from a
            polynomial fitted now, and takes one or two Newton steps whatever the call before was; beyond, and where
            none can be fitted, from the straight neck. With effects of the path each call starts there
        path : ``"ignore"`` leaves effects of the path out, `Stepper.state` holds them; default: each call is the next
            row of a path

        Of a robot with named tendons this is `tendon_stepper`, by force.
        """
        if not self.mechanism.has_pair:
            by_force: Any = self.tendon_stepper(wrench, afresh=lam_max != 0.0, path=path)
            return by_force  # type: ignore[no-any-return]  # whose calls take as many forces as there are tendons
        settings: dict[str, Any] = {"tolerance": tolerance, "derivatives": derivatives}
        settings |= {"lam_max": lam_max, "path": path}
        return Stepper(self._statics, self.discretization, wrench, **settings)

    def tendon_stepper(
        self,
        wrench: ArrayLike = (0.0, 0.0, 0.0),
        *,
        lengths: Sequence[str] = (),
        afresh: bool = False,
        path: PathChoice = None,
    ) -> TendonStepper:
        """Return the control step of a robot: a call takes one number for each tendon, in the order of the file.

        Parameters
        ----------
        wrench : (3,) dead wrench at Q that stays [N, N, N m]
        lengths : names of tendons that a call drives by their free length [m] instead of their force [N]
        afresh : each call starts from the robot without tendon forces, and depends on its arguments alone
        path : ``"ignore"`` leaves effects of the path out
        """
        if self.mechanism.has_pair:
            raise InputError("tendon_stepper: allowed for [[tendon]]s; the pair of [tendons] has a stepper()")
        check_order(self._path_effects, path, "the stepper of a robot")
        return TendonStepper(self._statics, self.discretization, wrench, lengths, afresh=afresh)

    def __repr__(self) -> str:
        mesh = self.discretization
        kind = "" if mesh.family == "lagrange" else f"{mesh.family} "
        promise = "" if self.accuracy is None else f", refined to {self.accuracy:g} where needed"
        elements = f"{mesh.n_elements} {kind}element(s) of order {mesh.order}, {mesh.gauss} Gauss points each"
        return f"FiniteElementModel({elements}{promise})"
