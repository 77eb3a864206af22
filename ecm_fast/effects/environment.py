"""Effects of what surrounds the neck: gravity's direction and what hangs on the head."""

from ._entry import effect

__all__ = ["EFFECTS"]

EFFECTS = (
    effect(
        "gravity_tilt",
        "gravity acts along -(cos a, sin a) in (x, z)",
        "rad",
        "the test bed is tilted against gravity",
        typical=0.02,
        bound=7.0,
        enters="environment",
        family="moment bias",
        mirror="odd",
    ),
    effect(
        "head_mass",
        "m_H + a",
        "kg",
        "mass of the head that the drawing does not list",
        typical=0.1,
        bound=1e6,
        enters="environment",
        family="x scale",
        mirror="even",
    ),
)
