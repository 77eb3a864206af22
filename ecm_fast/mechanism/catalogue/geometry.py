"""Effects of geometry: attachments and pulleys that differ from the drawing."""

from functools import partial

from .effect import effect

__all__ = ["EFFECTS"]

effect = partial(effect, enters="geometry")
_PLACE = -10.0, 10.0  # [m] bounds that refuse overflow, and no mechanism
# fmt: off
EFFECTS = (
    effect("lever_arm", "d + a at both tendons", "m", "both tendons are attached farther from the middle than drawn",
           typical=1e-3, bounds=_PLACE, tolerance=2e-5, group="compliance ratio", mirror="even"),
    effect("lever_arm_asymmetry", "d + a/2 at the left tendon, d - a/2 at the right one", "m",
           "the left tendon is attached farther from the middle than the right one",
           typical=1e-3, bounds=_PLACE, tolerance=2e-5, group="left-right leverage", mirror="odd"),
    effect("attachment_height", "attachments at a e_x^H +- d e_z^H", "m",
           "the tendons are attached above the end of the beam",
           typical=3e-3, bounds=_PLACE, group="compression-dependent", mirror="even"),
    effect("plate_misalignment", "both attachments turned by a about Q in the head's frame", "rad",
           "the plate is mounted turned on the neck",
           typical=0.02, bounds=(-7.0, 7.0), group="one-sided bending", mirror="odd"),
    effect("pulley_height", "x of both pulleys + a", "m", "both pulleys sit higher than drawn",
           typical=2e-3, bounds=_PLACE, tolerance=1e-4, group="compliance ratio", mirror="even"),
    effect("pulley_height_asymmetry", "x of the left pulley + a/2, of the right one - a/2", "m",
           "left pulley higher than the right one",
           typical=2e-3, bounds=_PLACE, group="one-sided bending", mirror="odd"),
    effect("pulley_spacing", "z of the left pulley + a, of the right one - a", "m",
           "each pulley is farther from the middle than drawn",
           typical=2e-3, bounds=_PLACE, tolerance=5e-5, group="compliance ratio", mirror="even"),
    effect("pulley_shift", "z of both pulleys + a", "m", "the pair of pulleys is shifted to the left tendon's side",
           typical=2e-3, bounds=_PLACE, tolerance=1e-5, group="left-right leverage", mirror="odd"),
    effect("pulley_radius", "radius of both pulleys + a", "m",
           "the tendons leave larger pulleys, on their outer sides, where the drawing has points",
           typical=5e-3, bounds=(-1.0, 10.0), group="compliance ratio", mirror="even"),
)
