"""The wrench on the head plate: two tendons over pulleys, the head's weight, a dead wrench at Q."""

from typing import Any

import numpy as np

from .parameters import Parameters, gravity

__all__ = ["head_pose", "tendon", "tendon_forces", "tip_energy", "tip_stiffness", "tip_wrench"]

SIDES = (-1.0, 1.0)
"""Left and right, in the order of the tendon forces."""


def _lever(in_head: tuple[Any, Any], theta: Any) -> Any:
    """Vector from Q in world axes, (2,), of a point given along e_x^H and e_z^H, (1) and (2)."""
    c, s = np.cos(theta), np.sin(theta)
    return np.array([in_head[0] * c + in_head[1] * s, in_head[1] * c - in_head[0] * s])


def _turned(r: Any) -> Any:
    """Derivative of a lever by theta: e_y x r."""
    return np.array([r[1], -r[0]])


def _attached(p: Parameters, side: float) -> Any:
    """Attachment of a tendon, along e_x^H and e_z^H, (2,)."""
    half = p["tendons.plate_half_width"] + p["effects.lever_arm"] - side / 2.0 * p["effects.lever_arm_asymmetry"]
    return _lever((p["effects.attachment_height"], -side * half), p["effects.plate_misalignment"])


def _pulley(p: Parameters, side: float) -> Any:
    """Center of a pulley: the left one at +pulley_z, the right one at -pulley_z."""
    x = p["tendons.pulley_x"] + p["effects.pulley_height"] - side / 2.0 * p["effects.pulley_height_asymmetry"]
    z = -side * (p["tendons.pulley_z"] + p["effects.pulley_spacing"]) + p["effects.pulley_shift"]
    return np.array([x, z])


def tendon_forces(p: Parameters, loads: Any) -> Any:
    """[T4] Tendon forces from the readings r of the force cells, (2,) [N].

        lam = r (1 + gain -+ asymmetry/2) + zero -+ zero_asymmetry/2 + nonlinearity r^2/(160 N) + crosstalk r_other

    with the upper sign on the right; the zeros grow with the share of gravity, as all loads do.
    """
    reading, sides = np.asarray(loads[:2]), -np.array(SIDES)
    gain = 1.0 + p["effects.force_gain"] + sides / 2.0 * p["effects.force_gain_asymmetry"]
    zero = p["effects.force_zero"] + sides / 2.0 * p["effects.force_zero_asymmetry"]
    curved = p["effects.force_nonlinearity"] / 160.0
    return gain * reading + curved * reading**2 + p["effects.force_crosstalk"] * reading[::-1] + loads[5] * zero


def tendon(p: Parameters, side: float, pose: Any) -> tuple[Any, Any, Any, Any]:
    """[T1] One tendon at a tip pose: lever, direction of its pull, free length, length that its tension shortens.

        v = c - P,   l = sqrt(v.v - rho^2),   e = (l v + side rho v_perp) / v.v,   v_perp = (-v_z, v_x)

    P is the attachment, c the pulley's center, rho its radius: e points from P to the point where the tendon meets
    the pulley on its outer side. With a pulley above its attachment on the straight beam the tendon runs up, and `side`
    changes its sign. The length is l plus what is wrapped, up to a constant; its gradient by P is -e,
    which is why the tension stays conservative. Source: the paper, the definition of e_l, e_r before (26).
    """
    rho = p["tendons.pulley_radius"] + p["effects.pulley_radius"]
    if np.real(_pulley(p, side)[0] - p["beam.length"] - p["effects.beam_length"] - _attached(p, side)[0]) > 0.0:
        rho = -rho
    r = _lever(_attached(p, side), pose[2])
    v = _pulley(p, side) - pose[:2] - r
    square = v @ v
    free = np.sqrt(square - rho * rho)
    e = (free * v + side * rho * np.array([-v[1], v[0]])) / square
    return r, e, free, free + side * rho * np.arctan(e[1] / e[0])


def _head(p: Parameters, theta: Any) -> tuple[Any, Any]:
    """Lever of the head's center of mass, (3), and the head's weight [N]."""
    com = p["head.h"] + p["effects.head_com_height"], p["head.b"] + p["effects.head_com_sideways"]
    return _lever(com, theta), (p["head.mass"] + p["effects.head_mass"]) * gravity(p)


def _beyond(p: Parameters, theta: Any) -> list[tuple[Any, Any]]:
    """Depth of the head in the stops that it touches [rad], and their stiffness [N m/rad]."""
    both, one = p["effects.contact_stop.angle"], p["effects.contact_stop_one_sided.angle"]
    touched = []
    if abs(np.real(theta)) > np.real(both):
        touched.append((theta - np.sign(np.real(theta)) * both, p["effects.contact_stop.stiffness"]))
    if np.real(theta) > np.real(one):
        touched.append((theta - one, p["effects.contact_stop_one_sided.stiffness"]))
    return touched


