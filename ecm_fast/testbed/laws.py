"""The physics of the test bed outside the beam: its parameters, tendons, ends, weights, surroundings.

Every effect is written in one place: laws of the cross-section in `section`, the camera's in `camera`, those of what
came before in `history`, what no catalogue knows in `outside`, all others here. No law needs a derivative: they take
complex arguments, and the complex step differentiates them to rounding.

`p` is a mapping from a parameter's key to its value, see `named`: a number, or an array with one entry a row where the
rows differ. The last axis of every array is that of the rows.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from ..errors import InputError
from ..mechanism.catalogue import camera, ends, environment, forces, geometry, path, section
from ..mechanism.mechanism import Mechanism
from ..mechanism.sections import EFFECT_QUANTITIES, SECTIONS
from . import outside
from .variants import COUPLE, ONSET, SLACK, blend

__all__ = [
    "BUILT_IN",
    "Loads",
    "Parameters",
    "beam_weight",
    "chosen",
    "clamp",
    "length",
    "named",
    "plate",
    "tendon_lengths",
    "tip_wrench",
]

Array = Any  # NumPy arrays, real or complex
Parameters = Mapping[str, Any]

BUILT_IN = frozenset(
    effect.name for family in (section, ends, geometry, forces, environment, camera, path) for effect in family.EFFECTS
)
"""The effects that the laws hold: those the package ships with, not those that a user adds at run time."""

_SIDES = (1.0, -1.0)  # left, right


@dataclass(frozen=True, eq=False)
class Loads:
    """Loads, one entry a row.

    Attributes
    ----------
    lam : (2, n) forces that the tendons exert on the head, left and right [N]
    wrench : (3, n) dead wrench at Q: fx, fz [N], tau [N m]
    extra_mass : (n,) mass added at the head's center of mass [kg]
    tilt : (n,) by how much gravity is turned [rad]
    share : (n,) share of weight and side force that acts, below 1 while the load grows [-]
    """

    lam: Array
    wrench: Array
    extra_mass: Array
    tilt: Array
    share: Array

    def grown_to(self, factor: Array) -> "Loads":
        """Return the rows with a share of all their loads, `factor` (n,)."""
        return replace(self, lam=self.lam * factor, wrench=self.wrench * factor, share=self.share * factor)

    def select(self, which: Array) -> "Loads":
        """Return some of the rows."""
        return Loads(**{entry.name: getattr(self, entry.name)[..., which] for entry in fields(self)})


def named(mechanism: Mechanism, hidden: Mapping[str, float] | None = None) -> dict[str, Any]:
    """Return every number of a mechanism by its key, effects that are absent and those of `outside` included.

    Raises
    ------
    InputError : the mechanism has an effect that no law here holds; the measurements would lack it silently. Or it is
        a robot.
    """
    mechanism.check_pair("the test bed")
    for name, value in mechanism.effects.items():
        if name.partition(".")[0] not in BUILT_IN:
            raise InputError(f"effects.{name} = {value:g}: the test bed has no law for it; allowed are "
                             f"{', '.join(sorted(BUILT_IN))}")  # fmt: skip
    values = {entry.key: mechanism.effects.get(name, entry.default) for name, entry in EFFECT_QUANTITIES.items()}
    for name, part in SECTIONS.items():
        values |= {f"{name}.{item.name}": getattr(getattr(mechanism, name), item.name) for item in fields(part)}
    return values | outside.named(hidden or {})


def chosen(p: Parameters, which: Array) -> Parameters:
    """Return the parameters of some of the rows."""
    return {key: value[which] if isinstance(value, np.ndarray) else value for key, value in p.items()}


def length(p: Parameters) -> float:
    """Return the length of the undeformed beam [m]."""
    return float(p["beam.length"] + p["effects.beam_length"])


# --- both ends of the beam


def clamp(p: Parameters, force: Array, couple: Array) -> Array:
    """Pose of the beam's foot, (3, ...), under the force (2, ...) and couple (...) that the beam exerts there."""
    size = np.where(couple.real < 0.0, -couple, couple)
    turning = blend(p, "clamp_stiffens", couple, couple / (1.0 + size / COUPLE))
    gives_way = (
        p["effects.clamp_axial_compliance"] * force[0],
        p["effects.clamp_lateral_compliance"] * force[1],
        p["effects.clamp_rotation_compliance"] * turning,
    )
    return np.stack([gives_way[0], gives_way[1], p["effects.clamp_tilt"] + gives_way[2]])


def plate(p: Parameters, tip: Array) -> Array:
    """Pose of the head plate, (3, ...), from x, z, theta, M of the tip section, (4, ...); Q is in the joint.

    It is linear: what it does to the tip it does to the tip's derivatives.
    """
    return np.stack([tip[0], tip[1], tip[2] + p["effects.plate_joint_compliance"] * tip[3]])


# --- weights


def _gravity(p: Parameters, rows: Loads) -> Array:
    """Acceleration of gravity, (2, n) [m/s^2], while it grows."""
    angle = rows.tilt + p["gravity.tilt"] + p["effects.gravity_tilt"]
    return -p["gravity.g"] * rows.share * np.stack([np.cos(angle), np.sin(angle)])


def beam_weight(p: Parameters, rows: Loads) -> Array:
    """Weight per undeformed length, (2, n) [N/m]."""
    return (p["beam.mass_per_length"] + p["effects.beam_mass"]) * _gravity(p, rows)


# --- what acts at the head


