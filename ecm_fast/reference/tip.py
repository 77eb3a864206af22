"""What acts at the head plate: two tendons over pulleys, the head's weight, a dead wrench at Q."""

from typing import Any

import numpy as np

from .parameters import Parameters, gravity

__all__ = ["tendon", "tip_energy", "tip_stiffness", "tip_wrench"]

SIDES = (-1.0, 1.0)
"""Left and right, in the order of the tendon forces."""


def _lever(in_head: tuple[Any, Any], theta: Any) -> Any:
    """Vector from Q in world axes, (2,), of a point given along e_x^H and e_z^H, (1) and (2)."""
    c, s = np.cos(theta), np.sin(theta)
    return np.array([in_head[0] * c + in_head[1] * s, in_head[1] * c - in_head[0] * s])


def _turned(r: Any) -> Any:
    """Derivative of a lever by theta: e_y x r."""
    return np.array([r[1], -r[0]])


def _pulley(p: Parameters, side: float) -> Any:
    """Center of a pulley: the left one at +pulley_z, the right one at -pulley_z."""
    x = p["tendons.pulley_x"] + p["effects.pulley_height"] - side / 2.0 * p["effects.pulley_height_asymmetry"]
    z = -side * (p["tendons.pulley_z"] + p["effects.pulley_spacing"]) + p["effects.pulley_shift"]
    return np.array([x, z])


def tendon(p: Parameters, side: float, pose: Any) -> tuple[Any, Any, Any, Any]:
    """[T1] One tendon at a tip pose: lever, direction of its pull, free length, length that its tension shortens.

        v = c - P,   l = sqrt(v.v - rho^2),   e = (l v + side rho v_perp) / v.v,   v_perp = (-v_z, v_x)

    P is the attachment, c the pulley's center, rho its radius: e points from P to the point where the tendon meets
    the pulley on its outer side. The length is l plus what is wrapped, up to a constant; its gradient by P is -e,
    which is why the tension stays conservative. Source: the paper, the definition of e_l, e_r before (26).
    """
    d, rho = p["tendons.plate_half_width"], p["tendons.pulley_radius"]
    r = _lever((0.0, -side * d), pose[2])
    v = _pulley(p, side) - pose[:2] - r
    square = v @ v
    free = np.sqrt(square - rho * rho)
    e = (free * v + side * rho * np.array([-v[1], v[0]])) / square
    return r, e, free, free + side * rho * np.arctan(e[1] / e[0])


def _head(p: Parameters, theta: Any) -> tuple[Any, Any]:
    """Lever of the head's center of mass, (3), and the head's weight [N]."""
    return _lever((p["head.h"], p["head.b"]), theta), (p["head.mass"] + p["effects.head_mass"]) * gravity(p)


def tip_energy(p: Parameters, loads: Any, pose: Any) -> Any:
    """Potential of tendons, head's weight and dead wrench [N m]; `tip_wrench` is minus its gradient.

    loads : lam_l, lam_r [N], f_x, f_z [N], tau [N m], share of gravity
    """
    s, weight = _head(p, pose[2])
    total = -(loads[2] * pose[0] + loads[3] * pose[1] + loads[4] * pose[2])
    total = total - loads[5] * (weight @ (pose[:2] + s))
    for lam, side in zip(loads[:2], SIDES, strict=True):
        total = total + lam * tendon(p, side, pose)[3]
    return total


def tip_wrench(p: Parameters, loads: Any, pose: Any) -> Any:
    """[T2] Wrench on the tip section at Q, (3,): f_x, f_z [N], tau [N m].

        (f, r_z f_x - r_x f_z) of every force f with lever r, plus the dead wrench

    Sources: the paper, (26) dead wrench, (38) head's weight, (39) and (40) tendons.
    """
    s, weight = _head(p, pose[2])
    forces = [(s, loads[5] * weight)]
    for lam, side in zip(loads[:2], SIDES, strict=True):
        r, e, _, _ = tendon(p, side, pose)
        forces.append((r, lam * e))
    wrench = np.array(loads[2:5], dtype=np.result_type(*p.values(), *pose, float))
    for r, f in forces:
        wrench += np.array([f[0], f[1], f @ _turned(r)])
    return wrench


def tip_stiffness(p: Parameters, loads: Any, pose: Any) -> Any:
    """[T3] Minus the derivative of `tip_wrench` by the pose, (3, 3), symmetric.

    A tendon turns about its tangent point, which gives lam/l n n^T across its line; every force on a lever adds
    f.r to the theta entry.
    """
    s, weight = _head(p, pose[2])
    K = np.zeros((3, 3))
    K[2, 2] = loads[5] * (weight @ s)
    for lam, side in zip(loads[:2], SIDES, strict=True):
        r, e, free, _ = tendon(p, side, pose)
        across = np.array([-e[1], e[0]])
        J = np.append(across, across @ _turned(r))
        K += lam / free * np.outer(J, J)
        K[2, 2] += lam * (e @ r)
    return K
