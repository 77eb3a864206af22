"""Effects of both ends of the beam: compliance and misalignment of the clamp and the head plate's joint.

Rows N0, Q0, M0 are force and couple that the beam exerts on its clamp along x, z and about y.
"""

from .effect import effect

__all__ = ["EFFECTS"]

# fmt: off
EFFECTS = (
    effect("clamp_tilt", "theta(0) = a", "rad", "rotation of the clamped section",
           typical=0.01, bounds=(-7.0, 7.0), enters="clamp", group="moment bias", mirror="odd"),
    effect("clamp_rotation_compliance", "theta(0) + a M0", "rad/(N m)", "the clamp turns under the beam's couple",
           typical=1e-3, bounds=(0.0, 1e3), enters="clamp", group="compliance ratio", mirror="even"),
    effect("clamp_axial_compliance", "x(0) = a N0", "m/N", "the clamp gives way along the neck",
           typical=0.7e-6, bounds=(0.0, 1.0), enters="clamp", group="compression-dependent", mirror="even"),
    effect("clamp_lateral_compliance", "z(0) = a Q0", "m/N", "the clamp gives way sideways",
           typical=4e-6, bounds=(0.0, 1.0), enters="clamp", group="compression-dependent", mirror="even"),
    effect("plate_joint_compliance", "theta of Q and head = theta(L) + a tau, tau the couple on the tip section",
           "rad/(N m)", "the joint between beam and head plate turns under its couple",
           typical=1e-3, bounds=(0.0, 1e3), enters="plate", group="compliance ratio", mirror="even"),
)