def tip_wrench(p: Parameters, rows: Loads, pose: Array) -> Array:
    """Wrench at Q, (3, ...): f_x, f_z [N] and tau [N m] of all that acts at the head in a pose of the plate."""
    mass = p["head.mass"] + p["effects.head_mass"] + rows.extra_mass
    height, sideways = p["head.h"] + p["effects.head_com_height"], p["head.b"] + p["effects.head_com_sideways"]
    weight = _force_at(pose, height, sideways, _spread(pose, mass * _gravity(p, rows)))
    wrench = _spread(pose, rows.wrench) + weight
    for lam, side in zip(rows.lam, _SIDES, strict=True):
        along, across = _attachment(p, side, lam)
        outwards = np.where(_pulley(p, side)[0] > length(p) + along.real, -side, side)  # above the plate or below
        pull = np.where(lam == 0.0, 0.0, lam * _direction(p, side, outwards, _lever(pose, along, across) + pose[:2]))
        wrench = wrench + _force_at(pose, along, across, pull)
    return wrench + _surroundings(p, rows, pose)


def _spread(pose: Array, vector: Array) -> Array:
    """Return vectors (k, n) with as many axes as the pose has, which is probed in several directions at once."""
    return vector[:, None] if pose.ndim == 3 else vector


def _surroundings(p: Parameters, rows: Loads, pose: Array) -> Array:
    """Wrench at Q, (3, ...), of cables, springs and stops."""
    _, z, theta = pose
    push = p["effects.side_force"] * rows.share
    aside = blend(p, "spring_hardens", z, z * (1.0 + (z / 0.04) ** 2) / 1.5)
    aside = blend(p, "spring_slack", aside, _beyond(z, SLACK) - _beyond(-z, SLACK))
    side = push * blend(p, "follower", 1.0, np.cos(theta)) - p["effects.lateral_spring"] * aside + outside.wall(p, z)
    along = push * blend(p, "follower", 0.0, np.sin(theta))
    turn = -p["effects.rotational_spring"] * blend(p, "spring_hardens", theta, theta * (1.0 + (2.0 * theta) ** 2) / 1.5)
    both, one = "effects.contact_stop", "effects.contact_stop_one_sided"
    stops = _pressed(p, theta, p[f"{both}.angle"]) - _pressed(p, -theta, p[f"{both}.angle"])
    turn = turn - p[f"{both}.stiffness"] * stops - p[f"{one}.stiffness"] * _pressed(p, theta, p[f"{one}.angle"])
    return np.stack([along + 0.0 * side, side, turn])


def _pressed(p: Parameters, angle: Array, stop: float) -> Array:
    """Angle by which the head presses into a stop."""
    beyond = _beyond(angle, stop)
    return blend(p, "soft_onset", beyond, beyond * beyond / (beyond + ONSET))


def _beyond(value: Array, threshold: float) -> Array:
    """Excess of a value over a threshold, 0 where there is none."""
    return np.where(value.real > threshold, value - threshold, 0.0)


def _lever(pose: Array, along: Array, across: Array) -> Array:
    """Vector from Q to a point of the head, (2, ...)."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.stack([along * c + across * s, across * c - along * s])


def _force_at(pose: Array, along: Array, across: Array, force: Array) -> Array:
    """Wrench at Q of a force at a point of the head, (3, ...)."""
    r = _lever(pose, along, across)
    couple = r[1] * force[0] - r[0] * force[1]
    return np.stack([force[0] + 0.0 * couple, force[1] + 0.0 * couple, couple])


# --- tendons


def _attachment(p: Parameters, side: float, lam: Array) -> tuple[Array, Array]:
    """Attachment of a tendon of the force `lam`, along e_x^H and e_z^H from Q [m]; `side` 1 left, -1 right."""
    along = p["effects.attachment_height"] + outside.flexure(p, lam)
    arm = p["tendons.plate_half_width"] + p["effects.lever_arm"] + side * p["effects.lever_arm_asymmetry"] / 2.0
    across = side * arm
    c, s = np.cos(p["effects.plate_misalignment"]), np.sin(p["effects.plate_misalignment"])
    return along * c + across * s, across * c - along * s


def _pulley(p: Parameters, side: float) -> tuple[float, float]:
    """Place of a pulley's center, x and z [m]."""
    x = p["tendons.pulley_x"] + p["effects.pulley_height"] + side * p["effects.pulley_height_asymmetry"] / 2.0
    z = side * (p["tendons.pulley_z"] + p["effects.pulley_spacing"]) + p["effects.pulley_shift"]
    return x, z


def _direction(p: Parameters, side: float, outwards: Array, attachment: Array) -> Array:
    """Unit vector, (2, ...), from a tendon's attachment to where it meets its pulley.

    The line of sight to the pulley's center, turned by the angle under which the radius is seen, from z towards x where
    `outwards` is 1, from x towards z where it is -1.
    """
    x, z = _pulley(p, side)
    v_x, v_z = x - attachment[0], z - attachment[1]
    distance = np.sqrt(v_x * v_x + v_z * v_z)
    sine = outwards * (p["tendons.pulley_radius"] + p["effects.pulley_radius"]) / distance
    cosine = np.sqrt(1.0 - sine * sine)
    return np.stack([cosine * v_x + sine * v_z, cosine * v_z - sine * v_x]) / distance


def tendon_lengths(p: Parameters, pose: Array) -> Array:
    """Distances from the attachments to the centers of the pulleys, left and right, (2, n) [m], in poses (3, n)."""
    lengths = []
    for side in _SIDES:
        x, z = _pulley(p, side)
        v_x, v_z = _lever(pose, *_attachment(p, side, 0.0)) + pose[:2]
        lengths.append(np.hypot(x - v_x, z - v_z))
    return np.stack(lengths)
