"""Effects of how the test bed is built: clamp and pulleys are not where the drawing has them."""

from ._entry import effect

__all__ = ["EFFECTS"]

EFFECTS = (
    effect(
        "clamp_tilt",
        "theta(0) = a",
        "rad",
        "rotation of the clamped section",
        typical=0.01,
        bound=7.0,
        enters="clamp",
        family="moment bias",
        mirror="odd",
    ),
    effect(
        "pulley_height",
        "x of both pulleys + a",
        "m",
        "both pulleys sit higher than drawn",
        typical=2e-3,
        bound=10.0,
        enters="geometry",
        family="compliance ratio",
        mirror="even",
    ),
    effect(
        "pulley_height_asymmetry",
        "x of the left pulley + a/2, of the right one - a/2",
        "m",
        "left pulley higher than the right one",
        typical=2e-3,
        bound=10.0,
        enters="geometry",
        family="one-sided bending",
        mirror="odd",
    ),
    effect(
        "pulley_spacing",
        "z of the left pulley + a, of the right one - a",
        "m",
        "each pulley is farther from the middle than drawn",
        typical=2e-3,
        bound=10.0,
        enters="geometry",
        family="compliance ratio",
        mirror="even",
    ),
    effect(
        "pulley_shift",
        "z of both pulleys + a",
        "m",
        "the pair of pulleys is shifted to the left tendon's side",
        typical=2e-3,
        bound=10.0,
        enters="geometry",
        family="left-right leverage",
        mirror="odd",
    ),
)
