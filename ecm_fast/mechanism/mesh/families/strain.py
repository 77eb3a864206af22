"""Strain elements: curvature, stretch and shear are polynomials of degree order - 1; poses follow by integration.

The pose at an element's end is the integral of its strains at the Gauss points. In the plane the angle's integral is
a polynomial and the position is linear in stretch and shear, so both ends' poses give the mean strains in closed
form: no inner iteration. What is left inside are the angles at the inner nodes, as in a Lagrange element, and as the
"positions" of inner node k the element length times the coefficients of stretch and shear for the Legendre polynomial
of degree k. With as many Gauss points as the order, tip and angles are those of the Lagrange element; one point more
makes the integration good enough for the strains alone to limit the accuracy.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .family import Family
from .quadrature import gauss_rule, lagrange, lobatto_nodes

__all__ = ["STRAIN", "StrainTables"]

Array = NDArray[np.float64]


class StrainTables(NamedTuple):
    """Tables for the kernel `kernels.strain` at the Gauss points.

    Attributes
    ----------
    weights : (gauss,) of the Gauss points, with the sum 1
    basis : (2, gauss, order + 1) shape functions of the angle and their derivatives
    modes : (gauss, order) Legendre polynomials of degree 0 to order - 1 on [0, 1]
    beyond : (gauss, gauss) integrals from one Gauss point to 1 of the polynomials that are 1 at another
    """

    weights: Array
    basis: Array
    modes: Array
    beyond: Array


def _modes(order: int, places: Array) -> Array:
    """Legendre polynomials on [0, 1], (n_places, order); all but the first have no mean."""
    return np.ascontiguousarray(np.polynomial.legendre.legvander(2.0 * places - 1.0, order - 1))


def _integrals(gauss: int, upper: Array) -> Array:
    """Integrals from 0 to `upper` of the polynomials that are 1 at one Gauss point, (len(upper), gauss).

    By Legendre polynomials, which the Gauss points keep orthogonal: to rounding for any number of points.
    """
    points, weights = gauss_rule(gauss)
    higher = np.polynomial.legendre.legvander(2.0 * upper - 1.0, gauss)
    lower = np.concatenate([-np.ones((len(upper), 1)), higher[:, : gauss - 1]], axis=1)
    # (2 k + 1) times the integral of P_k is half of P_{k + 1} - P_{k - 1}
    result: Array = 0.5 * (higher[:, 1:] - lower) @ _modes(gauss, points).T * weights
    return result


def _tables(order: int, gauss: int) -> StrainTables:
    points, weights = gauss_rule(gauss)
    basis = lagrange(lobatto_nodes(order), points)
    return StrainTables(weights, basis, _modes(order, points), weights - _integrals(gauss, points))


def _centerline(order: int, gauss: int, q: Array, places: Array) -> Array:
    points, weights = gauss_rule(gauss)
    nodes, angles = lobatto_nodes(order), q[:, :, 2]
    ways = np.exp(-1j * angles @ lagrange(nodes, points)[0].T)  # of the sections' normals, as x + i z
    ends = q[:, :, 0] + 1j * q[:, :, 1]
    inner = ends[:, 1:-1] @ _modes(order, points)[:, 1:].T
    mean = (ends[:, -1] - ends[:, 0] - (ways * inner) @ weights) / (ways @ weights)
    r = ends[:, 0] + np.sum(_integrals(gauss, places) * ways * (mean[:, None] + inner), axis=1)
    theta = np.sum(lagrange(nodes, places)[0] * angles, axis=1)
    return np.stack([r.real, r.imag, theta], axis=1)


STRAIN = Family(
    name="strain",
    meaning="strains are polynomials of degree order - 1, integrated to poses; never locks",
    highest_order=6,
    points=lambda order: order + 1,
    tip_order=lambda order: 2 * order,
    inner_places=False,
    tables=_tables,
    centerline=_centerline,
)
