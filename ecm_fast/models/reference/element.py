"""One Lagrange element: energy, internal force less dead load, tangent.

`stations` are the parameters of every Gauss point, see `section.station`.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from .parameters import Parameters, beam_weight
from .section import section_energy, section_law, section_stiffness, section_strains

__all__ = ["element_energy", "element_force", "element_tangent"]


def _kinematics(values: Any, slopes: Any, h: float, q: Any) -> tuple[Any, Any, Any]:
    """Centerline, strains and the strains' derivatives by q at one Gauss point, (28), (33), [S1]."""
    x, z, theta = q[0::3], q[1::3], q[2::3]
    derivative = slopes / h
    dr, turn = np.array([derivative @ x, derivative @ z]), values @ theta
    strains = section_strains(dr, turn, derivative @ theta)
    c, s = np.cos(turn), np.sin(turn)
    B = np.zeros((3, q.size), dtype=np.result_type(q, float))
    B[0, 0::3], B[0, 1::3], B[0, 2::3] = c * derivative, -s * derivative, -strains[1] * values
    B[1, 0::3], B[1, 1::3], B[1, 2::3] = s * derivative, c * derivative, strains[0] * values
    B[2, 2::3] = derivative
    return np.array([values @ x, values @ z]), strains, B


def element_energy(
    stations: Sequence[Parameters], basis: Any, weights: Any, h: float, q: Any, share: float = 1.0
) -> Any:
    """Energy of an element of length `h` and of its weight [N m]; its gradient is `element_force`."""
    total = 0.0
    for p, values, slopes, weight in zip(stations, *basis, weights, strict=True):
        r, strains, _ = _kinematics(values, slopes, h, q)
        total = total + weight * h * (section_energy(p, strains) - share * beam_weight(p) @ r)
    return total


def element_force(
    stations: Sequence[Parameters], basis: Any, weights: Any, h: float, q: Any, share: float = 1.0
) -> Any:
    """[E1] Internal force of an element less its dead load, (3 n_a,); zero everywhere in equilibrium.

        sum over Gauss points of  w h (B^T (N, Q, M) - share rho A N^T g)

    Written out, the rows of B^T give (36), with x', z' there the derivatives by arclength and the factor
    Delta L / 2 on the second part of the theta row; gravity is (38). `share` scales the dead load.
    """
    force = np.zeros(q.size, dtype=np.result_type(q, *stations[0].values(), float))
    for p, values, slopes, weight in zip(stations, *basis, weights, strict=True):
        _, strains, B = _kinematics(values, slopes, h, q)
        density = share * beam_weight(p)
        force = force + weight * h * (B.T @ section_law(p, strains))
        force[0::3] -= weight * h * values * density[0]
        force[1::3] -= weight * h * values * density[1]
    return force


def element_tangent(stations: Sequence[Parameters], basis: Any, weights: Any, h: float, q: Any) -> Any:
    """[E2] Derivative of `element_force` by q, (3 n_a, 3 n_a), symmetric.

    w h (B^T D B + N d2(gamma_x) + Q d2(gamma_z)),   d2 the second derivatives of the strains by q
    """
    K = np.zeros((q.size, q.size))
    for p, values, slopes, weight in zip(stations, *basis, weights, strict=True):
        _, strains, B = _kinematics(values, slopes, h, q)
        N, Q, _ = section_law(p, strains)
        turn = values @ q[2::3]
        c, s = np.cos(turn), np.sin(turn)
        derivative = slopes / h
        second = np.zeros((q.size, q.size))
        # d2(gamma_x) = -(s x' + c z') by theta, d2(gamma_z) = (c x' - s z') by theta; by theta twice: -gamma
        second[0::3, 2::3] = np.outer(derivative, values) * (-s * N + c * Q)
        second[1::3, 2::3] = np.outer(derivative, values) * (-c * N - s * Q)
        second += second.T
        second[2::3, 2::3] = -np.outer(values, values) * (N * strains[0] + Q * strains[1])
        K += weight * h * (B.T @ section_stiffness(p, strains) @ B + second)
    return K
