"""The physics of the test bed, each law once; every effect it can build in is written here and nowhere else.

To build in another effect, name it in `BUILT_IN` and change the one function it belongs to: `stiffness` (a profile
along the beam), `section` (a law of the cross-section), `clamp` (how the foot gives way), `acting` (tendon forces
that depend on what came before), `tip_wrench` (what pulls at the head) or `camera` (what the camera makes of a pose).
No law needs a derivative: `section`, `clamp` and `tip_wrench` take complex arguments, and the complex step
differentiates them to rounding.

`p` is a mapping from a parameter's key to its value, see `named`; the last axis of every array is that of the rows.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from ..data import Measurements
from ..effects import CATALOGUE
from ..errors import InputError
from ..mechanism import EFFECT_QUANTITIES, SECTIONS, Mechanism

__all__ = [
    "BUILT_IN",
    "Parameters",
    "Rows",
    "acting",
    "beam_weight",
    "camera",
    "clamp",
    "jumps",
    "named",
    "section",
    "stiffness",
    "tip_wrench",
]

Array = Any  # NumPy arrays, real or complex
Parameters = Mapping[str, Any]

BUILT_IN = frozenset(
    {
        "precurvature",
        "neutral_axis_offset",
        "stiffness_taper",
        "soft_spot",
        "clamp_tilt",
        "pulley_height",
        "pulley_height_asymmetry",
        "pulley_spacing",
        "pulley_shift",
        "gravity_tilt",
        "head_mass",
    }
)
"""The effects of the catalogue that the laws below hold."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Loads, one entry a row.

    Attributes
    ----------
    lam : (2, n) forces that the tendons exert on the head, left and right [N]
    wrench : (3, n) dead wrench at Q: fx, fz [N], tau [N m]
    extra_mass : (n,) mass added at the head's center of mass [kg]
    tilt : (n,) by how much gravity is turned [rad]
    share : (n,) share of weight that acts, below 1 while the load grows [-]
    """

    lam: Array
    wrench: Array
    extra_mass: Array
    tilt: Array
    share: Array

    def grown_to(self, factor: Array) -> "Rows":
        """Return the rows with a share of all their loads, `factor` (n,)."""
        return replace(self, lam=self.lam * factor, wrench=self.wrench * factor, share=self.share * factor)

    def select(self, which: Array) -> "Rows":
        """Return some of the rows."""
        return Rows(**{entry.name: getattr(self, entry.name)[..., which] for entry in fields(self)})


def named(mechanism: Mechanism) -> dict[str, Any]:
    """Return every number of a mechanism by its key, effects that are absent included.

    Raises
    ------
    InputError : the mechanism has an effect that no law here holds; the measurements would lack it silently.
    """
    for effect in CATALOGUE.values():
        present = [entry for entry in effect if entry.name in mechanism.effects]
        if present and effect.name not in BUILT_IN:
            key, value = present[0].key, mechanism.effects[present[0].name]
            raise InputError(f"{key} = {value:g}: the test bed has no law for it; allowed are "
                             f"{', '.join(sorted(BUILT_IN))}")  # fmt: skip
    values = {entry.key: mechanism.effects.get(name, entry.default) for name, entry in EFFECT_QUANTITIES.items()}
    for name, part in SECTIONS.items():
        values |= {f"{name}.{item.name}": getattr(getattr(mechanism, name), item.name) for item in fields(part)}
    return values


def stiffness(p: Parameters, s: float) -> tuple[Any, Any, Any]:
    """EA [N], GA [N] and EI [N m^2] at the undeformed arclength `s` [m] from the clamp."""
    L, middle = p["beam.length"], p["effects.soft_spot.place"]
    soft = p["effects.soft_spot.size"] if abs(s - middle * L) < p["effects.soft_spot.width"] / 2.0 else 0.0
    share = (1.0 + p["effects.stiffness_taper"] * (2.0 * s / L - 1.0)) * (1.0 - soft)
    return p["beam.EA"] * share, p["beam.GA"] * share, p["beam.EI"] * share


def jumps(p: Parameters) -> list[float]:
    """Arclengths between clamp and tip at which `stiffness` jumps [m], in order."""
    L, half = p["beam.length"], p["effects.soft_spot.width"] / 2.0
    if p["effects.soft_spot.size"] == 0.0 or half == 0.0:
        return []
    middle = p["effects.soft_spot.place"] * L
    return [s for s in (middle - half, middle + half) if 0.0 < s < L]


def section(p: Parameters, s: float, strains: Array) -> Array:
    """Contact force N, Q [N] and couple M [N m], (3, ...), of the strains gamma_x, gamma_z, kappa, (3, ...).

    Of the energy W(gamma_x + e kappa) + GA gamma_z^2/2 + EI (kappa - kappa_0)^2/2, with e the neutral axis offset.
    Source of the laws for e = kappa_0 = 0: the paper, (19).
    """
    EA, GA, EI = stiffness(p, s)
    gamma_x, gamma_z, kappa = strains
    e = p["effects.neutral_axis_offset"]
    stretch = gamma_x + e * kappa
    N = EA * (stretch - 1.0) if p["beam.axial_law"] == "hooke" else EA / 3.0 * (stretch - 1.0 / (stretch * stretch))
    return np.stack([N, GA * gamma_z, EI * (kappa - p["effects.precurvature"]) + e * N])


def clamp(p: Parameters, force: Array, couple: Array) -> Array:
    """Pose of the beam's foot, (3, ...), under the force (2, ...) and couple (...) that the beam exerts there.

    Today the foot does not give way.
    """
    return np.stack([0.0 * couple, 0.0 * couple, p["effects.clamp_tilt"] + 0.0 * couple])


def _gravity(p: Parameters, rows: Rows) -> Array:
    """Acceleration of gravity, (2, n) [m/s^2], while it grows."""
    angle = rows.tilt + p["effects.gravity_tilt"]
    return -p["gravity.g"] * rows.share * np.stack([np.cos(angle), np.sin(angle)])


def beam_weight(p: Parameters, rows: Rows) -> Array:
    """Weight per undeformed length, (2, n) [N/m]."""
    return p["beam.mass_per_length"] * _gravity(p, rows)


def acting(p: Parameters, loads: Measurements) -> Array:
    """Forces that the tendons exert on the head, (n, 2) [N]; the rows of `loads` are in the order of loading.

    Today nothing of the force at the motors is lost on the way.
    """
    return loads.lam


def tip_wrench(p: Parameters, rows: Rows, pose: Array) -> Array:
    """Wrench at Q, (3, n): f_x, f_z [N] and tau [N m] of the dead wrench, the tendons and the head's weight."""
    mass = p["head.mass"] + p["effects.head_mass"] + rows.extra_mass
    wrench = rows.wrench + _force_at(pose, p["head.h"], p["head.b"], mass * _gravity(p, rows))
    for lam, side in zip(rows.lam, (1.0, -1.0), strict=True):
        attached = side * p["tendons.plate_half_width"]
        pull = np.where(lam == 0.0, 0.0, lam * _direction(p, side, _lever(pose, 0.0, attached) + pose[:2]))
        wrench = wrench + _force_at(pose, 0.0, attached, pull)
    return wrench


