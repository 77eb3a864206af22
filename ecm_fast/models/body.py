"""Bodies on a mesh: the pieces between breaks, places, markers."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..kernels.body import body_length, count_pieces, next_break
from ..mechanism.body import MARKER, MOST, SEGMENT, TENDON
from ..mechanism.parameters import FIRST_MARKER, FIRST_SEGMENT, FIRST_TENDON, PLACES

__all__ = ["breaks", "divide", "has_body", "lengths_of", "on_mesh", "piece_ends"]

Array = NDArray[np.float64]
_LENGTHS = FIRST_SEGMENT + SEGMENT.size * np.arange(MOST["segment"]) + SEGMENT["length"]
_THERE = np.concatenate([
    _LENGTHS[:1],
    FIRST_TENDON + TENDON.size * np.arange(MOST["tendon"]) + TENDON["route"],
    FIRST_MARKER + MARKER.size * np.arange(MOST["marker"]) + MARKER["place"],
])  # fmt: skip
"""Entries of the vector of which one is not 0 where a body may have more than one piece."""


def has_body(par: Array) -> NDArray[np.bool_]:
    """Return which mechanisms have segments, named tendons or markers, (n,); par : (n, n_parameters)."""
    return np.asarray(par[:, _THERE].any(axis=1))


def lengths_of(par: Array) -> Array:
    """Return the lengths of undeformed bodies, (n,) [m]; par : (n, n_parameters)."""
    segments = par[:, _LENGTHS].sum(axis=1)
    body = np.where(segments > 0.0, segments, par[:, PLACES.beam_length])
    return np.asarray(body + par[:, PLACES.effects_beam_length])


def breaks(par: Array) -> Array:
    """Return the breaks of a body from clamp to end, (k + 1,) [m], see `kernels.body`; par : (n_parameters,)."""
    length, found = body_length(par), [0.0]
    for _ in range(count_pieces(par, length)):
        found.append(next_break(par, found[-1], length))
    return np.array(found)


def piece_ends(par: Array) -> tuple[float, ...]:
    """Return where pieces end inside the mesh, as shares of it; none where bodies have one piece.

    par : (n, n_parameters)

    Raises
    ------
    InputError : the bodies differ in how many pieces they have.
    """
    rows = par[has_body(par)]
    if not len(rows):
        return ()
    if len(rows) < len(par):
        rows = np.concatenate([rows, par[~has_body(par)][:1]])
    counts = {count_pieces(row, body_length(row)) for row in rows}
    if len(counts) > 1:
        raise InputError(f"bodies of {' and '.join(map(str, sorted(counts)))} pieces in one batch: allowed are bodies "
                         "whose segments, guided tendons and markers begin and end in the same order")  # fmt: skip
    (k,) = counts
    return tuple(np.arange(1, k) / k)


def on_mesh(par: Array, places: ArrayLike) -> Array:
    """Return where places along the undeformed body [m] are on a mesh, as shares of it; par : (n_parameters,)."""
    ends = breaks(par)
    return np.interp(np.asarray(places, dtype=np.float64), ends, np.linspace(0.0, 1.0, ends.size))


def divide(par: Array, elements: int | ArrayLike | None) -> int | ArrayLike:
    """Return elements for `Discretization` that end at every break of a body.

    par : (n_parameters,)
    elements : how many in all, rounded up to as many for each piece; or relative lengths, to which breaks are added
    """
    ends = breaks(par)
    k = ends.size - 1
    if k == 1:
        return 1 if elements is None else elements
    if elements is None or isinstance(elements, (int, np.integer)):
        return k * max(1, -(-int(elements or 1) // k))
    given = np.asarray(elements, dtype=np.float64)
    if given.ndim != 1 or given.size == 0 or not np.isfinite(given).all() or not (given > 0.0).all():
        return elements  # `Discretization` says what is wrong
    inner = on_mesh(par, ends[-1] * np.cumsum(given)[:-1] / given.sum())
    shares = np.unique(np.round(np.concatenate([np.linspace(0.0, 1.0, k + 1), inner]), 12))
    return np.diff(shares)
