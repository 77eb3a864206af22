"""Laws as they occur: an effect of the catalogue whose law is not the catalogue's own.

A laboratory would call them by the same name. Each takes an effect's size and changes its law; the places where it acts
ask `use` or `grown` here. Only the test bed has them.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

__all__ = ["VARIANTS", "Variant", "blend", "used"]

Array = Any
Parameters = Mapping[str, Any]


class Variant(NamedTuple):
    """Another law of some effects.

    Attributes
    ----------
    effects : of the catalogue, whose law it changes
    law : in one line
    """

    effects: tuple[str, ...]
    law: str


VARIANTS: Mapping[str, Variant] = {
    "zeroed_at_rest": Variant(
        ("marker_lever_x", "marker_lever_z", "camera_rotation", "camera_scale", "lens_distortion"),
        "pose less what the camera showed of the unloaded neck: zeroed at rest",
    ),
    "lens_beside": Variant(("lens_distortion",), "the lens looks at x = 60 mm, z = 15 mm, and distorts about it"),
    "turned_about_marker": Variant(("camera_rotation",), "the camera turns about where the marker is at rest"),
    "drift_settles": Variant(
        ("camera_drift_x", "camera_drift_z", "force_zero_drift", "force_zero_drift_asymmetry", "stiffness_drift"),
        "6 min (1 - exp(-t/6 min)) in the place of t",
    ),
    "zero_above_2N": Variant(
        ("force_zero", "force_zero_asymmetry", "force_zero_drift"), "no error of the zero where a cell reads below 2 N"
    ),
    "slack_rubs_not": Variant(("tendon_coulomb_friction",), "friction of at most a fifth of the reading"),
    "stick_zone": Variant(
        ("tendon_coulomb_friction", "tendon_capstan_friction"),
        "direction times 1 - exp(-travel/0.5 mm): it sticks first",
    ),
    "wrap_grows": Variant(("tendon_capstan_friction",), "wrap angle + theta on the left, - theta on the right"),
    "gain_saturates": Variant(("force_gain", "force_gain_asymmetry"), "gain r (1 - r/400 N) in the place of gain r"),
    "bending_levels_off": Variant(
        ("bending_cubic", "bending_amplitude", "bending_one_sided"), "law/(1 + (u/10 per m)^2): it levels off"
    ),
    "shear_levels_off": Variant(("shear_cubic",), "law/(1 + (gamma_z/0.1)^2): it levels off"),
    "cast_below": Variant(("precurvature",), "cast with 1.5 a in the lower half, 0.5 a in the upper"),
    "taper_quadratic": Variant(("stiffness_taper",), "2 (s/L)^2 - 2/3 in the place of 2 s/L - 1"),
    "soft_onset": Variant(("contact_stop", "contact_stop_one_sided"), "e^2/(e + 40 mrad), e the angle beyond the stop"),
    "spring_hardens": Variant(
        ("rotational_spring", "lateral_spring"), "k theta (1 + (theta/0.5)^2)/1.5, k z (1 + (z/40 mm)^2)/1.5"
    ),
    "spring_slack": Variant(("lateral_spring",), "no force until the head is 3 mm aside"),
    "clamp_stiffens": Variant(("clamp_rotation_compliance",), "M/(1 + |M|/4 N m) in the place of M"),
    "follower": Variant(("side_force",), "the force turns with the head"),
    "mullins_saturates": Variant(("mullins_softening",), "1 - exp(-2 peak) in the place of the peak"),
    "two_sliders": Variant(("bending_hysteresis",), "half with half of the angle, half with twice of it"),
    "stretched_memory": Variant(("fading_memory",), "half with a third of the time, half with three times it"),
}
"""Every variant by its name."""

LENS = (0.06, 0.015)
"""Place that the lens looks at [m]."""
SETTLES = 0.1
"""Time in which a drift settles [h]."""
LEVEL = 10.0
"""Curvature at which bending levels off [1/m]."""
SHEAR_LEVEL = 0.1
"""Shear strain at which shear levels off."""
ONSET = 0.04
"""Angle over which a stop comes to bear [rad]."""
STICK = 5e-4
"""Travel in which a tendon begins to slide [m]."""
SLACK = 3e-3
"""Way that a spring leaves free [m]."""
COUPLE = 4.0
"""Couple at which the clamp has half its compliance [N m]."""
NO_FORCE = 2.0
"""Reading below which a cell shows no error of its zero [N]."""


def used(p: Parameters, name: str) -> bool:
    """Tell whether a variant is hidden."""
    return bool(p[f"variant.{name}"] != 0.0)


def blend(p: Parameters, name: str, plain: Array, changed: Array) -> Array:
    """Return a law, or that of a variant where it is hidden; in between where its share is between 0 and 1."""
    share = p[f"variant.{name}"]
    return plain if share == 0.0 else plain + share * (changed - plain)
