"""Tolerance of an effect's law: its signature, changed a little by smooth functions.

Bending that levels off, a stop that comes to bear softly, a drift that settles: the effect is the right one, and its
law is not quite the catalogue's. What that leaves is proportional to the effect's own size. It is taken as the effect's
signature times functions of load, pose, time, channel and of the effect's own size in a row, each with an amplitude of
a share of the effect, one standard deviation, and marginalized in the fit. A camera that was zeroed at rest shows its
effects less what they are there.
"""

import numpy as np
from numpy.typing import NDArray

from ...data.measurements import Measurements

__all__ = ["FUNCTIONS", "POSITION_ANGLE", "SHARES", "law_columns", "modulations"]

Array = NDArray[np.float64]

SHARES = (0.1, 0.03, 0.0)
"""Amplitudes of each function that are tried, as shares of the effect, one standard deviation: a law that differs much,
little, or not at all but for a zeroed camera."""
FUNCTIONS = {
    "theta": "more on one side",
    "|theta|": "with the angle",
    "theta^2": "with the angle",
    "pull": "with the tendon forces",
    "pull^2": "with the tendon forces",
    "side": "more on one side",
    "t": "with time",
    "t^2": "with time",
    "slack": "where a tendon is slack",
    "size": "with its own size",
    "size^2": "with its own size",
    "x": "between the channels",
    "z": "between the channels",
    "theta alone": "between the channels",
}
"""Words for each function, in the order of the columns."""
POSITION_ANGLE = np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
"""What is zeroed together: both coordinates of the position, or the angle."""
_SLACK = 2.0  # reading below which a tendon may be slack [N]
_SMALLEST = 1e-9  # spread of a function below which it is a constant


def modulations(data: tuple[Measurements, ...], pose: Array) -> Array:
    """Return functions of load, pose and time, (n, k), that the law of any effect may go with.

    pose : (n, 3) predicted
    """
    lam, t = np.concatenate([part.lam for part in data]), np.concatenate([_elapsed(part) for part in data])
    theta, pull = pose[:, 2], lam.sum(axis=1)
    side = np.sign(theta)
    slack = (lam < _SLACK).any(axis=1)
    return np.column_stack([theta, np.abs(theta), theta * theta, pull, pull * pull, side, t, t * t, slack])


def _elapsed(part: Measurements) -> Array:
    """Time since the first row, as a share of all of it; by rows where times are not given."""
    t = part.t if np.isfinite(part.t).all() and np.ptp(part.t) > 0.0 else np.arange(float(part.n))
    return np.asarray((t - t.min()) / max(float(np.ptp(t)), 1.0))


def law_columns(change: Array, functions: Array, whitening: Array, share: float) -> Array:
    """Return one standard deviation of how the law of one effect may differ, whitened, (n, 3, 14).

    Parameters
    ----------
    change : (n, 3) of the readings by the effect
    functions : (n, 9) that its law may go with, its own size in a row and the channels left out
    whitening : (n, 3, 3), singular where a reading is missing
    share : amplitude of each function
    """
    signature = (whitening @ change[:, :, None])[:, :, 0]
    weight = (signature**2).sum(axis=1)
    total = float(weight.sum())
    if not total > 0.0:
        return np.zeros((*signature.shape, len(FUNCTIONS)))
    size = np.sqrt(weight / weight.max())
    all_functions = np.column_stack([functions, size, size * size])
    off = all_functions - weight @ all_functions / total
    spread = np.sqrt(weight @ off**2 / total)
    vary = spread > _SMALLEST * np.maximum(np.abs(all_functions).max(axis=0), 1e-300)
    factor = np.where(vary, off / np.where(vary, spread, 1.0), 0.0)
    channels = whitening @ (change[:, :, None] * np.eye(3))
    channels = np.sqrt(3.0) * (channels - signature[:, :, None] / 3.0)
    return np.asarray(share * np.concatenate([signature[:, :, None] * factor[:, None, :], channels], axis=2))
