"""The rows of a fit: several experiments as one system, and the noise of each reading."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..data.columns import COLUMNS, usual_sigma
from ..data.measurements import Measurements
from ..errors import InputError, real, shown
from ..mechanism.derived import limits
from ..mechanism.mechanism import Mechanism
from ..mechanism.parameters import find, index
from ..mechanism.vector import pack
from ..mesh.discretization import Discretization
from ..models.equilibrium import Status
from ..models.instruments.measuring_chain import CHANGES, row_parameters
from ..models.instruments.mesh_choice import mesh_for
from ..models.instruments.robot_chain import chain_of
from .variance_components import VarianceComponents, variance_components

__all__ = ["FitRows", "FitSet", "Noise", "State", "check_force_sigma", "common_mesh", "prior_std"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

DECLARED, REPLICATES, RESIDUAL = "declared", "replicates", "residual"
"""Where a standard deviation comes from."""

_LAST_STEP = 1e-13  # squared; what Newton's method leaves is then far below any noise
_SMALLEST_SIGMA = 1e-8  # [m, rad] what the default discretization is good for
_ROUNDING = 1e-12  # of a variance that the forces make: below it the camera's share cannot be told from rounding
_FEWEST_REPEATS = 6
_REMEMBERED = 3
_MEDIAN_TO_SIGMA = 1.4826  # of Gaussian noise


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
        """Which rows have a stable equilibrium, (n,)."""
        return np.equal(self.status, Status.CONVERGED)

    def among(self, n: int, rows: NDArray[np.int64]) -> "State":
        """Return this state of `rows` as one of n rows, the others without an equilibrium."""

        def spread(own: Array) -> Array:
            whole = np.full_like(own, np.nan, shape=(n, *own.shape[1:]))
            whole[rows] = own
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
            chain_of(entry.mechanism, entry.data, mesh, own, self.channels)
            for entry, own in zip(sets, shares, strict=True)
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
        """How many rows there are."""
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


@dataclass(frozen=True, eq=False)
class Noise:
    """How far readings can be trusted.

    Attributes
    ----------
    sigma : (n, c) standard deviation of each reading of the camera [m, rad]; nan where the residual has to tell
    force : (n,) of each reading of the force cells [N]
    origin : (n, c) where each sigma comes from
    dof : degrees of freedom behind the least known of the known ones
    """

    sigma: Array
    force: Array
    origin: NDArray[np.str_]
    dof: float = np.inf

    @classmethod
    def of(cls, rows: FitRows, start: State, force_sigma: float | None) -> "Noise":
        """Return the noise that the measurements declare, else that of rows which repeat one load.

        Raises
        ------
        InputError : a row declares that it has no noise at all.
        """
        sigma = rows.declared
        none = rows.wanted & (sigma == 0.0)
        if none.any():
            i, channel = np.argwhere(none)[0]
            raise InputError(f"{rows.where(i)}: sigma_{rows.channels[channel]} = 0: a fit weighs readings by their "
                             "noise; leave the column out where it is not known")  # fmt: skip
        force = rows.joined("sigma_lam") if force_sigma is None else np.full(rows.n, force_sigma)
        force, sigma = np.nan_to_num(force), np.maximum(sigma, _SMALLEST_SIGMA)
        origin = np.where(np.isfinite(sigma), DECLARED, RESIDUAL).astype(f"U{len(REPLICATES)}")
        unknown = cls(sigma, force, origin)
        return unknown._with_replicates(rows, start)

    def fixed(self, used: Mask) -> bool:
        """Whether the weights of the readings in use are known before the fit."""
        return not self.force.any() and not np.isnan(self.sigma[used]).any()

    def _with_replicates(self, rows: FitRows, start: State) -> "Noise":
        """Fill in what the scatter among rows of one load tells, channel by channel and experiment by experiment.

        The scatter is that of measured less predicted, so that loads which are repeated not quite exactly do not
        count as noise; the force cells' share, which it contains, is taken off.
        """
        sigma, origin, least = self.sigma.copy(), self.origin.copy(), self.dof
        missing = rows.wanted & np.isnan(sigma)
        labels = rows.joined("pose_id")
        if not missing.any() or not (labels != "").any():
            return self
        residual, carried = rows.residual(start), self.carried(start)
        _, load = np.unique(np.rec.fromarrays([rows.member.astype(str), labels]), return_inverse=True)
        for number in range(len(rows.sets)):
            for channel in range(len(rows.channels)):
                here = (rows.member == number) & missing[:, channel] & (labels != "") & start.stable
                dof, variance = _pooled(residual[here, channel], load[here])
                if dof >= _FEWEST_REPEATS:
                    share = float(carried[here, channel, channel].mean())
                    own = (rows.member == number) & missing[:, channel]
                    sigma[own, channel], origin[own, channel] = _camera(variance, share), REPLICATES
                    least = min(least, dof)
        return Noise(sigma, self.force, origin, least)

    def filled(self, rows: FitRows, state: State, used: Mask) -> Array:
        """Return `sigma` with the robust scale of the residual where nothing else is known, (n, c).

        The scale is that of the median of the residuals' sizes, which outliers do not spoil. The parameters' degrees of
        freedom are shared among the channels by how many readings each has.
        """
        sigma = self.sigma.copy()
        residual, carried = rows.residual(state), self.carried(state)
        lost = len(rows.names) / max(int(used.sum()), 1)
        for here, channel in self._groups(rows, used):
            off = residual[here, channel]
            kept = max(off.size * (1.0 - lost), 1.0)
            spread = (_MEDIAN_TO_SIGMA * np.median(np.abs(off))) ** 2 * off.size
            share = float(carried[here, channel, channel].mean())
            sigma[here, channel] = _camera(float(spread) / kept, share)
        return sigma

    def components(
        self, rows: FitRows, state: State, used: Mask, prior: tuple[Array, Array], *, robust: bool
    ) -> VarianceComponents | None:
        """Return the variances that the residual has to tell, None where there are none.

        prior : see `variance_components`
        """
        groups = self._groups(rows, used)
        if not groups:
            return None
        masks = np.zeros((len(groups), *used.shape), dtype=bool)
        for mask, (here, channel) in zip(masks, groups, strict=True):
            mask[:, channel] = here
        return variance_components(
            np.where(used, rows.residual(state), 0.0),
            np.where(used[:, :, None], state.by, 0.0),
            self.sigma,
            masks,
            usual_sigma(rows.channels),
            lambda sigma: self.whitening(sigma, state, used),
            prior,
            robust=robust,
        )

    def _groups(self, rows: FitRows, used: Mask) -> list[tuple[Mask, int]]:
        """Return rows (n,) and channel of readings that share a variance nobody knows."""
        missing = used & np.isnan(self.sigma)
        each = [(missing[:, i] & (rows.member == k), i) for k in range(len(rows.sets)) for i in range(used.shape[1])]
        return [(here, channel) for here, channel in each if here.any()]

    def carried(self, state: State) -> Array:
        """Return the covariance that the force cells' noise makes in the readings, (n, c, c)."""
        if not self.force.any():
            return np.zeros((*state.pose.shape, state.pose.shape[1]))
        scaled = np.nan_to_num(state.dpose_dlam) * self.force[:, None, None]
        return scaled @ scaled.transpose(0, 2, 1)

    def whitening(self, sigma: Array, state: State, used: Mask) -> Array:
        """Return the matrices (n, c, c) that make the errors of a row independent and of unit size, 0 where unused."""
        diagonal = np.where(used, sigma, 1.0)
        out, each = np.zeros((*sigma.shape, sigma.shape[1])), np.arange(sigma.shape[1])
        if self.force.any():
            covariance = self.carried(state) * (used[:, :, None] & used[:, None, :])
            covariance[:, each, each] *= 1.0 + _ROUNDING
            covariance[:, each, each] += diagonal**2
            out[:] = np.linalg.inv(np.linalg.cholesky(covariance))
        else:
            out[:, each, each] = 1.0 / diagonal
        return out * used[:, None, :]


