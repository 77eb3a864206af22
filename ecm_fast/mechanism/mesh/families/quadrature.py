"""Gauss points and polynomials on the unit interval."""

import numpy as np
from numpy.typing import NDArray

__all__ = ["gauss_rule", "integrals", "lagrange", "lobatto_nodes"]

Array = NDArray[np.float64]


def gauss_rule(gauss: int) -> tuple[Array, Array]:
    """Return places and weights of the Gauss points, (gauss,) each; the weights add up to 1."""
    points, weights = np.polynomial.legendre.leggauss(gauss)
    return 0.5 * (1.0 + points), 0.5 * weights


def lobatto_nodes(order: int) -> Array:
    """Return the Gauss-Lobatto places of order + 1 nodes: the interpolation that is best conditioned."""
    inner = np.polynomial.legendre.Legendre.basis(order).deriv().roots().real
    nodes: Array = 0.5 * (1.0 + np.concatenate([[-1.0], inner, [1.0]]))
    return nodes


def integrals(gauss: int, upper: Array) -> Array:
    """Return integrals from 0 to `upper` of the polynomials that are 1 at one Gauss point, (len(upper), gauss)."""
    points, _ = gauss_rule(gauss)
    degree = np.arange(1, gauss + 1)
    result: Array = (upper[:, None] ** degree / degree) @ np.linalg.inv(np.vander(points, increasing=True))
    return result


def lagrange(nodes: Array, places: Array) -> Array:
    """Lagrange polynomials on `nodes` and their derivatives, (29) for two nodes, at `places`.

    Returns shape (2, n_places, n_nodes): values, derivatives.
    """
    out = np.empty((2, len(places), len(nodes)))
    for a, node in enumerate(nodes):
        others = np.delete(nodes, a)
        out[0, :, a] = np.prod((places[:, None] - others) / (node - others), axis=1)
        slopes = [
            np.prod((places[:, None] - np.delete(others, k)) / (node - np.delete(others, k)), axis=1) / (node - other)
            for k, other in enumerate(others)
        ]
        out[1, :, a] = np.sum(slopes, axis=0)
    return out
