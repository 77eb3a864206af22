"""One element whose strains are polynomials: its energy. Residual and tangent follow by the complex step."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...mechanism.mesh.families import lagrange, lobatto_nodes
from .parameters import Parameters, beam_weight
from .section import section_energy

__all__ = ["strain_energy"]


def strain_energy(stations: Sequence[Parameters], order: int, h: Any, q: Any, share: float = 1.0) -> Any:
    """[P1] Energy of an element of length `h` and of its weight [N m].

    stations : the parameters at every Gauss point, see `section.station`
    q : (3 (order + 1),) poses at the ends; of inner node k the coefficients of P_k in h gamma_x and h gamma_z [m], and
        the angle there

        theta(xi) = Lagrange polynomial of the angles,   h gamma = mean + sum over k of P_k(2 xi - 1) (q_k, q_k+1)
        r(xi) = r_0 + integral of R(theta) h gamma,      the mean such that r(1) = r_1

    Integrals along the element are those of the polynomials through the values at the Gauss points.
    """
    gauss = len(stations)
    points, weights = np.polynomial.legendre.leggauss(gauss)
    points, weights = (1.0 + points) / 2.0, weights / 2.0
    values, slopes = lagrange(lobatto_nodes(order), points)
    theta, kappa = values @ q[2::3], slopes @ q[2::3] / h
    axes = [np.array([[np.cos(t), np.sin(t)], [-np.sin(t), np.cos(t)]]) for t in theta]
    inner = np.zeros((gauss, 2), dtype=q.dtype)
    for k in range(1, order):
        inner = inner + np.outer(np.polynomial.legendre.Legendre.basis(k)(2.0 * points - 1.0), q[3 * k : 3 * k + 2])
    missing = q[-3:-1] - q[0:2] - sum(w * R @ shift for w, R, shift in zip(weights, axes, inner, strict=True))
    mean = np.linalg.solve(sum(w * R for w, R in zip(weights, axes, strict=True)), missing)
    along = np.array([R @ (mean + shift) for R, shift in zip(axes, inner, strict=True)])
    # the polynomials that are 1 at one Gauss point, integrated by as many Gauss points between 0 and another: exact
    shares = np.array([upper * (weights @ lagrange(points, upper * points)[0]) for upper in points])
    places = q[0:2] + shares @ along
    total = 0.0
    for g, p in enumerate(stations):
        gamma = (mean + inner[g]) / h
        load = share * beam_weight(p)
        density = section_energy(p, np.array([*gamma, kappa[g]])) - load @ places[g]
        total = total + weights[g] * h * density
    return total