def _lever(pose: Array, along: float, across: float) -> Array:
    """Vector from Q to a point of the head, (2, n)."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.stack([along * c + across * s, across * c - along * s])


def _force_at(pose: Array, along: float, across: float, force: Array) -> Array:
    """Wrench at Q of a force at a point of the head, (3, n)."""
    r = _lever(pose, along, across)
    return np.stack([force[0], force[1], r[1] * force[0] - r[0] * force[1]])


def _direction(p: Parameters, side: float, attachment: Array) -> Array:
    """Unit vector, (2, n), from a tendon's attachment to where it meets its pulley; `side` 1 left, -1 right.

    The line of sight to the pulley's center, turned outwards by the angle under which the radius is seen.
    """
    x = p["tendons.pulley_x"] + p["effects.pulley_height"] + side * p["effects.pulley_height_asymmetry"] / 2.0
    z = side * (p["tendons.pulley_z"] + p["effects.pulley_spacing"]) + p["effects.pulley_shift"]
    v_x, v_z = x - attachment[0], z - attachment[1]
    distance = np.sqrt(v_x * v_x + v_z * v_z)
    sine = side * p["tendons.pulley_radius"] / distance
    cosine = np.sqrt(1.0 - sine * sine)
    return np.stack([cosine * v_x + sine * v_z, cosine * v_z - sine * v_x]) / distance


def camera(p: Parameters, pose: Array, loads: Measurements) -> Array:
    """Poses (n, 3) as a camera without noise sees them; the rows are in the order of measurement.

    Today it sees them as they are.
    """
    return pose
