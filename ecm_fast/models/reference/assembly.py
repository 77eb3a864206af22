"""The whole beam: energy for every family; residual, tangent and Newton's method for Lagrange elements."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from ...mechanism.mesh.discretization import Discretization
from .body import at_place, body_at, element_ends
from .element import element_energy, element_force, element_tangent
from .parameters import Parameters, length
from .se2 import se2_energy
from .section import station
from .strain import strain_energy
from .tip import tip_energy, tip_stiffness, tip_wrench

__all__ = ["energy", "gradient", "newton_step", "residual", "rest_coordinates", "solve", "stations", "tangent"]


def stations(p: Parameters, mesh: Discretization, loads: Any = None) -> list[list[Parameters]]:
    """Parameters at every Gauss point of every element; `loads` give guided tendons their tensions."""
    ends, points = element_ends(p, mesh.shares) / length(p), np.polynomial.legendre.leggauss(mesh.gauss)[0]
    elements = []
    for first, last in pairwise(ends):
        places = [first + (1.0 + xi) / 2.0 * (last - first) for xi in points]
        along = [body_at(p, place * length(p)) for place in places]
        sections = [station(along[i], place, first, last - first, i, mesh.gauss) for i, place in enumerate(places)]
        elements.append([at_place(at, s, loads) for at, s in zip(sections, places, strict=True)])
    return elements


def _elements(p: Parameters, mesh: Discretization, loads: Any) -> Iterator[tuple[list[Parameters], Any, slice]]:
    """Yield each element's stations, length and the place of its coordinates in q, (30) and (31)."""
    sizes = np.diff(element_ends(p, mesh.shares))
    for e, (points, h) in enumerate(zip(stations(p, mesh, loads), sizes, strict=True)):
        first = 3 * e * mesh.order
        yield points, h, slice(first, first + 3 * (mesh.order + 1))


def _weights(mesh: Discretization) -> Any:
    return np.polynomial.legendre.leggauss(mesh.gauss)[1] / 2.0


def rest_coordinates(p: Parameters, mesh: Discretization) -> Any:
    """Coordinates of the straight beam in its clamp, (3 n_nodes,)."""
    tilt = p["effects.clamp_tilt"]
    q = np.empty(3 * mesh.nodes.size, dtype=np.result_type(*p.values(), float))
    ends = np.array(element_ends(p, mesh.shares))
    s = np.concatenate([[0.0], (ends[:-1, None] + np.diff(ends)[:, None] * mesh.local_nodes[None, 1:]).ravel()])
    q[0::3], q[1::3], q[2::3] = s * np.cos(tilt), -s * np.sin(tilt), tilt
    return q


def _springs(p: Parameters, q: Any) -> list[tuple[int, Any, Any]]:
    """The clamp's coordinates that give way: each one's place in q, how far it has gone, and its stiffness, [A2]."""
    names, rest = ("axial", "lateral", "rotation"), (0.0, 0.0, p["effects.clamp_tilt"])
    compliance = [p[f"effects.clamp_{name}_compliance"] for name in names]
    return [(i, q[i] - rest[i], 1.0 / soft) for i, soft in enumerate(compliance) if soft != 0.0]


def energy(p: Parameters, mesh: Discretization, loads: Any, q: Any) -> Any:
    """Energy of the whole system [N m]: equilibria are where it is stationary, stable where it is least."""
    total = tip_energy(p, loads, q[-3:])
    for points, h, place in _elements(p, mesh, loads):
        if mesh.family == "se2":
            total = total + se2_energy(points, _weights(mesh), h, q[place], loads[5])
        elif mesh.family == "strain":
            total = total + strain_energy(points, mesh.order, h, q[place], loads[5])
        else:
            total = total + element_energy(points, mesh.basis, _weights(mesh), h, q[place], loads[5])
    for _, moved, stiffness in _springs(p, q):
        total = total + stiffness * moved**2 / 2.0
    return total


def gradient(p: Parameters, mesh: Discretization, loads: Any, q: Any) -> Any:
    """Gradient of the energy by the complex step, (3 n_nodes,): the residual of elements of any family."""
    return np.array([energy(p, mesh, loads, q + 1e-30j * unit).imag * 1e30 for unit in np.eye(q.size)])


def residual(p: Parameters, mesh: Discretization, loads: Any, q: Any) -> Any:
    """[A0] Gradient of the energy of Lagrange elements, (3 n_nodes,): minus the bracket of (41).

    The clamped node's rows are reactions, but where the clamp gives way.
    """
    total = np.zeros(q.size, dtype=np.result_type(q, *p.values(), float))
    for points, h, place in _elements(p, mesh, loads):
        total[place] += element_force(points, mesh.basis, _weights(mesh), h, q[place], loads[5])
    total[-3:] -= tip_wrench(p, loads, q[-3:])
    for i, moved, stiffness in _springs(p, q):
        total[i] += stiffness * moved
    return total


def tangent(p: Parameters, mesh: Discretization, loads: Any, q: Any) -> Any:
    """Derivative of the residual by q, (3 n_nodes, 3 n_nodes), symmetric."""
    K = np.zeros((q.size, q.size))
    for points, h, place in _elements(p, mesh, loads):
        K[place, place] += element_tangent(points, mesh.basis, _weights(mesh), h, q[place])
    K[-3:, -3:] += tip_stiffness(p, loads, q[-3:])
    for i, _, stiffness in _springs(p, q):
        K[i, i] += stiffness
    return K


def newton_step(p: Parameters, mesh: Discretization, loads: Any, q: Any) -> Any:
    """[A1] Newton's step for (41), (3 n_nodes,), with the clamped node held but where the clamp gives way."""
    step = np.zeros(q.size)
    free = np.array([*(i for i, _, _ in _springs(p, q)), *range(3, q.size)])
    step[free] = -np.linalg.solve(tangent(p, mesh, loads, q)[np.ix_(free, free)], residual(p, mesh, loads, q)[free])
    return step


def solve(p: Parameters, mesh: Discretization, loads: Any, load_steps: int = 1) -> tuple[Any, int]:
    """Equilibrium by Newton's method from the unloaded state; returns q and how many steps were taken.

    Plain on purpose: no globalization, no verdict on stability.
    """
    q, taken = rest_coordinates(p, mesh), 0
    for factor in np.linspace(0.0, 1.0, load_steps + 1)[1:]:
        for _ in range(50):
            step = newton_step(p, mesh, factor * np.asarray(loads), q)
            q, taken = q + step, taken + 1
            if np.abs(step).max() < 1e-9:
                break
    return q, taken
