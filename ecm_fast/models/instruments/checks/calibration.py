"""Robust calibration: the stiffnesses at which a model meets most readings, whatever a few columns or rows hold.

Gauss-Newton steps with Cauchy weights. The scale of a channel is the median size of its residuals, so that a channel
in another unit, or a third of the rows, counts for little beside the readings that the model explains.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ....data.columns import LOADS, PAIR
from ....data.measurements import Measurements
from ....mechanism.mechanism import Mechanism
from ....mechanism.mesh.discretization import Discretization
from ....mechanism.parameters import find, index
from ....mechanism.sections import STIFFNESSES
from ....mechanism.vector import pack
from ...equilibrium import Status
from ..measuring_chain import MeasuringChain

__all__ = ["CELLS", "MEDIAN_TO_SIGMA", "Calibration", "calibrate", "moved_force", "newtons", "scales", "with_force"]

Array = NDArray[np.float64]

CELLS = LOADS[:5]
"""Loads that a cell reads: forces of the pair of tendons, and the dead wrench at Q."""

_STEPS = 12  # Gauss-Newton steps at most
_SETTLED = 1e-3  # of a stiffness; what it is off by then is far below what a wrong column does
_LARGEST_STEP = 0.5  # of the logarithm of a stiffness
_LARGEST_FORCE_STEP = 60.0  # [N]
_CAUCHY = 2.385  # scales; 95 % as efficient as least squares on Gaussian noise (Holland and Welsch, 1977)
MEDIAN_TO_SIGMA = 1.4826  # of Gaussian noise
_ROUGHLY, _UNKNOWN = 0.5, 3.0
"""Standard deviation of the logarithm of a stiffness that the mechanism gives roughly, and of one that is asked for."""
_LOST = 0.1  # share of the rows that a step may leave without an equilibrium
_LAST_STEP = 1e-14  # squared; an error far below a micrometre
_LEAST_SCALE = (1e-7, 1e-7, 1e-6)  # [m, m, rad], for readings without noise


@dataclass(frozen=True, eq=False)
class Calibration:
    """A model with the stiffnesses that meet the readings.

    Attributes
    ----------
    stiffnesses : values by name
    moved : (k,) logarithms of these over the mechanism's own
    origin, origin_std : (3,) origins of the channels and their standard deviations, 0 where not free [m, m, rad]
    pose : (n, 3) predicted readings, origins left out; nan without a stable equilibrium
    residual : (n, 3) measured less predicted, origins taken off
    dpose_dlam : (n, 3, 2) derivatives of the pose by the tendon forces, 0 without an equilibrium
    force : (n,) forces of the cell that is not believed, else readings of the first one
    """

    stiffnesses: dict[str, float]
    moved: Array
    origin: Array
    origin_std: Array
    pose: Array
    residual: Array
    dpose_dlam: Array
    force: Array


def scales(residual: Array) -> Array:
    """Return the scale of each channel, (3,), from the median size of its residuals."""
    return np.array(
        [
            max(MEDIAN_TO_SIGMA * float(np.median(sizes)), least) if sizes.size else least
            for sizes, least in zip((np.abs(c[np.isfinite(c)]) for c in residual.T), _LEAST_SCALE, strict=True)
        ]
    )


def calibrate(
    mechanism: Mechanism,
    data: Measurements,
    rows: NDArray[np.int64],
    *,
    unknown: Collection[str] = (),
    free: Sequence[int] = (),
    blind: int | None = None,
) -> Calibration:
    """Calibrate EA, GA and EI on some rows of measurements.

    Parameters
    ----------
    mechanism : where the search starts
    data : all rows, for effects of the path
    rows : (n,) places of the rows that count, rising
    unknown : stiffnesses of which not even the order of magnitude is known
    free : channels whose origin is free
    blind : place in `CELLS` of the one of which no reading is believed: each row has the force that meets its pose best
    """
    chain = MeasuringChain(Discretization.from_elements(1, 5), data, rows)
    force = getattr(data, CELLS[blind or 0])[rows].copy()
    start, places, measured = pack(mechanism), [index(name) for name in STIFFNESSES], data.pose[rows]
    k, p = len(places), len(places) + len(free)
    std = [_UNKNOWN if name in unknown else _ROUGHLY for name in STIFFNESSES]
    lower, upper = np.log([[max(find(name).lower, 1e-12), find(name).upper] for name in STIFFNESSES]).T
    precision = np.concatenate([np.power(std, -2.0), np.zeros(len(free))])
    origin, at, step, kept = np.zeros(3), np.log(start[places]), np.zeros(k), 0
    for count in range(_STEPS):
        for share in (1.0, 0.5, 0.25):
            logs, par = np.clip(at + share * step, lower, upper), start.copy()
            par[places] = np.exp(logs)
            found = chain.sensitivities(STIFFNESSES, par, _LAST_STEP)
            stable = found.status == Status.CONVERGED
            if stable.sum() >= kept - _LOST * len(rows):
                break
        at, kept, moved = logs, int(stable.sum()), logs - np.log(start[places])
        pose = np.where(stable[:, None], found.pose, np.nan)
        off = measured - pose
        for channel in free:
            known = off[np.isfinite(off[:, channel]), channel] - origin[channel]
            origin[channel] += np.median(known) if known.size and count < 2 else 0.0
        off -= origin
        slope = np.zeros((len(rows), 3, p))
        slope[:, :, :k] = np.where(stable[:, None, None], found.dpose_dpar * par[places], 0.0)
        slope[:, free, range(k, p)] = 1.0
        if blind is not None:
            along = np.where(stable[:, None], found.by_load[:, :, blind], 0.0)
            off, slope, ask = _without(off, slope, along)
        normal, pull = _normal_equations(off, slope.reshape(-1, p))
        prior = precision * np.concatenate([moved, np.zeros(len(free))])
        whole = np.linalg.lstsq(normal + np.diag(precision), pull - prior, rcond=1e-12)[0]
        step = np.clip(whole[:k], -_LARGEST_STEP, _LARGEST_STEP)
        if np.abs(step).max() < _SETTLED and count > 1:
            break
        origin[list(free)] += whole[k:]
        if blind is not None:
            force = moved_force(mechanism, blind, force, ask)
            chain = MeasuringChain(chain.mesh, with_force(data, rows, blind, force), rows)
    origin_std = np.zeros(3)
    origin_std[list(free)] = np.sqrt(np.abs(np.diag(np.linalg.pinv(normal + np.diag(precision)))))[k:]
    dpose_dlam = np.where(stable[:, None, None], found.jacobian, 0.0)
    return Calibration(dict(zip(STIFFNESSES, np.exp(at).tolist(), strict=True)), moved, origin, origin_std, pose, off,
                       dpose_dlam, force)  # fmt: skip


def with_force(data: Measurements, rows: NDArray[np.int64], cell: int, force: Array) -> Measurements:
    """Return measurements with other forces in some rows of a cell, by its place in `CELLS`."""
    values = getattr(data, CELLS[cell]).copy()
    values[rows] = force
    return replace(data, **{CELLS[cell]: values})


def moved_force(mechanism: Mechanism, cell: int, force: Array, step: Array) -> Array:
    """Return the readings of a cell after a step of bounded length; tendons do not push."""
    longest = _LARGEST_FORCE_STEP * newtons(mechanism, cell)
    moved: Array = force + np.clip(step, -longest, longest)
    return np.maximum(moved, 0.0) if cell < len(PAIR) else moved


def newtons(mechanism: Mechanism, cell: int) -> float:
    """Return what one newton is in the unit of a cell: the beam's length for a couple, else 1."""
    return mechanism.length if CELLS[cell] == "tau" else 1.0


