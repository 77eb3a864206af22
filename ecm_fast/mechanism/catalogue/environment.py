"""Effects of the surroundings: gravity, the head's mass, springs, stops and forces at the head."""

from functools import partial

from .effect import also, effect

__all__ = ["EFFECTS"]

effect = partial(effect, enters="environment")
_ANGLE = also("angle", "rad", "tip angle at which it touches", 0.4, (0.0, 7.0), 0.05)
# fmt: off
EFFECTS = (
    effect("gravity_tilt", "gravity acts along -(cos a, sin a) in (x, z)", "rad",
           "the test bed is tilted against gravity",
           typical=0.02, bounds=(-7.0, 7.0), group="moment bias", mirror="odd"),
    effect("head_mass", "m_H + a", "kg", "mass of the head that the drawing does not list",
           typical=0.1, bounds=(-1e6, 1e6), tolerance=0.01, group="x scale", mirror="even"),
    effect("head_com_sideways", "b + a", "m", "the head's center of mass lies to the left tendon's side",
           typical=5e-3, bounds=(-10.0, 10.0), group="moment bias", mirror="odd"),
    effect("head_com_height", "h + a", "m", "the head's center of mass lies higher than drawn",
           typical=0.01, bounds=(-10.0, 10.0), tolerance=1e-3, group="bending law", mirror="even"),
    effect("side_force", "f_z + a", "N", "something pulls at the head sideways, as a hanging cable does",
           typical=1.0, bounds=(-1e6, 1e6), group="moment bias", mirror="odd"),
    effect("lateral_spring", "f_z - a z", "N/m", "something holds the head sideways, as a stiff cable does",
           typical=50.0, bounds=(0.0, 1e7), group="compliance ratio", mirror="even"),
    effect("rotational_spring", "tau - a theta", "N m/rad", "something holds the head against turning",
           typical=0.2, bounds=(0.0, 1e5), group="compression-dependent", mirror="even"),
    effect("contact_stop", "tau - a sign(theta) (|theta| - angle) where |theta| > angle", "N m/rad",
           "the head runs into a soft stop on both sides", _ANGLE,
           typical=5.0, bounds=(0.0, 1e5), group="bending law", mirror="even", size="stiffness"),
    effect("contact_stop_one_sided", "tau - a (theta - angle) where theta > angle", "N m/rad",
           "the head runs into a soft stop where theta is positive", _ANGLE,
           typical=5.0, bounds=(0.0, 1e5), group="one-sided bending", mirror="mixed", size="stiffness"),
)
