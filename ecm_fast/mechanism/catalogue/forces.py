"""Effects of the force cells: differences between the applied and the recorded tendon forces.

From the readings r_l, r_r of both cells the left tendon's force is

    lam_l = r_l (1 + gain + asymmetry/2) + zero + zero_asymmetry/2 + nonlinearity r_l^2/(160 N) + crosstalk r_r

and the right one's the same with left and right exchanged, both asymmetries with the other sign.
"""

from functools import partial

from .effect import effect

__all__ = ["EFFECTS", "FULL_SCALE", "LARGEST_PUSH"]

FULL_SCALE = 160.0
"""Force at which the nonlinearity of a cell is stated [N]."""
LARGEST_PUSH = 10.0
"""Lowest force of a tendon below zero [N]: ten times what is typical for the zero of a cell.

A reading near zero is uncertain by about as much; where more is missing, no reading and mechanism fit together.
"""

effect = partial(effect, enters="force")
# fmt: off
EFFECTS = (
    effect("force_gain", "lam = r (1 + a)", "-", "both cells read too little",
           typical=0.03, bounds=(-0.9, 10.0), group="x scale", mirror="even"),
    effect("force_gain_asymmetry", "lam_l = r_l (1 + a/2), lam_r = r_r (1 - a/2)", "-",
           "the left cell reads too little beside the right one",
           typical=0.02, bounds=(-1.8, 1.8), group="left-right leverage", mirror="odd"),
    effect("force_zero", "lam = r + a", "N", "both cells show less than the force by the same amount",
           typical=1.0, bounds=(-1e6, 1e6), group="x scale", mirror="even"),
    effect("force_zero_asymmetry", "lam_l = r_l + a/2, lam_r = r_r - a/2", "N", "the cells' zeros differ",
           typical=1.0, bounds=(-1e6, 1e6), group="moment bias", mirror="odd"),
    effect("force_nonlinearity", "lam = r + a r^2/(160 N)", "-", "both cells lose sensitivity with the force",
           typical=0.02, bounds=(-0.9, 10.0), group="compression-dependent", mirror="even"),
    effect("force_crosstalk", "lam_l = r_l + a r_r, lam_r = r_r + a r_l", "-", "each cell misses a share of the other",
           typical=0.01, bounds=(-0.9, 10.0), group="compression-dependent", mirror="even"),
)
