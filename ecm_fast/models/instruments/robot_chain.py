"""Readings of a tendon robot: poses of Q and of markers, lengths of tendons; with derivatives.

Readings depend on the equilibrium and on how a marker is fixed. Where tendons are given by length, the derivatives at
held forces follow the constraint: with l the lengths of taut tendons and c their compliances,

    dy|l = dy|lam - dy/dlam (dl/dlam - c)^-1 (dl|lam - lam dc)
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...data.columns import CHANNELS, PAIR, foreign
from ...data.measurements import Measurements
from ...errors import InputError, did_you_mean
from ...kernels.general.tendon_lengths import node_derivatives
from ...kernels.layout import N_STATION, N_TENDONS, N_TIP
from ...mechanism.body import MARKER, TENDON
from ...mechanism.catalogue import CATALOGUE
from ...mechanism.mechanism import Mechanism
from ...mechanism.mesh.discretization import Discretization
from ...mechanism.parameters import FIRST_MARKER, FIRST_TENDON, find, index
from ...mechanism.vector import pack
from ..body import divide, on_mesh
from ..equilibrium import Status
from ..loads import LAM_PLACES, loads_of
from ..refinement import resolve, solutions, work_arrays
from ..robot.tendons import by_length
from ..sensitivity import Sensitivities
from .measuring_chain import MeasuringChain, row_parameters

__all__ = ["RobotChain", "chain_of", "check_columns"]

Array = NDArray[np.float64]
_STEP_TOL2 = 1e-14  # squared last Newton step of the rows that a discretization is chosen by
_FIXED = ("offset_x", "offset_z", "angle")
"""Numbers that fix a marker to its section."""
# effects that act on readings or follow the order of rows, or turn the head against the tip section
_LEFT_OUT = {"path", "camera", "force", "plate"}


def check_columns(mechanism: Mechanism, data: Measurements) -> None:
    """Refuse columns of tendons and markers that the mechanism has not, and tendons without a force and a length."""
    tendons, markers = mechanism.tendon_names, [marker.name for marker in mechanism.markers]
    for name in data.named:
        quantity = name.removeprefix("sigma_")
        kind, _, rest = quantity.partition("_")
        which, known, what = (rest, tendons, "tendon") if kind in ("lam", "len") else (
            quantity.rpartition("_")[0], markers, "marker")  # fmt: skip
        if which not in known:
            column = next((each for each in data.columns if each.startswith(f"{name}_")), name)
            hint = foreign(column) if mechanism.has_pair else did_you_mean(which, known)
            has = f"has {', '.join(known)}" if known else "has none"
            raise InputError(f"{data.source}: column {column}: the mechanism has no {what} {which!r}{hint}; it {has}")
    for name in PAIR:
        if name not in tendons and getattr(data, f"lam_{name}").any():
            raise InputError(f"{data.source}: column lam_{name}: the mechanism has no tendon {name!r}; "
                             f"it has {', '.join(tendons) or 'none'}")  # fmt: skip
    if tendons:
        missing = np.isnan(data.forces(tendons)) & np.isnan(data.lengths(tendons))
        if missing.any():
            i, j = np.argwhere(missing)[0]
            raise InputError(f"{data.where(int(i))}: tendon {tendons[j]} has neither a force nor a length; "
                             "allowed is one of them, or both")  # fmt: skip


class RobotChain:
    """Readings of the instruments in every row, as a function of the parameter vector; see `MeasuringChain`.

    Parameters
    ----------
    mechanism : its names say which column is which
    data : loads, what was changed on the test bed, and which channels are read
    mesh : the discretization; None: one element of order 5 for each piece of the body
    only : (k,) places of the rows that are read, which rise
    channels : what is read, see `Measurements.channels`; default that of the data
    """

    def __init__(
        self,
        mechanism: Mechanism,
        data: Measurements,
        mesh: Discretization | None = None,
        only: NDArray[np.int64] | None = None,
        channels: Sequence[str] | None = None,
    ) -> None:
        check_columns(mechanism, data)
        self.channels = data.channels if channels is None else tuple(channels)
        self.tendons = mechanism.tendon_names
        read = {channel.rpartition("_")[0] for channel in self.channels}
        # markers that nobody reads are no breaks
        self._markers = [(i, marker) for i, marker in enumerate(mechanism.markers) if marker.name in read]
        unread = [i for i, marker in enumerate(mechanism.markers) if marker.name not in read]
        self._unread = [FIRST_MARKER + MARKER.size * i + place for i in unread for place in range(MARKER.size)]
        par = self._own(pack(mechanism))
        beyond = [name for name in mechanism.effects if CATALOGUE[name.split(".")[0]].enters in _LEFT_OUT]
        if beyond:
            raise InputError(f"{data.source}: effects.{beyond[0]}: not known of rows with named tendons or markers; "
                             "take it out of the mechanism")  # fmt: skip
        self.mesh = Discretization.from_elements(divide(par, None)) if mesh is None else mesh
        self._data, self._only = data, slice(None) if only is None else only
        lam = data.forces(self.tendons) if self.tendons else np.zeros((data.n, 0))
        self._given = data.lengths(self.tendons)[self._only] if self.tendons else np.full((len(lam), 0), np.nan)
        self._lam, self._wrench = np.nan_to_num(lam[self._only]), data.wrench[self._only]
        if len(self.tendons) < len(PAIR):
            self._lam = np.hstack([self._lam, np.zeros((self.n, len(PAIR) - len(self.tendons)))])

    @property
    def n(self) -> int:
        """Number of rows that are read."""
        return len(self._lam)

    def rows(self, par: Array) -> Array:
        """Return the parameter vectors of the rows, (1 or n, n_parameters), from the mechanism's (n_parameters,)."""
        by_row = row_parameters(self._own(par), self._data)
        return self._own(par)[None] if by_row is None else by_row[self._only]

    def refine(self, par: Array, allowed: Array) -> Array:
        """Take a discretization whose error is allowed in every row; return the estimated errors, (n,).

        allowed : (n,) in rad and shares of the length
        """
        rows = self.rows(par)
        _, loads, vectors, status, _ = self._solve(rows, _STEP_TOL2)
        lam = loads[:, list(LAM_PLACES[: self._lam.shape[1]])]
        lam[status > Status.UNSTABLE] = self._lam[status > Status.UNSTABLE]
        self.mesh, error = resolve(self.mesh, vectors, lam, self._wrench, allowed)
        return error

    def solve(self, par: Array, step_tol2: float, threads: int = 1) -> tuple[Array, NDArray[np.int64], Array]:
        """Return readings (n, c) [m, rad], nan where there is no equilibrium, status and load factor, (n,) each."""
        found = self.sensitivities((), par, step_tol2)
        return found.pose, found.status, self._factor

    def solve_many(self, par: Array, step_tol2: float) -> tuple[Array, NDArray[np.int64]]:
        """Return readings (w, n, c) and status (w, n) for many mechanisms (w, n_parameters)."""
        found = [self.solve(vector, step_tol2) for vector in par]
        return np.stack([each[0] for each in found]), np.stack([each[1] for each in found])

    def sensitivities(self, names: Sequence[str], par: Array, step_tol2: float) -> Sensitivities:
        """Return readings and their derivatives; `pose` is (n, c), `jacobian` (n, c, m) by readings of force cells."""
        rows = self.rows(par)
        q, loads, vectors, status, self._factor = self._solve(rows, step_tol2)
        which = np.array([index(find(name).key) for name in names], dtype=np.int64)
        n, c, k, m = self.n, len(self.channels), len(which), self._lam.shape[1]
        pose, by, jacobian = np.full((n, c), np.nan), np.full((n, c, k), np.nan), np.full((n, c, m), np.nan)
        compliance = np.full((n, 3, 3), np.nan)
        work = _Work(self.mesh, k, rows.shape[1])
        places = self._places(par)
        known = [*CHANNELS, *(f"{name}_{axis}" for name in places for axis in CHANNELS),
                 *(f"len_{name}" for name in self.tendons)]  # fmt: skip
        for i in np.flatnonzero(status <= Status.UNSTABLE):
            vector = vectors[i] if len(vectors) > 1 else vectors[0]
            work.differentiate(self.mesh, vector, which, loads[i], q[i])
            compliance[i] = work.compliance
            for j, channel in enumerate(self.channels):
                if channel not in known:  # of another experiment
                    by[i, j], jacobian[i, j] = 0.0, 0.0
                    continue
                pose[i, j], at_q, by[i, j] = self._read(channel, places, vector, which, q[i], work)
                jacobian[i, j] = work.moved[:m] @ at_q * work.gain[:m]
            self._hold_lengths(self._given[i], loads[i], vector, which, work, by[i], jacobian[i])
        return Sensitivities(pose, jacobian, compliance, by, tuple(names), status)

    def _own(self, par: Array) -> Array:
        par = par.copy()
        par[self._unread] = 0.0
        return par

    def _solve(self, rows: Array, step_tol2: float) -> tuple[Array, Array, Array, NDArray[np.int64], Array]:
        """Return nodes (n, 3 n_nodes), loads (n, N_LOADS), parameter vectors (1 or n, ...), status, load factor."""
        found = solutions(self.mesh, rows, self._lam, self._wrench, step_tol2)
        q, status, factor, loads = found.q, found.status, found.load_factor, loads_of(self._lam, self._wrench)
        held = np.flatnonzero(np.isfinite(self._given).any(axis=1))
        if held.size:
            rows = np.broadcast_to(rows, (self.n, rows.shape[1])).copy()
        for i in held:
            case = by_length(self.mesh, rows[i], loads[i], self._given[i])
            q[i], loads[i], rows[i], status[i], factor[i] = case.q, case.loads, case.par, case.status, case.factor
        return q, loads, rows, status, factor

    def _places(self, par: Array) -> dict[str, tuple[int, int]]:
        """Return node and number of every marker by its name."""
        vector, nodes = self._own(par), self.mesh.nodes
        found = {}
        for i, marker in self._markers:
            place = vector[FIRST_MARKER + MARKER.size * i + MARKER["place"]]
            node = nodes.size - 1 if marker.on_head else int(np.argmin(np.abs(nodes - on_mesh(vector, place))))
            found[marker.name] = node, i
        return found

    def _read(
        self,
        channel: str,
        places: dict[str, tuple[int, int]],
        par: Array,
        which: NDArray[np.int64],
        q: Array,
        work: "_Work",
    ) -> tuple[float, Array, Array]:
        """Return a reading, its derivative by the nodes, (3 n_nodes,), and by the parameters at held forces, (k,)."""
        name, _, what = channel.rpartition("_")
        if channel in CHANNELS or name in places:
            node, slot = places.get(name, (q.size // 3 - 1, -1))
            at_q, place = np.zeros(q.size), 3 * node + CHANNELS.index(what)
            at_q[place] = 1.0
            if slot < 0:
                return float(q[place]), at_q, work.by_par[:, place]
            first = FIRST_MARKER + MARKER.size * slot
            x, z, angle = (par[first + MARKER[entry]] for entry in _FIXED)
            s, c = np.sin(q[3 * node + 2]), np.cos(q[3 * node + 2])
            ahead, across = x * c + z * s, z * c - x * s
            offset, by_theta, by_fixed = {
                "x": (ahead, across, (c, s, 0.0)),
                "z": (across, -ahead, (-s, c, 0.0)),
                "theta": (angle, 1.0, (0.0, 0.0, 1.0)),
            }[what]
            at_q[3 * node + 2] = by_theta
            by = work.by_par @ at_q
            for entry, slope in zip(_FIXED, by_fixed, strict=True):
                by[which == first + MARKER[entry]] += slope
            return float(q[place] + offset), at_q, by
        tendon = self.tendons.index(channel.removeprefix("len_"))
        return float(work.length[tendon]), work.gradient[tendon], work.length_by_par[:, tendon]

    def _hold_lengths(
        self,
        given: Array,
        loads: Array,
        par: Array,
        which: NDArray[np.int64],
        work: "_Work",
        by: Array,
        jacobian: Array,
    ) -> None:
        """Turn derivatives at held forces into those at held lengths; slack tendons stay slack.

        given : (m,) free lengths [m], nan of tendons given by force; loads : (N_LOADS,), par : (n_parameters,)
        """
        held = np.flatnonzero(np.isfinite(given))
        lam = loads[list(LAM_PLACES)]
        taut = held[lam[held] > 0.0]
        if taut.size:
            compliance = FIRST_TENDON + TENDON.size * taut + TENDON["compliance"]
            by_lam = work.gradient[taut] @ work.moved.T * work.gain
            change = by_lam[:, taut] - np.diag(par[compliance])
            miss = work.length_by_par[:, taut].T - lam[taut, None] * (which == compliance[:, None])
            by -= jacobian[:, taut] @ np.linalg.solve(change, miss)
            jacobian -= jacobian[:, taut] @ np.linalg.solve(change, by_lam[:, : jacobian.shape[1]])
        jacobian[:, held] = 0.0
        # errors of cells that nobody reads
        unread = FIRST_TENDON + TENDON.size * held[:, None] + [TENDON["gain"], TENDON["zero"]]
        by[:, np.isin(which, unread)] = 0.0


class _Work:
    """Work space and results of `node_derivatives`.

    mesh : the discretization; k : number of parameters; n_parameters : length of a vector
    """

    def __init__(self, mesh: Discretization, k: int, n_parameters: int) -> None:
        n = 3 * mesh.nodes.size
        stations, tip, q_rest, step, work = work_arrays(mesh)
        self._system = stations, tip, q_rest, work, step
        sizes = [(n_parameters,), (k, len(mesh.mesh), N_STATION), (k, N_TIP), (k, n), (n,), (n,), (9,),
                 (N_TENDONS,), (N_TENDONS, n), (N_TENDONS,)]  # fmt: skip
        self._complex = tuple(np.zeros(size, dtype=complex) for size in sizes)
        self.length, self.gradient, self.gain = np.empty(N_TENDONS), np.empty((N_TENDONS, n)), np.empty(N_TENDONS)
        self.moved, self.compliance = np.empty((N_TENDONS, n)), np.empty((3, 3))
        self.by_par, self.length_by_par = np.empty((k, n)), np.empty((k, N_TENDONS))

    def differentiate(self, mesh: Discretization, par: Array, which: NDArray[np.int64], loads: Array, q: Array) -> None:
        """Overwrite the results by those of one equilibrium."""
        tendons = self.length, self.gradient, self.gain, self.moved
        system, results = (self._system, self._complex), (self.compliance, self.by_par, self.length_by_par)
        node_derivatives(mesh.tables, mesh.mesh, mesh.nodes, par, which, loads, q, *system, tendons, *results)


def chain_of(
    mechanism: Mechanism,
    data: Measurements,
    mesh: Discretization | None = None,
    only: NDArray[np.int64] | None = None,
    channels: Sequence[str] | None = None,
) -> MeasuringChain | RobotChain:
    """Return the measuring chain of a mechanism: of a neck without markers the quick one, with its effects."""
    if mechanism.has_pair and not data.named and channels in (None, CHANNELS):
        return MeasuringChain(Discretization.from_elements(1) if mesh is None else mesh, data, only)
    if data.hanging.any():
        raise InputError(f"{data.source}: slack = {data.slack:g} is understood of a neck alone, without markers")
    return RobotChain(mechanism, data, mesh, only, channels)
