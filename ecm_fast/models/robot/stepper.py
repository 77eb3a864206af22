"""The control step of a robot with named tendons, each driven by its force or by its length."""

import math
import threading
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import InputError, did_you_mean
from ...kernels.general.lengths import lengths_work_size
from ...kernels.general.newton import solve_work_size
from ...kernels.general.tendon_step import tendon_step
from ...kernels.layout import CONVERGED, N_LOADS, N_OUT, N_TENDONS
from ...kernels.prepare import prepare
from ...mechanism.body import TENDON
from ...mechanism.mechanism import Mechanism
from ...mechanism.mesh.discretization import Discretization
from ...mechanism.parameters import FIRST_TENDON
from ...mechanism.vector import pack
from ..loads import LAM_PLACES, one_load
from ..paths.general import without_forces
from ..refinement import work_arrays
from ..tendon_state import TendonState, unknown_state
from .tendons import FREEDOM, tendon_state

__all__ = ["TendonStepper"]

Array = NDArray[np.float64]
MOST_STEPS = 60
"""Newton steps of a call at given forces; a tentacle takes 33 from rest to 1.7 rad."""


class TendonStepper:
    """A control step ``x, z, theta, status = step(2.0, 0.30)``, made by `FiniteElementModel.tendon_stepper`.

    A call takes one number for each tendon, in the order of the file: its force [N], or its free length [m] where the
    stepper was made with ``lengths=("back",)``. It starts from the equilibrium of the call before, takes at most 60
    Newton steps at given forces and 126 more to given lengths, allocates nothing and never raises for a number.
    `Status` and `Stepper` say what a status means; under another than 0 the pose is nan.

    What else there is of the last call is made when asked for: `forces`, `lengths`, `jacobian`, `compliance`.

    Copies and pickles are steppers of their own that go on from the same state. Calls from several threads wait for
    each other.

    Parameters
    ----------
    mechanism, discretization : of the model, without markers
    wrench : (3,) dead wrench at Q that stays [N, N, N m]
    lengths : names of tendons driven by their length
    afresh : each call starts from the robot without tendon forces, so that it depends on its arguments alone
    """

    def __init__(
        self,
        mechanism: Mechanism,
        discretization: Discretization,
        wrench: ArrayLike = (0.0, 0.0, 0.0),
        lengths: Sequence[str] = (),
        *,
        afresh: bool = False,
    ) -> None:
        names = mechanism.tendon_names
        for name in lengths:
            if name not in names:
                raise InputError(f"lengths: no tendon is called {name!r}{did_you_mean(name, names)}; allowed are "
                                 f"{', '.join(names)}")  # fmt: skip
        self.names, self._arguments = (
            names,
            (mechanism, discretization, np.array(wrench, float), tuple(lengths), afresh),
        )
        par, mesh = pack(mechanism), discretization
        self._given, self._soft = np.zeros(N_TENDONS), np.zeros(N_TENDONS)
        stiff = []
        for i, name in enumerate(names):
            if name in lengths:
                row = par[FIRST_TENDON + TENDON.size * i :]
                self._given[i], self._soft[i] = 1.0, row[TENDON["compliance"]]
                row[TENDON["gain"]] = row[TENDON["zero"]] = 0.0  # of a cell that nobody reads
                stiff += [] if self._soft[i] else [name]
        chords = [name for name, tendon in zip(names, mechanism.named_tendons, strict=True)
                  if name in stiff and tendon.route == "chord"]  # fmt: skip
        if len(chords) > FREEDOM:
            raise InputError(f"chords driven by length without compliance: {', '.join(chords)}, more than the "
                             f"{FREEDOM} freedoms of the pose; give one a compliance [m/N], or its force")  # fmt: skip
        stations, tip, q_rest, _, _ = work_arrays(mesh)
        prepare(par, mesh.mesh, mesh.nodes, stations, tip, q_rest)
        self._par, self._mesh, self._lock = par, mesh, threading.Lock()
        self._loads = one_load(np.zeros(len(names)), wrench, names)
        self._start = without_forces(mesh, (stations, tip, q_rest), self._loads)
        self._trail, self._status = self._start.copy(), CONVERGED
        work = np.zeros(solve_work_size(mesh.nodes.size, mesh.n_elements, mesh.order) + 3 * mesh.nodes.size)
        room, out = np.zeros(lengths_work_size(mesh.nodes.size)), np.empty(N_OUT)
        self._wanted, self._places = np.zeros(N_TENDONS), LAM_PLACES[: len(names)]
        self._work = mesh.tables, stations, tip, work, room, out

    def __call__(self, *given: float) -> tuple[float, float, float, int]:
        """Take a step.

        Raises
        ------
        InputError : there are more or fewer numbers than tendons.
        """
        if len(given) != len(self.names):
            raise InputError(f"{len(given)} numbers: allowed is one for each tendon: {', '.join(self.names)}")
        tables, stations, tip, work, room, out = self._work
        with self._lock:
            for i, value in enumerate(given):
                if self._given[i]:
                    self._wanted[i] = value
                else:
                    self._loads[self._places[i]] = value
            if self._arguments[4]:
                self._trail[:] = self._start
            self._status = tendon_step(tables, stations, tip, self._start, self._trail, self._given, self._wanted,
                                       self._soft, self._loads, work, room, out, MOST_STEPS)  # fmt: skip
            if self._status != CONVERGED:
                return math.nan, math.nan, math.nan, self._status
            x, z, theta = self._trail[-3:].tolist()
            return x, z, theta, self._status

    @property
    def state(self) -> TendonState:
        """Forces and lengths of the tendons at the last pose, and their derivatives; nan where there is none."""
        with self._lock:
            if self._status != CONVERGED:
                return unknown_state(len(self.names))
            loads, q = self._trail[:N_LOADS].copy(), self._trail[N_LOADS + 1 :].copy()
        return tendon_state(self._mesh, self._par, loads, q, len(self.names))

    @property
    def forces(self) -> Array:
        """Tendon forces at the last pose, (m,) [N]."""
        return self.state.forces

    @property
    def lengths(self) -> Array:
        """Lengths of the tendons at the last pose, (m,) [m]."""
        return self.state.lengths

    @property
    def compliance(self) -> Array:
        """Derivative of the last pose by a dead wrench at Q with all forces held, (3, 3)."""
        return self.state.compliance

    @property
    def jacobian(self) -> Array:
        """Derivative of the last pose by what a call takes, (3, m), forces [N] or lengths [m]; 0 of a slack tendon."""
        return self.state.jacobian_by_length(np.flatnonzero(self._given), self._soft)

    def reset(self) -> None:
        """Forget every call: the next one starts from the robot without tendon forces."""
        with self._lock:
            self._trail[:], self._status = self._start, CONVERGED

    def __reduce__(self) -> tuple[Any, ...]:
        with self._lock:
            return _restored, self._arguments, (self._trail.copy(), self._loads.copy(), self._status)

    def __setstate__(self, state: tuple[Array, Array, int]) -> None:
        self._trail[:], self._loads[:], self._status = state

    def __repr__(self) -> str:
        kinds = (f"{name} {'[m]' if given else '[N]'}" for name, given in zip(self.names, self._given, strict=False))
        return f"<TendonStepper by {', '.join(kinds)}; {self._mesh.n_elements} element(s) of order {self._mesh.order}>"


def _restored(
    mechanism: Mechanism, mesh: Discretization, wrench: Array, lengths: Sequence[str], afresh: bool
) -> TendonStepper:
    return TendonStepper(mechanism, mesh, wrench, lengths, afresh=afresh)
