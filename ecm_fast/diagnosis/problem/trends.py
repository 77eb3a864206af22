"""Trend functions of loads and time: low polynomials and settling, for misfits without a name."""

from collections.abc import Sequence
from itertools import combinations_with_replacement, product

import numpy as np
from numpy.typing import NDArray

from ...data.measurements import Measurements
from ...kernels.history import unfaded_rows
from ...models.instruments.history import Record

__all__ = ["coordinates", "smooth_columns"]

Array = NDArray[np.float64]

_DEGREE, _DRIFT = 3, 2  # highest powers of loads and of time in a trend
_ROWS_PER_TERM = 4  # fewer rows a term would fit the noise
_SMALL = 20.0
"""Tendon force around which a tendon that is not yet tight shows [N]."""
_SETTLING = (15.0, 400.0)
"""Times in which what lags behind a change of load, neck, tendons or camera, is taken to settle [s]."""


def smooth_columns(data: Sequence[Measurements], rows: NDArray[np.bool_]) -> tuple[Array, NDArray[np.int64]]:
    """Return polynomials, (n, q), of the loads of each experiment and of the order of each session, and more.

    What settles after a change of load, and what goes on at small tendon forces, are kinds of their own.
    Which kind a column is of, (q,), is a number from 0 on. `rows` (n,) says which rows count; there are
    never more polynomials than a quarter of these.
    """
    member = np.repeat(np.arange(len(data)), [part.n for part in data])
    experiment = np.concatenate([part.experiment for part in data])
    session = np.concatenate([part.session for part in data])
    _, kind = np.unique(np.rec.fromarrays([member, experiment]), return_inverse=True)
    _, run = np.unique(np.rec.fromarrays([member, session]), return_inverse=True)
    loads = _loads(data)
    experiments, runs = range(int(kind.max()) + 1), range(int(run.max()) + 1)
    of_loads = [column for i in experiments for column in _of_loads(loads, (kind == i) & rows, kind == i)]
    of_order = [column for i in runs for column in _of_order(run == i, rows)]
    groups = [of_loads, of_order, _of_settling(data, rows), _of_small_forces(data, rows)]
    columns = [column for group in groups for column in group]
    kinds = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
    return np.column_stack(columns) if columns else np.zeros((len(rows), 0)), kinds


def coordinates(data: Sequence[Measurements]) -> Array:
    """Return the loads that vary, each from -1 to 1, (n, q)."""
    loads = _loads(data)
    low, span = loads.min(axis=0), np.ptp(loads, axis=0)
    moving = span > 1e-9
    return np.asarray(2.0 * (loads - low)[:, moving] / span[moving] - 1.0)


def _loads(data: Sequence[Measurements]) -> Array:
    """Return what varies: sum and difference of the forces, dead wrench, mass, tilt, (n, 7)."""
    parts = [
        np.column_stack([p.lam_l + p.lam_r, p.lam_l - p.lam_r, p.fx, p.fz, p.tau, p.extra_mass, p.tilt]) for p in data
    ]
    return np.concatenate(parts)


def _of_loads(loads: Array, fit: NDArray[np.bool_], group: NDArray[np.bool_]) -> list[Array]:
    count = int(fit.sum()) // _ROWS_PER_TERM
    if count < 1:
        return []
    center, span = loads[fit].mean(axis=0), np.ptp(loads[fit], axis=0)
    moving = np.flatnonzero(span > 1e-9)
    scaled = 2.0 * (loads[:, moving] - center[moving]) / span[moving]
    terms = [np.ones(len(loads))]
    for degree in range(1, _DEGREE + 1):
        new = [np.prod(scaled[:, list(of)], axis=1) for of in combinations_with_replacement(range(moving.size), degree)]
        if len(terms) + len(new) > count:
            break
        terms += new
    return [np.where(group, term, 0.0) for term in terms]


def _of_order(group: NDArray[np.bool_], rows: NDArray[np.bool_]) -> list[Array]:
    if int((group & rows).sum()) < 5 * _ROWS_PER_TERM:
        return []
    t = np.zeros(group.size)
    t[group] = np.linspace(-1.0, 1.0, int(group.sum()))
    return [np.where(group, t**degree, 0.0) for degree in range(1, _DRIFT + 1)]


def _of_settling(data: Sequence[Measurements], rows: NDArray[np.bool_]) -> list[Array]:
    """Return what is not yet forgotten of earlier tendon forces, their sum and difference, where dwells are known."""
    held = np.concatenate([part.dwell for part in data])
    if int((rows & np.isfinite(held)).sum()) < 5 * _ROWS_PER_TERM:
        return []
    parts = [_forgotten(Record.from_measurements(part)) for part in data]
    return [column for column in np.concatenate(parts).T if column[rows].any()]


def _forgotten(record: Record) -> Array:
    """Return what each time of `_SETTLING` leaves of the change from earlier forces, (n, 4)."""
    data = record.data
    out = np.empty((2 * len(_SETTLING), data.n))
    forces = (data.lam_l + data.lam_r, data.lam_l - data.lam_r)
    for column, (force, time) in zip(out, product(forces, _SETTLING), strict=True):
        unfaded_rows(record.begins, record.held, force, time, column)
    return np.where(np.isfinite(data.dwell), out / max(float(np.ptp(forces, axis=1).max()), 1e-9), 0.0).T


def _of_small_forces(data: Sequence[Measurements], rows: NDArray[np.bool_]) -> list[Array]:
    """Return what goes on in either tendon around a small force, the sum and the difference of both."""
    lam = np.concatenate([part.lam for part in data]) / _SMALL
    left, right = (lam * np.exp(1.0 - lam)).T
    if int((rows & (np.maximum(left, right) > 0.5)).sum()) < 2 * _ROWS_PER_TERM:
        return []
    return [left + right, left - right]
