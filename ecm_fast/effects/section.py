"""Effects of the beam and its cross-section: they enter the section's energy."""

from ..quantity import Quantity
from ._entry import Effect, effect

__all__ = ["EFFECTS"]

EFFECTS = (
    effect(
        "precurvature",
        "M = EI (kappa - a)",
        "1/m",
        "curvature of the beam as it was cast",
        typical=0.2,
        bound=100.0,
        enters="section",
        family="moment bias",
        mirror="odd",
    ),
    effect(
        "neutral_axis_offset",
        "N acts on gamma_x + a kappa, and adds a N to M",
        "m",
        "distance of the neutral axis from the centerline along e_z",
        typical=1e-3,
        bound=0.1,
        enters="section",
        family="left-right leverage",
        mirror="odd",
    ),
    effect(
        "stiffness_taper",
        "EA, GA and EI times 1 + a (2 s/L - 1)",
        "-",
        "the beam is stiffer at its tip than at its clamp",
        typical=0.05,
        bound=0.99,
        enters="section",
        family="compliance ratio",
        mirror="even",
    ),
    Effect(
        "soft_spot",
        (
            Quantity(
                "effects.soft_spot.size",
                "-",
                "share of the stiffness that a stretch of the beam lacks, as at a void",
                0.0,
                -10.0,
                0.99,
                0.2,
                "zero",
            ),
            Quantity(
                "effects.soft_spot.place",
                "-",
                "its middle, as a share of the length from the clamp",
                1.0 / 3.0,
                0.0,
                1.0,
                0.1,
                "assumed",
                "not given",
            ),
            Quantity(
                "effects.soft_spot.width",
                "m",
                "its length along the beam",
                0.015,
                0.0,
                1e3,
                0.005,
                "assumed",
                "not given",
            ),
        ),
        law="EA, GA and EI times 1 - a where |s - place L| < width/2",
        enters="section",
        family="compliance ratio",
        mirror="even",
    ),
)
