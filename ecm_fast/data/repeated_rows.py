"""Copies of rows: the same readings under the same load, to the last digit, are the same evidence."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .columns import CHANNELS, LOADS
from .measurements import Measurements

__all__ = ["repeated_rows", "without_poses"]

_COMPARED = (*LOADS, *CHANNELS)
"""Readings and loads. Time stamps and labels are not among them: a copy may have been given new ones."""


def repeated_rows(parts: Sequence[Measurements]) -> list[NDArray[np.bool_]]:
    """Return for each set of measurements which of its rows with a pose repeat an earlier row of any set, (n,) each."""
    named = sorted({name for part in parts for name in part.named})
    blank = [np.full(part.n, np.nan) for part in parts]
    table = np.concatenate([
        np.column_stack([*(getattr(part, name) for name in _COMPARED), *(part.named.get(name, none) for name in named)])
        for part, none in zip(parts, blank, strict=True)
    ])  # fmt: skip
    table = np.where(np.isnan(table), np.inf, table)  # blanks are alike
    repeated = np.ones(len(table), dtype=bool)
    repeated[np.unique(table, axis=0, return_index=True)[1]] = False
    repeated &= np.concatenate([np.isfinite(part.readings(part.channels)).any(axis=1) for part in parts])
    return np.split(repeated, np.cumsum([part.n for part in parts])[:-1])


def without_poses(data: Measurements, rows: NDArray[np.bool_]) -> Measurements:
    """Return measurements with the poses of some rows blank: what these loads do to later rows stays."""
    return data.blank(np.broadcast_to(rows[:, None], (data.n, len(data.channels))), data.channels)
