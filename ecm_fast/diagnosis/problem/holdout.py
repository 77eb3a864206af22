"""The hold-out split: rows that no step of a diagnosis sees before its end."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...data.measurements import Measurements

__all__ = ["SHARE", "lock", "regions"]

SHARE = 0.25  # of the rows; a quarter costs the fit 15 % in precision and tests it on enough
_FEWEST = 16  # rows; of fewer, none can be spared
_SIDE = 3  # regions a side of the load plane, each of which gives its share


def lock(data: Sequence[Measurements], seed: int) -> NDArray[np.bool_]:
    """Return which rows are set aside, (n,): a quarter of the loads of every session and region, repeats together.

    None where there are too few to spare.
    """
    rng = np.random.default_rng(seed)
    return np.concatenate([_lock_one(part, rng) for part in data])


def _lock_one(data: Measurements, rng: np.random.Generator) -> NDArray[np.bool_]:
    measured = data.measured.any(axis=1)
    locked = np.zeros(data.n, dtype=bool)
    if measured.sum() < _FEWEST:
        return locked
    alone = np.array([f"row {i}" for i in range(data.n)])
    _, load = np.unique(np.where(data.pose_id == "", alone, data.pose_id), return_inverse=True)
    _, first = np.unique(load, return_index=True)
    stratum = np.rec.fromarrays([data.experiment[first], data.session[first], regions(data)[first]])
    order = np.lexsort((rng.random(first.size), np.unique(stratum, return_inverse=True)[1]))
    start = int(rng.integers(round(1.0 / SHARE)))
    taken = order[start :: round(1.0 / SHARE)]
    locked[:] = np.isin(load, taken)
    return locked & measured


def regions(data: Measurements) -> NDArray[np.int64]:
    """Return the region of every row's load, (n,): a third of the range each of the forces' sum and difference."""
    total, difference = data.lam_l + data.lam_r, data.lam_l - data.lam_r
    return np.asarray(_SIDE * _third(total) + _third(difference))


def _third(values: NDArray[np.float64]) -> NDArray[np.int64]:
    span = float(np.ptp(values))
    share = (values - values.min()) / span if span > 0.0 else np.zeros_like(values)
    return np.minimum((share * _SIDE).astype(np.int64), _SIDE - 1)