def _without(off: Array, slope: Array, along: Array) -> tuple[Array, Array, Array]:
    """Return residuals (n, 3) and slopes (n, 3, p) without what a force of each row changes, and what it asks of that.

    along : (n, 3) derivative of the pose by the force
    """
    scale, known = scales(off), np.isfinite(off)
    unit = np.where(known, along / scale, 0.0)
    size = np.maximum((unit**2).sum(axis=1), 1e-12)
    white = np.where(known, off, 0.0) / scale
    ask = (unit * white).sum(axis=1) / size
    rest = np.where(known, (white - ask[:, None] * unit) * scale, np.nan)
    tall = np.where(known[:, :, None], slope / scale[:, None], 0.0)
    tall -= unit[:, :, None] * ((unit[:, :, None] * tall).sum(axis=1) / size[:, None])[:, None, :]
    return rest, tall * scale[:, None], ask


def _normal_equations(off: Array, slope: Array) -> tuple[Array, Array]:
    """Return the matrix (p, p) and the right side (p,) of a step, readings weighed by their distance."""
    scale = scales(off)
    known = np.isfinite(off)
    off = np.where(known, off, 0.0)
    weight = (np.where(known, 1.0 / (1.0 + (off / (_CAUCHY * scale)) ** 2), 0.0) / scale**2).ravel()
    return (slope.T * weight) @ slope, (slope.T * weight) @ off.ravel()
