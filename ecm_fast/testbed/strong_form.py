"""The beam's differential equations, with their derivatives by the unknowns, for all rows at once.

    n' = -w,   M' = x' n_z - z' n_x,   x' e_x + z' e_z = gamma_x e_x^C + gamma_z e_z^C,   theta' = kappa

The weight w is dead, so the contact force is known everywhere once it is known at the tip; the strains follow from
contact force and couple through the laws of the section. The unknowns are n_x, n_z at the tip and M at the clamp.
Where the stiffness jumps, the integration ends and begins anew: state and derivatives are continuous there.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .laws import Loads, Parameters, beam_weight, clamp, length
from .section import jumps, section

__all__ = ["differentiated", "integrate"]

Array = NDArray[Any]

_TOLERANCE = 3e-12  # of the integrator, relative and in units of the beam's own size
_TANGENT = 1e-7  # that of the derivatives: they steer Newton's method and do not enter the pose
_MOST_TURNS = 1e2  # [rad]; an iterate that curls up more is stopped, lest all rows wait for it
_SECTION_STEPS = 40  # Newton steps at most for the strains of a section
_INSIDE = 1e-12  # share of the length; a piece of the beam never asks for the stiffness beyond its own ends
_STEP = 1e-30  # complex step: the error is its square
_PROBES = 1j * _STEP * np.eye(3)[:, :, None]  # complex steps along the three strains


def integrate(p: Parameters, rows: Loads, unknown: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Integrate from clamp to tip.

    Returns x, z, theta, M and, along the second axis, their derivatives by the unknowns at every step of the
    integrator, (4, 4, n, steps), and which rows (n,) the laws could follow.
    """
    from scipy.integrate import solve_ivp

    L, EI = length(p), float(np.mean(p["beam.EI"]))
    n = unknown.shape[1]
    weight = beam_weight(p, rows)
    beam = _Beam(p, unknown[:2], weight, L)
    reaction = np.concatenate([unknown[:2] + L * weight, unknown[2:]])
    foot, by_unknown = differentiated(lambda wrench: clamp(p, wrench[:2], wrench[2]), reaction)
    start = np.zeros((4, 4, n))
    start[:3, 0], start[3, 0] = foot, unknown[2]
    start[:3, 1:], start[3, 3] = by_unknown, 1.0
    size, unit = np.array([L, L, 1.0, EI / L]), np.array([1.0, EI / L**2, EI / L**2, EI / L])
    relative = np.repeat(np.tile([_TOLERANCE, _TANGENT, _TANGENT, _TANGENT], 4), n)
    absolute = relative * np.repeat(size[:, None] / unit, n)
    ends, states = [0.0, *jumps(p), L], [start.reshape(-1, 1)]
    for piece in pairwise(ends):
        beam.piece = piece[0] + _INSIDE * L, piece[1] - _INSIDE * L
        path = solve_ivp(beam.slope, piece, states[-1][:, -1], method="DOP853", rtol=relative, atol=absolute)
        if not path.success:
            beam.sound[:] = False
        states.append(path.y[:, 1:] if path.y.shape[1] > 1 else path.y)
    return np.concatenate(states, axis=1).reshape(4, 4, n, -1), beam.sound


class _Beam:
    """The right-hand side; it keeps the strains last found, from which the next are a few Newton steps away."""

    def __init__(self, p: Parameters, tip_force: Array, weight: Array, length: float) -> None:
        self.p, self.tip_force, self.weight, self.length = p, tip_force, weight, length
        n = tip_force.shape[1]
        self.rest = _strains(p, 0.0, np.zeros((3, n)), np.tile([[1.0], [0.0], [0.0]], n))[0]
        self.strains = self.rest.copy()
        self.sound = np.ones(n, dtype=np.bool_)
        self.piece = 0.0, length

    def slope(self, s: float, flat: Array) -> Array:
        """Derivative by arclength of the state and of its derivatives by the unknowns."""
        y = flat.reshape(4, 4, -1)
        theta, M = y[2, 0], y[3, 0]
        n_x, n_z = self.tip_force + self.weight * (self.length - s)
        c, sn = np.cos(theta), np.sin(theta)
        N, Q = c * n_x - sn * n_z, sn * n_x + c * n_z
        inside = min(max(s, self.piece[0]), self.piece[1])
        self.strains, flexibility = _strains(self.p, inside, np.stack([N, Q, M]), self.strains)
        gamma_x, gamma_z, kappa = self.strains
        out = np.empty_like(y)
        x, z = c * gamma_x + sn * gamma_z, c * gamma_z - sn * gamma_x
        out[:, 0] = x, z, kappa, x * n_z - z * n_x
        turn = y[2, 1:]
        by = np.stack([-Q * turn, N * turn, y[3, 1:]])
        by[0, 0] += c
        by[0, 1] -= sn
        by[1, 0] += sn
        by[1, 1] += c
        d_x, d_z, out[2, 1:] = (flexibility[:, :, None] * by).sum(axis=1)
        out[0, 1:] = c * d_x + sn * d_z + z * turn
        out[1, 1:] = c * d_z - sn * d_x - x * turn
        out[3, 1:] = out[0, 1:] * n_z - out[1, 1:] * n_x
        out[3, 1] -= z
        out[3, 2] += x
        self.sound &= np.isfinite(out).all(axis=(0, 1)) & (np.abs(theta) < _MOST_TURNS)
        lost = ~self.sound
        if lost.any():  # what cannot be followed stands still from then on, so that the other rows can be
            out[:, :, lost] = 0.0
            self.strains[:, lost] = self.rest[:, lost]
        return out.ravel()


def _strains(p: Parameters, s: float, contact: Array, strains: Array) -> tuple[Array, Array]:
    """Strains (3, n) of a contact force and couple (3, n), and their derivatives by it, (3, 3, n).

    Newton's method on `section`, which is monotone; a step may at most halve the stretch, so that it stays positive.
    """
    unit = np.array([[1.0], [1.0], [1.0 / length(p)]])
    for _ in range(_SECTION_STEPS):
        value, stiffness = differentiated(lambda at: section(p, s, at), strains)
        flexibility = _inverse(stiffness)
        step = (flexibility * (contact - value)).sum(axis=1)
        short = strains[0] + step[0] < 0.5 * strains[0]
        if short.any():
            step = np.where(short, step * (-0.5 * strains[0] / np.where(short, step[0], 1.0)), step)
        strains = strains + step
        far = np.abs(step / unit).max(axis=0) > 1e-8  # the next step is the square of this one
        if not far.any():
            return strains, flexibility
    return np.where(far, np.nan, strains), flexibility


def differentiated(law: Callable[[Array], Array], at: Array) -> tuple[Array, Array]:
    """Value (3, n) of a law at (3, n) and its derivatives (3, 3, n), the last but one axis that of the direction."""
    found = law(at[:, None] + _PROBES)
    return found[:, 0].real, found.imag / _STEP


def _inverse(a: Array) -> Array:
    """Inverse of matrices (3, 3, n): cross products of their rows over the determinant."""
    out = np.empty_like(a)
    for j in range(3):
        u, v = a[(j + 1) % 3], a[(j + 2) % 3]
        for i in range(3):
            k, m = (i + 1) % 3, (i + 2) % 3
            out[i, j] = u[k] * v[m] - u[m] * v[k]
    determinant = (a[0] * out[:, 0]).sum(axis=0)
    out /= determinant
    return out
