"""Effects of the beam and its cross-section: they enter the section's energy."""

from ._entry import effect

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
)
