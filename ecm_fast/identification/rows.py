"""The rows of a fit: several experiments as one system."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..data.measurements import Measurements
from ..errors import InputError, shown
from ..mechanism.derived import limits
from ..mechanism.mechanism import Mechanism
from ..mechanism.mesh.discretization import Discretization
from ..mechanism.parameters import find, index
from ..mechanism.vector import pack
from ..models.equilibrium import Status
from ..models.instruments.measuring_chain import CHANGES, row_parameters
from ..models.instruments.mesh_choice import mesh_for
from ..models.instruments.robot_chain import chain_of

__all__ = ["FitRows", "FitSet", "State", "common_mesh", "prior_std"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_LAST_STEP = 1e-13  # squared; what Newton's method leaves is then far below any noise
_REMEMBERED = 3  # states, of which a fit asks for the last ones again
_LEAST = 1e-12  # standard deviation of a prior, as a share of its value: less is no number to divide by


@dataclass(frozen=True, eq=False)
class FitSet:
    """One experiment: what it was done on, what was measured, and which channels of it count."""

    mechanism: Mechanism
    data: Measurements
    channels: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        for name in self.channels or ():
            if name not in self.data.channels:
                raise InputError(f"channel = {name!r}: allowed is {' or '.join(map(repr, self.data.channels))}")
        if self.channels == ():
            raise InputError(f"{self.data.source}: no channel to fit; allowed are {', '.join(self.data.channels)}")

    @property
    def counted(self) -> Measurements:
        """The measurements with the channels blank that do not count."""
        if self.channels is None:
            return self.data
        left_out = ~np.isin(self.data.channels, self.channels)
        return self.data.blank(np.broadcast_to(left_out, (self.data.n, left_out.size)), self.data.channels)


@dataclass(frozen=True, eq=False)
class State:
    """All rows at one set of parameters.

    Attributes
    ----------
    values : (p,)
    pose : (n, c) readings [m, rad], nan without an equilibrium
    by : (n, c, p) their derivatives by the parameters
    dpose_dlam : (n, c, m) by the tendon forces
    status : (n,) values of `Status`
    """

    values: Array
    pose: Array
    by: Array = field(repr=False)
    dpose_dlam: Array = field(repr=False)
    status: NDArray[np.int64] = field(repr=False)

    @property
    def stable(self) -> Mask:
        """Whether each row has a stable equilibrium, (n,)."""
        return np.equal(self.status, Status.CONVERGED)

    def among(self, n: int, rows: NDArray[np.int64]) -> "State":
        """Return this state of `rows` as one of n rows, the others without an equilibrium."""

        def spread(values: Array) -> Array:
            whole = np.full_like(values, np.nan, shape=(n, *values.shape[1:]))
            whole[rows] = values
            return whole

        status = np.full(n, Status.NOT_CONVERGED, dtype=np.int64)
        status[rows] = self.status
        return State(self.values, spread(self.pose), spread(self.by), spread(self.dpose_dlam), status)


def common_mesh(sets: Sequence[FitSet], start: Discretization | None = None) -> tuple[Discretization, int]:
    """Return a discretization whose error is at most a tenth of the noise in all experiments, and in how many rows not.

    start : the coarsest that may be returned, see `mesh_choice.mesh_for`
    """
    mesh, unresolved = start, 0
    for entry in sets:
        mesh, excess = mesh_for(entry.mechanism, entry.data, mesh)
        unresolved += int((excess > 1.0).sum())
    assert mesh is not None
    return mesh, unresolved


class FitRows:
    """The rows of all experiments, one below the other, as functions of the parameters that they share.

    A state is that of `only` these rows, (k,) places that rise, default all; the order of loads is that of all.
    """

    def __init__(
        self,
        sets: Sequence[FitSet],
        names: Sequence[str],
        mesh: Discretization,
        only: NDArray[np.int64] | None = None,
    ) -> None:
        self.sets, self.names, self.mesh = tuple(sets), tuple(names), mesh
        self.places = [index(name) for name in names]
        self._bases = [pack(entry.mechanism) for entry in sets]
        self.channels = tuple(dict.fromkeys(name for entry in sets for name in entry.data.channels))
        shares = _shares(sets, only)
        self._chains = [
            chain_of(entry.mechanism, entry.data, mesh, share, self.channels)
            for entry, share in zip(sets, shares, strict=True)
        ]
        self._memory: list[State] = []
        self.solves = 0
        self.measured = np.concatenate([entry.data.readings(self.channels) for entry in sets])
        counted = [np.isin(self.channels, entry.channels or self.channels) for entry in sets]
        counts = np.repeat(counted, [entry.data.n for entry in sets], axis=0)
        self.wanted: Mask = counts & np.isfinite(self.measured)
        self.member = np.repeat(np.arange(len(sets)), [entry.data.n for entry in sets])
        for base, entry in zip(self._bases, sets, strict=True):
            row_parameters(base, entry.data)  # complains about a row that cannot be, before anything is solved

    @property
    def n(self) -> int:
        """Number of rows."""
        return len(self.member)

    def joined(self, name: str) -> Array:
        """Return a column of the measurements for all rows."""
        return np.concatenate([getattr(entry.data, name) for entry in self.sets])

    @property
    def declared(self) -> Array:
        """Noise that the readings declare, (n, c) [m, rad], nan where they do not."""
        return np.concatenate([entry.data.sigmas(self.channels) for entry in self.sets])

    def where(self, i: int) -> str:
        """Return the place of a row as a user finds it."""
        first = int(np.argmax(self.member == self.member[i]))
        return self.sets[int(self.member[i])].data.where(i - first)

    def bounds(self) -> tuple[Array, Array]:
        """Return the bounds of the parameters, (p,) each: with every row's own change they stay in their table's."""
        bounds = np.array([[limits(name, base) for name in self.names] for base in self._bases])
        lower, upper = bounds[:, :, 0].max(axis=0), bounds[:, :, 1].min(axis=0)
        changed = {index(key): self.joined(name) for name, key in CHANGES.items()}
        for i, place in enumerate(self.places):
            if place in changed:
                lower[i] -= min(float(changed[place].min()), 0.0)
                upper[i] -= max(float(changed[place].max()), 0.0)
        return lower, upper

    def at(self, values: Array) -> State:
        """Solve all rows, and differentiate them, by one call each; what was just asked for is remembered."""
        for known in self._memory:
            if np.array_equal(known.values, values):
                return known
        parts = []
        for base, chain in zip(self._bases, self._chains, strict=True):
            par = base.copy()
            par[self.places] = values
            parts.append(chain.sensitivities(self.names, par, _LAST_STEP))
        self.solves += sum(chain.n for chain in self._chains)
        found = [
            np.concatenate([getattr(part, name) for part in parts]) if len(parts) > 1 else getattr(parts[0], name)
            for name in ("pose", "dpose_dpar", "jacobian", "status")
        ]
        state = State(values.copy(), *found)
        self._memory = [state, *self._memory[: _REMEMBERED - 1]]
        return state

    def residual(self, state: State) -> Array:
        """Return measured less predicted, (n, c) [m, rad], nan where either is missing."""
        return self.measured - state.pose


def prior_std(name: str, value: float, std: float, *, free: bool = False) -> float:
    """Return the standard deviation of a prior, or raise where it cannot be meant; inf is one where that is `free`."""
    entry = find(name)
    least = _LEAST * (abs(value) or entry.typical)
    if not (least <= std < np.inf or (free and std == np.inf)):
        raise InputError(f"standard deviation {shown(std)} of the prior for {name}: allowed is a finite number > 0, "
                         f"from {least:g} {entry.unit} on")  # fmt: skip
    return float(std)


def _shares(sets: Sequence[FitSet], only: NDArray[np.int64] | None) -> list[NDArray[np.int64] | None]:
    """Return the share that each of the experiments has in places among the rows of all."""
    if only is None:
        return [None] * len(sets)
    ends = np.cumsum([entry.data.n for entry in sets])
    return [part - (end - entry.data.n) for part, end, entry in
            zip(np.split(only, np.searchsorted(only, ends[:-1])), ends, sets, strict=True)]  # fmt: skip
