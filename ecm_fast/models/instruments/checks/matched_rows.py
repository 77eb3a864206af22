"""Matched rows: mirrored loads, loads reached from both sides, one load at different times."""

from itertools import combinations_with_replacement
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....data.columns import LOADS
from ....data.measurements import Measurements

__all__ = [
    "MOST_PAIRS",
    "approach",
    "leaning",
    "load_table",
    "match",
    "mirrored",
    "reach_of",
    "repeats",
    "smooth",
]

Array = NDArray[np.float64]
Places = NDArray[np.int64]

_MIRROR = (1, 0, 2, 3, 4, 5, 6)  # places of the loads of a mirrored row: left and right change places
_MIRROR_SIGNS = np.array([1.0, 1.0, 1.0, -1.0, -1.0, 1.0, -1.0])
_LEAST = np.array([1.0, 1.0, 1.0, 1.0, 0.05, 0.02, 0.003])
"""[N, N, N, N, N m, kg, rad] what differs by less is one load: force cells are noisy, also with the tendons off."""
_NEAR = 0.04
"""Loads this share of the largest one apart are compared, after the smooth fit has moved one to the other."""
_EXACT = 0.005
"""The same where the rows are too few for a smooth fit, and of loads that are repeated."""
_NEIGHBORS = 8  # of a row among which its partner is looked for: comparing all with all grows with the square
_HIGHEST_DEGREE, _ROWS_EACH = 5, 4  # of the smooth fit, and rows for each of its coefficients
MOST_PAIRS = 2000  # a bound on time: more pairs tell no more of a symmetry


def load_table(data: Measurements) -> Array:
    """Return what was applied in every row, (n, 7), in the order of `LOADS`."""
    return np.column_stack([getattr(data, name) for name in LOADS])


def mirrored(loads: Array) -> Array:
    """Return the loads seen in a mirror that exchanges left and right."""
    image: Array = loads[:, _MIRROR] * _MIRROR_SIGNS
    return image


def leaning(loads: Array) -> NDArray[np.int64]:
    """Return to which side the loads lean, (n,): 1, -1, or 0 for loads that are their own mirror image."""
    off = loads - mirrored(loads)
    sides = np.sign(np.where(np.abs(off) > _LEAST, off, 0.0))[:, (0, 3, 4, 6)]
    first = np.argmax(sides != 0.0, axis=1)
    return np.take_along_axis(sides, first[:, None], axis=1)[:, 0].astype(np.int64)


def smooth(loads: Array, values: Array, at: Array) -> Array | None:
    """Return a polynomial in the loads, fitted to `values` (n, c), at other loads (m, 7); None for too few rows.

    It only has to bridge the small distance between loads that are compared.
    """
    span = np.abs(loads).max(axis=0)
    varied = np.flatnonzero(np.ptp(loads, axis=0) > 2.0 * _LEAST)
    unit = loads[:, varied] / span[varied], at[:, varied] / span[varied]
    for degree in range(_HIGHEST_DEGREE, 0, -1):
        powers = [p for d in range(degree + 1) for p in combinations_with_replacement(range(varied.size), d)]
        if _ROWS_EACH * len(powers) <= len(loads):
            basis, basis_at = (np.column_stack([u[:, list(p)].prod(axis=1) for p in powers]) for u in unit)
            fitted: Array = basis_at @ np.linalg.lstsq(basis, values, rcond=1e-10)[0]
            return fitted
    return None


def match(one: Array, other: Array, label: Places, near: float) -> Places:
    """Return pairs (k, 2) of a row of `one` and another row of `other` whose loads agree, no row twice.

    Parameters
    ----------
    one, other : (n, 7) loads of the same rows, or those of their mirror images
    label : (n,) labels; a pair has two different ones
    near : share of the largest load that counts as agreement
    """
    from scipy.spatial import KDTree

    reach = np.maximum(near * np.maximum(np.abs(one).max(axis=0), np.abs(other).max(axis=0)), _LEAST)
    nearest = list(range(1, min(_NEIGHBORS, len(one)) + 1))
    distance: Any
    place: Any
    distance, place = KDTree(other / reach).query(one / reach, nearest, p=np.inf, distance_upper_bound=1.0 + 1e-9)
    i, column = np.nonzero(np.isfinite(distance))
    j = place[i, column]
    good = label[i] != label[j]
    i, j, column = i[good], j[good], column[good]
    taken, pairs = np.zeros(len(one), dtype=bool), []
    for entry in np.argsort(distance[i, column], kind="stable"):
        a, b = int(i[entry]), int(j[entry])
        if not (taken[a] or taken[b]):
            taken[[a, b]] = True
            pairs.append((a, b))
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def reach_of(loads: Array, pose: Array) -> float:
    """Return how far apart loads may be for a comparison, as a share of the largest."""
    return _EXACT if smooth(loads, pose, loads[:1]) is None else _NEAR


def approach(data: Measurements) -> NDArray[np.int64]:
    """Return from which side each load was reached, (n,): 1 where lam_l - lam_r rose, -1 where it fell, else 0."""
    difference = data.lam_l - data.lam_r
    step = np.diff(difference, prepend=difference[:1])
    begun = np.r_[True, data.session[1:] != data.session[:-1]]
    least = max(_EXACT * float(data.lam.max(initial=0.0)), _LEAST[0])
    return np.where(begun | (np.abs(step) <= least), 0, np.sign(step)).astype(np.int64)


def repeats(data: Measurements) -> list[Places]:
    """Return groups of at least two rows that repeat one load: by ``pose_id``, else by the loads themselves."""
    if not data.n:
        return []
    if (data.pose_id != "").any():
        _, label = np.unique(np.char.add(np.char.add(data.experiment, "\0"), data.pose_id), return_inverse=True)
        label = np.where(data.pose_id != "", label, -1)
    else:
        loads = load_table(data)
        step = np.maximum(_EXACT * np.abs(loads).max(axis=0), _LEAST)
        label = np.unique(np.round(loads / step), axis=0, return_inverse=True)[1].ravel()
    order = np.argsort(label, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
    return [group for group in groups if group.size > 1 and label[group[0]] >= 0]
