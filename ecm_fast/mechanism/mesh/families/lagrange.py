"""Lagrange elements: x, z and theta are polynomials of the same degree, the paper's (28) of any order."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .family import Family
from .quadrature import gauss_rule, integrals, lagrange, lobatto_nodes

__all__ = ["LAGRANGE"]

Array = NDArray[np.float64]


def _tables(order: int, gauss: int) -> Array:
    """Shape functions, their derivatives, and what lifts slopes to positions, (3, gauss, order + 1).

    The third are the integrals from 0 to each node of the polynomials that are 1 at one Gauss point. They rebuild an
    element's positions from the slopes at its Gauss points, exactly. With more points than the order no positions
    have arbitrary slopes there: then all zero.
    """
    nodes = lobatto_nodes(order)
    basis = lagrange(nodes, gauss_rule(gauss)[0])
    lift = integrals(gauss, nodes).T if gauss == order else np.zeros((gauss, order + 1))
    return np.concatenate([basis, lift[None]])


@lru_cache(maxsize=64)
def _values(order: int, places: tuple[float, ...]) -> Array:
    """Return the shape functions at places of an element, (n, order + 1); pictures ask for the same ones every time."""
    values: Array = lagrange(lobatto_nodes(order), np.array(places))[0]
    return values


def _centerline(order: int, gauss: int, q: Array, places: Array) -> Array:
    poses: Array = np.einsum("pa,pac->pc", _values(order, tuple(places.tolist())), q)
    return poses


LAGRANGE = Family(
    name="lagrange",
    meaning="x, z and theta are polynomials of one degree; with more Gauss points than the order it locks in shear",
    highest_order=6,
    points=lambda order: order,
    tip_order=lambda order: 2 * order,
    inner_places=True,
    tables=_tables,
    centerline=_centerline,
)
