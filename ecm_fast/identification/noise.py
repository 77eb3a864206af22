"""The noise of each reading of a fit: declared, from rows that repeat a load, or left for the residual to tell."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..data.columns import COLUMNS, usual_sigma
from ..errors import InputError, real, shown
from .rows import FitRows, State
from .variance_components import MEDIAN_TO_SIGMA, VarianceComponents, variance_components

__all__ = ["DECLARED", "RESIDUAL", "ReadingNoise", "check_force_sigma"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

DECLARED, REPLICATES, RESIDUAL = "declared", "replicates", "residual"
"""Sources of a standard deviation."""

_SMALLEST_SIGMA = 1e-8  # [m, rad] what the default discretization is good for
_ROUNDING = 1e-12  # of a variance that the forces make: below it the camera's share is rounding
_FEWEST_REPEATS = 6  # degrees of freedom that a scatter of repeated loads is taken from


@dataclass(frozen=True, eq=False)
class ReadingNoise:
    """Noise of each reading of a fit.

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
    def from_rows(cls, rows: FitRows, start: State, force_sigma: float | None) -> "ReadingNoise":
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

    def _with_replicates(self, rows: FitRows, start: State) -> "ReadingNoise":
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
                replicated = (rows.member == number) & missing[:, channel] & (labels != "") & start.stable
                dof, variance = _pooled(residual[replicated, channel], load[replicated])
                if dof >= _FEWEST_REPEATS:
                    share = float(carried[replicated, channel, channel].mean())
                    of_set = (rows.member == number) & missing[:, channel]
                    sigma[of_set, channel], origin[of_set, channel] = _camera(variance, share), REPLICATES
                    least = min(least, dof)
        return ReadingNoise(sigma, self.force, origin, least)

    def filled(self, rows: FitRows, state: State, used: Mask) -> Array:
        """Return `sigma` with the robust scale of the residual where nothing else is known, (n, c).

        The scale is that of the median of the residuals' sizes, which outliers do not spoil. The parameters' degrees of
        freedom are shared among the channels by how many readings each has.
        """
        sigma = self.sigma.copy()
        residual, carried = rows.residual(state), self.carried(state)
        lost = len(rows.names) / max(int(used.sum()), 1)
        for group, channel in self._groups(rows, used):
            off = residual[group, channel]
            kept = max(off.size * (1.0 - lost), 1.0)
            spread = (MEDIAN_TO_SIGMA * np.median(np.abs(off))) ** 2 * off.size
            share = float(carried[group, channel, channel].mean())
            sigma[group, channel] = _camera(float(spread) / kept, share)
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
        for mask, (group, channel) in zip(masks, groups, strict=True):
            mask[:, channel] = group
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
        return [(group, channel) for group, channel in each if group.any()]

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