def _head_energy(p: Parameters, loads: Any, pose: Any) -> Any:
    """Potential of all that acts on the head at its pose [N m]."""
    s, weight = _head(p, pose[2])
    total = -(loads[2] * pose[0] + (loads[3] + loads[5] * p["effects.side_force"]) * pose[1] + loads[4] * pose[2])
    total = total - loads[5] * (weight @ (pose[:2] + s))
    springs = p["effects.lateral_spring"], p["effects.rotational_spring"]
    total = total + springs[0] * pose[1] ** 2 / 2.0 + springs[1] * pose[2] ** 2 / 2.0
    for depth, stiffness in _beyond(p, pose[2]):
        total = total + stiffness * depth**2 / 2.0
    for lam, side in zip(tendon_forces(p, loads), SIDES, strict=True):
        total = total + lam * tendon(p, side, pose)[3]
    return total


def _head_wrench(p: Parameters, loads: Any, pose: Any) -> Any:
    """Wrench on the head at Q, (3,): minus the gradient of `_head_energy`."""
    s, weight = _head(p, pose[2])
    forces = [(s, loads[5] * weight)]
    for lam, side in zip(tendon_forces(p, loads), SIDES, strict=True):
        r, e, _, _ = tendon(p, side, pose)
        forces.append((r, lam * e))
    wrench = np.array(loads[2:5], dtype=np.result_type(*p.values(), *pose, float))
    for r, f in forces:
        wrench += np.array([f[0], f[1], f @ _turned(r)])
    wrench[1] += loads[5] * p["effects.side_force"] - p["effects.lateral_spring"] * pose[1]
    wrench[2] -= p["effects.rotational_spring"] * pose[2]
    for depth, stiffness in _beyond(p, pose[2]):
        wrench[2] -= stiffness * depth
    return wrench


def _head_stiffness(p: Parameters, loads: Any, pose: Any) -> Any:
    """Minus the derivative of `_head_wrench` by the pose, (3, 3), symmetric.

    A tendon turns about its tangent point, which gives lam/l n n^T across its line; every force on a lever adds
    f.r to the theta entry.
    """
    s, weight = _head(p, pose[2])
    K = np.zeros((3, 3))
    K[1, 1], K[2, 2] = p["effects.lateral_spring"], loads[5] * (weight @ s) + p["effects.rotational_spring"]
    K[2, 2] += sum(stiffness for _, stiffness in _beyond(p, pose[2]))
    for lam, side in zip(tendon_forces(p, loads), SIDES, strict=True):
        r, e, free, _ = tendon(p, side, pose)
        across = np.array([-e[1], e[0]])
        J = np.append(across, across @ _turned(r))
        K += lam / free * np.outer(J, J)
        K[2, 2] += lam * (e @ r)
    return K


def head_pose(p: Parameters, loads: Any, pose: Any) -> Any:
    """[T5] Pose of the head on the tip section at `pose`, (3,): its joint gives way until both couples are equal.

    theta_head - theta = c tau(theta_head)
    """
    joint, head = p["effects.plate_joint_compliance"], np.array(pose, dtype=np.result_type(*p.values(), *pose, float))
    real = {key: np.real(value) for key, value in p.items()}
    for _ in range(20 if joint != 0.0 else 0):
        gap = head[2] - pose[2] - joint * _head_wrench(p, loads, head)[2]
        stiffness = _head_stiffness(real, np.real(loads), head.real)[2, 2]
        head[2] -= gap / (1.0 + np.real(joint) * stiffness)
    return head


def tip_energy(p: Parameters, loads: Any, pose: Any) -> Any:
    """Potential of all that acts on the tip section, the joint's energy included [N m].

    loads : readings of the force cells, left and right [N], f_x, f_z [N], tau [N m], share of gravity
    """
    joint = p["effects.plate_joint_compliance"]
    if joint == 0.0:
        return _head_energy(p, loads, pose)
    head = head_pose(p, loads, pose)
    return _head_energy(p, loads, head) + (head[2] - pose[2]) ** 2 / (2.0 * joint)


def tip_wrench(p: Parameters, loads: Any, pose: Any) -> Any:
    """[T2] Wrench on the tip section at Q, (3,): f_x, f_z [N], tau [N m]; minus the gradient of `tip_energy`.

        (f, r_z f_x - r_x f_z) of every force f with lever r, plus the dead wrench, springs and stops

    Sources: the paper, (26) dead wrench, (38) head's weight, (39) and (40) tendons.
    """
    return _head_wrench(p, loads, head_pose(p, loads, pose))


def tip_stiffness(p: Parameters, loads: Any, pose: Any) -> Any:
    """[T3] Minus the derivative of `tip_wrench` by the pose, (3, 3), symmetric: the joint in series with the head."""
    K = _head_stiffness(p, loads, head_pose(p, loads, pose))
    joint, turn = p["effects.plate_joint_compliance"], K[2].copy()
    return K - np.outer(turn, turn) * joint / (1.0 + joint * K[2, 2])
