"""Effects of the camera and its marker.

All act on (x, z) as seen from the clamp. In this order: the marker's levers, distortions of the picture (lens,
keystone, scales), then rotation and offsets.
"""

from functools import partial

from .effect import effect

__all__ = ["EFFECTS"]

effect = partial(effect, enters="camera")
# fmt: off
EFFECTS = (
    effect("marker_lever_x", "reads Q + a e_x^H: (x + a cos theta, z - a sin theta)", "m",
           "the marker sits above Q",
           typical=3e-3, bounds=(-10.0, 10.0), group="x scale", mirror="even"),
    effect("marker_lever_z", "reads Q + a e_z^H: (x + a sin theta, z + a cos theta)", "m",
           "the marker sits beside Q",
           typical=3e-3, bounds=(-10.0, 10.0), group="z offset", mirror="odd"),
    effect("lens_distortion", "(x, z) times 1 + a (x^2 + z^2)", "1/m^2", "the picture is stretched towards its rim",
           typical=1.0, bounds=(-1e3, 1e3), group="x scale", mirror="even"),
    effect("camera_keystone", "(x, z) times 1 + a z", "1/m", "the camera looks at the plane of motion askew",
           typical=0.1, bounds=(-1e2, 1e2), group="keystone", mirror="odd"),
    effect("camera_scale", "(x, z) times 1 + a", "-", "the camera's scale is wrong",
           typical=0.005, bounds=(-0.9, 10.0), group="x scale", mirror="even"),
    effect("camera_anisotropy", "x (1 + a/2), z (1 - a/2)", "-", "the camera's scales along x and z differ",
           typical=0.005, bounds=(-0.9, 1.9), group="x scale", mirror="even"),
    effect("camera_rotation", "(x cos a + z sin a, z cos a - x sin a), theta + a", "rad",
           "the camera's axes are turned against the clamp",
           typical=0.005, bounds=(-7.0, 7.0), group="moment bias", mirror="odd"),
    effect("camera_x_offset", "x + a", "m", "the camera's origin is off along the neck",
           typical=5e-4, bounds=(-10.0, 10.0), group="x scale", mirror="even"),
    effect("camera_z_offset", "z + a", "m", "the camera's origin is off sideways",
           typical=5e-4, bounds=(-10.0, 10.0), group="z offset", mirror="odd"),
    effect("marker_angle_offset", "theta + a", "rad", "the marker is glued on turned",
           typical=5e-3, bounds=(-7.0, 7.0), group="moment bias", mirror="odd"),
)
