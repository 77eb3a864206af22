"""Effects of the load path: friction, memory, drift. They need the rows in the order of measurement.

Each changes other entries of the parameter vector row by row, see `history`, which states the laws in full: t is the
time since the first row of a session, dir the direction in which a tendon last travelled (1 when it was pulled in),
theta the tip angle of the same mechanism without memory.
"""

from functools import partial
from math import pi

from .effect import also, effect

__all__ = ["EFFECTS"]

effect = partial(effect, enters="path", mirror="path")
# fmt: off
EFFECTS = (
    effect("tendon_capstan_friction", "lam exp(-a wrap dir)", "-", "friction of the tendons where they wrap a guide",
           also("wrap", "rad", "angle by which a tendon wraps its guide", pi / 2, (0.0, 100.0), 0.3),
           typical=0.03, bounds=(0.0, 2.0), group="friction and hysteresis", size="coefficient"),
    effect("tendon_coulomb_friction", "lam - a dir", "N", "constant friction of the tendons",
           typical=1.0, bounds=(0.0, 1e6), group="friction and hysteresis"),
    effect("bending_hysteresis", "M + a h, h in [-1, 1] follows theta/angle like a slider", "N m",
           "dry friction inside the material: the couple depends on where the neck came from",
           also("angle", "rad", "turn of the tip after which it slides", 0.1, (1e-3, 10.0), 0.03),
           typical=0.1, bounds=(0.0, 1e4), group="friction and hysteresis", size="couple"),
    effect("fading_memory", "M + a EI/L (theta - theta remembered), forgotten with exp(-t/time)", "-",
           "viscoelastic memory: the material first answers a change too stiffly",
           also("time", "s", "after which 1/e of it is left", 60.0, (1e-3, 1e7), 20.0),
           typical=0.03, bounds=(0.0, 10.0), group="memory", size="share", needs=("dwell_s",)),
    effect("creep", "EA, GA, EI / (1 + a log10(1 + dwell/1 s))", "-",
           "the material yields by this share with every decade of time held",
           typical=0.02, bounds=(-0.1, 1.0), group="memory", needs=("dwell_s",)),
    effect("mullins_softening", "EA, GA, EI times 1 - a max(lam_l + lam_r so far)/(320 N)", "-",
           "the material softens with the largest load it has borne",
           typical=0.05, bounds=(-0.5, 0.5), group="drift"),
    effect("stiffness_drift", "EA, GA, EI times 1 + a t", "1/h", "the stiffness drifts, as with temperature",
           typical=0.03, bounds=(-0.1, 10.0), group="drift", needs=("t_s",)),
    effect("force_zero_drift", "lam + a t", "N/h", "the zeros of both cells drift",
           typical=1.0, bounds=(-1e4, 1e4), group="drift", needs=("t_s",)),
    effect("force_zero_drift_asymmetry", "lam_l + a t/2, lam_r - a t/2", "N/h", "the cells' zeros drift apart",
           typical=1.0, bounds=(-1e4, 1e4), group="drift", needs=("t_s",)),
    effect("camera_drift_x", "x + a t", "m/h", "the camera drifts along the neck",
           typical=3e-4, bounds=(-1.0, 1.0), group="drift", needs=("t_s",)),
    effect("camera_drift_z", "z + a t", "m/h", "the camera drifts sideways",
           typical=3e-4, bounds=(-1.0, 1.0), group="drift", needs=("t_s",)),
)
