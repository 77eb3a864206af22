"""Poses that are relative to a rest pose, made absolute.

A camera that is zeroed reads R_i - R_0. What the model reads at rest is added, and how far it is off there, noise of
the zero included, is an origin of each channel that a fit leaves free: R_i - R_0 = R_i + b has nothing else to tell
of R_0. The effects of the camera act on R as they do on any reading; its offsets alone can no longer be seen.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...data.columns import CAMERA_SIGMA, CHANNELS
from ...data.measurements import Measurements
from ...errors import InputError
from ...mechanism.mechanism import Mechanism
from ...mechanism.vector import pack
from ..loads import MIN_TOLERANCE, last_step
from .measuring_chain import MeasuringChain
from .mesh_choice import mesh_for

__all__ = ["ADDED", "ADDED_BY_SESSION", "absolute", "free_origins"]

Array = NDArray[np.float64]

ADDED, ADDED_BY_SESSION = "added", "added by session"
_ORIGINS = ("effects.camera_x_offset", "effects.camera_z_offset", "effects.marker_angle_offset")
_NEAR = 10.0  # noises of a camera of which nothing is known: farther from zero is no row that was zeroed


def absolute(mechanism: Mechanism, data: Measurements) -> Measurements:
    """Return measurements whose poses are relative to the clamp; as they are where they are so already.

    Raises
    ------
    InputError : a pose that should be zero is not, the mechanism has no equilibrium there, or it is no neck.
    """
    if data.zeroed in ("", ADDED, ADDED_BY_SESSION):
        return data
    if data.named or not mechanism.has_pair:
        raise InputError(f"{data.source}: zeroed = {data.zeroed!r} is understood of a neck with the pair of [tendons]")
    par, step = pack(mechanism), last_step(MIN_TOLERANCE)
    first, of = _references(data)
    if data.zeroed == "unloaded":
        rest = Measurements.from_columns({"lam_l_N": [0.0], "lam_r_N": [0.0]})
        read, of = MeasuringChain(mesh_for(mechanism, rest)[0], rest).solve(par, step)[0], 0 * of
    else:
        _check_zero(data, first)
        read = MeasuringChain(mesh_for(mechanism, data)[0], data, first).solve(par, step)[0]
    if not np.isfinite(read).all():
        raise InputError(f"{data.source}: the mechanism has no equilibrium where the poses are zeroed ({data.zeroed})")
    pose = data.pose + read[of]
    done = ADDED_BY_SESSION if data.zeroed == "session" else ADDED
    return replace(data, **dict(zip(CHANNELS, pose.T.copy(), strict=True)), zeroed=done)


def free_origins(parts: Sequence[Measurements]) -> tuple[str, ...]:
    """Return the parameters that a fit has to leave free: the origins of the channels that are measured.

    Raises
    ------
    InputError : only some of the measurements are zeroed.
    """
    zeroed = [bool(part.zeroed) for part in parts]
    if not any(zeroed):
        return ()
    if not all(zeroed):
        one, other = parts[zeroed.index(True)], parts[zeroed.index(False)]
        raise InputError(f"{one.source}: its poses are zeroed at rest, those of {other.source} are not; all or none")
    measured = np.any([part.measured.any(axis=0) for part in parts], axis=0)
    return tuple(key for key, there in zip(_ORIGINS, measured, strict=True) if there)


def _references(data: Measurements) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the rows that were zeroed at, rising, and which of them each row refers to, (n,)."""
    if data.zeroed != "session":
        return np.array([0]), np.zeros(data.n, dtype=np.int64)
    _, first, of = np.unique(data.session, return_index=True, return_inverse=True)
    order = np.argsort(first)
    return first[order], np.argsort(order)[of]


def _check_zero(data: Measurements, rows: NDArray[np.int64]) -> None:
    off = np.abs(np.nan_to_num(data.pose[rows])) > _NEAR * np.array(CAMERA_SIGMA)
    if off.any():
        i, channel = np.argwhere(off)[0]
        unit, value = ("mrad" if channel == 2 else "mm"), 1e3 * data.pose[rows[i], channel]
        raise InputError(f"{data.where(int(rows[i]))}: {CHANNELS[channel]} is {value:.4g} {unit}, though the poses are "
                         f"told to be zeroed there ({data.zeroed})")  # fmt: skip
