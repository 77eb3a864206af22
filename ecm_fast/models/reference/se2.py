"""One element of constant strains between two poses: its energy. Residual and tangent follow by the complex step."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from .parameters import Parameters, beam_weight
from .section import section_energy

__all__ = ["se2_energy"]


def _turned(theta: Any) -> Any:
    """Matrix whose columns are the section's axes e_x^C and e_z^C in (x, z)."""
    c, s = np.cos(theta), np.sin(theta)
    return np.array([[c, s], [-s, c]])


def se2_energy(stations: Sequence[Parameters], weights: Any, h: Any, q: Any, share: float = 1.0) -> Any:
    """[H1] Energy of an element of length `h` and of its weight [N m], at the poses q = (x, z, theta) of both ends.

        V h gamma = R(theta_0)^T (r_1 - r_0),   h kappa = phi = theta_1 - theta_0,   V = integral of R(phi xi) over xi

    the logarithm of SE(2) with its integral taken as it stands, by 20 Gauss points: exact to rounding to phi = 6.
    The center of mass is r_0 + R(theta_0) W h gamma, with W the integral of (1 - xi) R(phi xi). `stations` are the
    parameters at every Gauss point, see `section.station`.
    """
    places, shares = np.polynomial.legendre.leggauss(20)
    r, turn = q[3:5] - q[0:2], q[5] - q[2]
    V, W = 0.0, 0.0
    for xi, weight in zip((1.0 + places) / 2.0, shares / 2.0, strict=True):
        V = V + weight * _turned(turn * xi)
        W = W + weight * (1.0 - xi) * _turned(turn * xi)
    stretch = np.linalg.solve(V, _turned(q[2]).T @ r)
    center = q[0:2] + _turned(q[2]) @ W @ stretch
    strains = np.array([stretch[0] / h, stretch[1] / h, turn / h])
    total = 0.0
    for p, weight in zip(stations, weights, strict=True):
        load = share * beam_weight(p)
        total = total + weight * h * (section_energy(p, strains) - load @ center)
    return total