def check_force_sigma(value: float | None) -> None:
    """Complain about a noise of the force readings [N] that a column could not declare either."""
    largest = COLUMNS["sigma_lam"].largest
    if value is not None and not 0.0 <= real("force_sigma", value) <= largest:
        raise InputError(f"force_sigma = {shown(value)}: allowed is a finite number >= 0, at most {largest:g} N")


def prior_std(name: str, value: float, std: float, *, free: bool = False) -> float:
    """Return the standard deviation of a prior, or raise where it cannot be meant; inf is one where that is `free`."""
    entry = find(name)
    least = _ROUNDING * (abs(value) or entry.typical)
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


def _pooled(values: Array, group: NDArray[np.int64]) -> tuple[int, float]:
    """Return degrees of freedom and variance of values about the means of their groups."""
    if not values.size:
        return 0, np.nan
    _, group, count = np.unique(group, return_inverse=True, return_counts=True)
    off = values - (np.bincount(group, values) / count)[group]
    dof = values.size - count.size
    return dof, float(off @ off) / max(dof, 1)


def _camera(variance: float, share: float) -> float:
    """Return the camera's standard deviation, where forces have a `share` in the variance seen; never nothing."""
    return max(float(np.sqrt(max(variance - share, 0.01 * variance))), _SMALLEST_SIGMA)
