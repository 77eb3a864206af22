"""Other starts of a fit whose first one leaves a doubt: by increasing load, and each parameter larger and smaller."""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from ..data.columns import LOADS, usual_sigma
from ..mechanism.parameters import find
from .result import Objective
from .rows import FitRows

__all__ = ["starts"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_SHARES = (0.25, 0.5, 1.0)  # of the rows, those of small loads first
_FACTOR = 3.0  # of what is always above 0, such as a stiffness; anything else goes up and down by its typical size
_NEAR_ENOUGH = 0.1  # standard deviations: a start need not be a minimum


def starts(rows: FitRows, objective: Callable[[Array, Mask], Objective], start: Array) -> Iterator[Array]:
    """Yield values (p,) to fit from, besides `start`: few, and each in another valley where there is one.

    objective : from weights (n, c, c) and the readings in use (n, c) to the sum of squares
    """
    eased = _by_load(rows, objective, start)
    lower, upper = rows.bounds()
    if eased is not None:
        yield eased
    for i, name in enumerate(rows.names):
        entry = find(name)
        up, down = (_FACTOR * start[i], start[i] / _FACTOR) if entry.lower > 0.0 else (
            start[i] + entry.typical, start[i] - entry.typical)  # fmt: skip
        for value in (up, down):
            moved = start.copy()
            moved[i] = np.clip(value, lower[i], upper[i])
            yield moved


def _by_load(rows: FitRows, objective: Callable[[Array, Mask], Objective], start: Array) -> Array | None:
    """Return values fitted to the rows of small loads, then to more: where these lead to, large loads are not far."""
    values, moved = start, False
    loads = np.column_stack([rows.joined(name) for name in LOADS])
    size = np.linalg.norm(loads / np.maximum(np.abs(loads).max(axis=0), 1e-300), axis=1)
    sigma = usual_sigma(rows.channels)
    counted = rows.wanted.any(axis=1)
    for share in _SHARES:
        state = rows.at(values)
        small = size <= np.quantile(size[counted], share)
        used = rows.wanted & (state.stable & small)[:, None]
        if int(used.sum()) < values.size:
            continue
        sum_of_squares = objective(np.eye(sigma.size) / sigma * used[:, None, :], used)
        found = sum_of_squares.minimum(values, _NEAR_ENOUGH)
        values, moved = found.values, True
    return values if moved else None
