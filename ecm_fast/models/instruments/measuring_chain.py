"""The measuring chain with its derivatives: from a mechanism and a record of loads to readings.

In order: what a row changes on the test bed, what it inherits from the rows before, the equilibrium, the camera.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data.columns import CHANNELS
from ...data.measurements import Measurements
from ...errors import InputError
from ...kernels.camera import read, read_derivatives
from ...kernels.prepare import prepare
from ...mechanism.catalogue import CATALOGUE
from ...mechanism.mesh.discretization import Discretization
from ...mechanism.parameters import PARAMETERS, PLACES, find, index
from ..batch import fast_path, solve_cases
from ..equilibrium import BatchResult
from ..refinement import resolve, work_arrays
from ..sensitivity import Sensitivities, sensitivities
from .history import TARGETS, History, Record, is_on_path, on_path

__all__ = ["CHANGES", "MeasuringChain", "row_parameters"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

CHANGES = {"tilt": "gravity_tilt", "extra_mass": "effects.head_mass"}
"""Changes of the test bed by a row, and the parameter to which it is added."""

_CAMERA = [index(entry.key) for effect in CATALOGUE.values() if effect.enters == "camera" for entry in effect]
_INHERITED = {PARAMETERS[place].key for place in (*TARGETS, PLACES.beam_length, PLACES.effects_beam_length)}
_CELLS = ("effects.force_zero", "effects.force_zero_asymmetry", "effects.force_crosstalk")
"""Parameters by which a cell that reads 0 makes a force, which a tendon that hangs slack has not."""
_PLACES_OF_CELLS = [index(key) for key in _CELLS]
_STEP = 1e-100  # of the complex step
_WITHOUT_MEMORY = 1e-14  # squared last Newton step of the solution that the history follows


def row_parameters(par: Array, data: Measurements) -> Array | None:
    """Return a parameter vector for every row, (n, n_parameters), or None where no row changes the test bed.

    Parameters
    ----------
    par : (n_parameters,) the mechanism's own vector

    Raises
    ------
    InputError : a row's change leaves the bounds of the parameter it adds to; names the row.
    """
    changes = {name: getattr(data, name) for name in CHANGES}
    if not any(change.any() for change in changes.values()):
        return None
    par = np.tile(par, (data.n, 1))
    for name, change in changes.items():
        place = index(CHANGES[name])
        par[:, place] += change
        entry, values = PARAMETERS[place], par[:, place]
        outside = (values < entry.lower) | (values > entry.upper)
        if outside.any():
            i = int(np.argmax(outside))
            raise InputError(f"{data.where(i)}: {name} = {change[i]:g} makes {entry.key} = {values[i]:g}: allowed is "
                             f"{entry.allowed}")  # fmt: skip
    return par


class MeasuringChain:
    """Readings of the instruments in every row of measurements, as a function of the parameter vector.

    Parameters
    ----------
    mesh : the discretization
    data : loads, and what was changed on the test bed; their poses are not looked at
    only : (k,) places of the rows that are read, which rise; what they inherit comes from all rows all the same
    """

    def __init__(self, mesh: Discretization, data: Measurements, only: NDArray[np.int64] | None = None) -> None:
        if data.named:
            raise InputError(f"{data.source}: column {next(iter(data.named))}: this takes a neck with the pair of "
                             "[tendons], and its columns alone")  # fmt: skip
        self.mesh, self.data, self.channels = mesh, data, CHANNELS
        self.record = Record.from_measurements(data)
        self._only = slice(None) if only is None else only
        self._all_loads = data.lam, data.wrench
        self._loads = data.lam[self._only], data.wrench[self._only]
        self._hanging = data.hanging[self._only]
        self._followed: tuple[Array, History] | None = None

    @property
    def n(self) -> int:
        """Number of rows that are read."""
        return len(self._loads[0])

    def refine(self, par: Array, allowed: Array) -> Array:
        """Take a discretization whose error is allowed in every row; return the estimated errors, (n,).

        allowed : (n,) in rad and shares of the length
        """
        self.mesh, error = resolve(self.mesh, self.rows(par), *self._loads, allowed)
        return error

    def rows(self, par: Array) -> Array:
        """Return the parameter vectors of the rows, (1 or n, n_parameters), from the mechanism's (n_parameters,)."""
        by_row = row_parameters(par, self.data)
        if is_on_path(par):
            rows = self._each(par, by_row)
            self._history(par, by_row).apply(rows, self._only)
            return np.asarray(self._hung(rows))
        if self._hanging.any() and par[_PLACES_OF_CELLS].any():
            return np.asarray(self._hung(self._each(par, by_row)))
        return par[None].copy() if by_row is None else by_row[self._only]

    def solve(self, par: Array, step_tol2: float, threads: int = 1) -> tuple[Array, NDArray[np.int64], Array]:
        """Return readings (n, 3) [m, m, rad], nan where there is no equilibrium, status and load factor, (n,) each."""
        rows = self.rows(par)
        result = self._solve(rows, self._loads, step_tol2, threads)
        pose = result.pose
        if rows[:, _CAMERA].any():
            read(rows, pose)
        return pose, result.status, result.load_factor

    def solve_many(self, par: Array, step_tol2: float) -> tuple[Array, NDArray[np.int64]]:
        """Return readings (m, n, 3) and status (m, n) for many mechanisms (m, n_parameters), in one batch.

        Raises
        ------
        InputError : as `row_parameters` does.
        """
        m, n = len(par), self.n
        rows = np.concatenate([np.broadcast_to(self.rows(vector), (n, par.shape[1])) for vector in par])
        lam, wrench = (np.tile(loads, (m, 1)) for loads in self._loads)
        result = solve_cases(self.mesh, None, rows, lam, wrench, step_tol2, 1)
        pose = result.pose
        if rows[:, _CAMERA].any():
            read(rows, pose)
        return pose.reshape(m, n, 3), result.status.reshape(m, n)

    def sensitivities(self, names: Sequence[str], par: Array, step_tol2: float) -> Sensitivities:
        """Return readings and their derivatives by loads and by any parameters, see `sensitivity.sensitivities`.

        `jacobian` is by the readings of the force cells.
        """
        keys = [find(name).key for name in names]
        own_path = on_path()
        hung = {*_CELLS} if self._hanging.any() else set()
        touched = hung | (_INHERITED | own_path.keys() if is_on_path(par) else own_path.keys())
        inherited = [key for key in keys if key in touched]
        rows, changes = self.rows(par), {}
        if inherited:
            changes = self._changes(par, inherited)
        targets = [
            PARAMETERS[place].key for place in sorted({place for change in changes.values() for place in change})
        ]
        asked = [*dict.fromkeys([*(key for key in keys if key not in own_path), *targets])]
        found = sensitivities(self.mesh, asked, rows, *self._loads, step_tol2)
        if hung:
            found = replace(found, jacobian=np.where(self._hanging[:, None, :], 0.0, found.jacobian))
        self._see(rows, asked, found, always=bool(rows[:, _CAMERA].any()))
        if inherited:
            dpose = {key: found.dpose_dpar[:, :, i] for i, key in enumerate(asked)}
            columns = [self._inherited(dpose, changes[key]) if key in changes else dpose[key] for key in keys]
            found = replace(found, dpose_dpar=np.stack(columns, axis=-1))
        return replace(found, names=tuple(names))

    def _each(self, par: Array, by_row: Array | None) -> Array:
        """Return a vector for each row that is read, (n, n_parameters); `own`, where there are any, are of all rows."""
        return np.tile(par, (self.n, 1)) if by_row is None else by_row[self._only].copy()

    def _hung(self, rows: Any) -> Any:
        """Turn rows (n, n_parameters), real or complex, so that a slack tendon pulls nothing; returns them."""
        if not self._hanging.any():
            return rows
        zero, apart, crosstalk = _PLACES_OF_CELLS
        left, right = rows[:, zero] + 0.5 * rows[:, apart], rows[:, zero] - 0.5 * rows[:, apart]
        left, right = np.where(self._hanging[:, 0], 0.0, left), np.where(self._hanging[:, 1], 0.0, right)
        rows[:, zero], rows[:, apart] = 0.5 * (left + right), left - right
        rows[self._hanging.any(axis=1), crosstalk] = 0.0
        return rows

    def _history(self, par: Array, by_row: Array | None) -> History:
        """Follow the same mechanism without effects of the path along the record; the last one is remembered."""
        if self._followed is None or not np.array_equal(self._followed[0], par):
            rows = par[None] if by_row is None else by_row
            pose = self._solve(rows, self._all_loads, _WITHOUT_MEMORY).pose
            self._followed = par.copy(), History.from_record(self.record, rows, pose)
        return self._followed[1]

    def _solve(self, rows: Array, loads: tuple[Array, Array], step_tol2: float, threads: int = 1) -> BatchResult:
        """Solve the equilibria of rows under loads."""
        fast = None
        if len(rows) == 1:
            stations, tip, q_rest, _, _ = work_arrays(self.mesh)
            prepare(rows[0], self.mesh.mesh, self.mesh.nodes, stations, tip, q_rest)
            fast = fast_path(self.mesh, stations, tip, q_rest)
        return solve_cases(self.mesh, fast, rows, *loads, step_tol2, threads)

    def _changes(self, par: Array, keys: Sequence[str]) -> dict[str, dict[int, Array]]:
        """Return how the rows' entries depend on the mechanism's: for each key the places and their slopes, (n,)."""
        by_row = row_parameters(par, self.data)
        base = self._each(par, by_row)
        followed = is_on_path(par) or any(key in on_path() for key in keys)
        history = self._history(par, by_row) if followed else None
        changes = {}
        for key in keys:
            rows: Complex = base.astype(complex)
            rows[:, index(key)] += 1j * _STEP
            if history is not None:
                history.apply(rows, self._only)
            self._hung(rows)
            if key in on_path():  # it acts through other entries alone
                rows[:, index(key)] = base[:, index(key)]
            changes[key] = {int(i): rows[:, i].imag / _STEP for i in np.flatnonzero(rows.imag.any(axis=0))}
        return changes

    def _inherited(self, dpose: dict[str, Array], change: dict[int, Array]) -> Array:
        """Return the readings' derivative by a parameter that acts through other entries, (n, 3)."""
        total = np.zeros((self.n, 3))
        for place, slope in change.items():
            total += dpose[PARAMETERS[place].key] * slope[:, None]
        return total

    def _see(self, rows: Array, keys: Sequence[str], solved: Sensitivities, *, always: bool) -> None:
        """Turn poses into readings, and their derivatives with them."""
        at = {place: keys.index(PARAMETERS[place].key) for place in _CAMERA if PARAMETERS[place].key in keys}
        if not at and not always:
            return
        which, columns = np.array([*at], dtype=np.int64), np.array([*at.values()], dtype=np.int64)
        c_par, J = np.zeros(rows.shape[1], dtype=complex), np.empty((3, 3))
        pose, by = solved.pose, solved.dpose_dpar
        read_derivatives(rows, which, columns, c_par, J, pose, solved.jacobian, solved.compliance, by)
