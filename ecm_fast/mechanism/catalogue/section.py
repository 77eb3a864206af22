"""Effects of the beam and its cross-section: they enter the section's energy.

u is the curvature less that of the beam as it was cast, g the stretch gamma_x, N0 the axial law of the mechanism.
"""

from functools import partial

from .effect import also, effect

__all__ = ["EFFECTS"]

effect = partial(effect, enters="section")
# fmt: off
EFFECTS = (
    effect("precurvature", "u = kappa - a", "1/m", "curvature of the beam as it was cast",
           typical=0.2, bounds=(-100.0, 100.0), group="moment bias", mirror="odd"),
    effect("precurvature_gradient", "u = kappa - a (2 s/L - 1)", "1/m", "the beam was cast in the shape of an S",
           typical=0.2, bounds=(-100.0, 100.0), group="z offset", mirror="odd"),
    effect("neutral_axis_offset", "N acts on gamma_x + a kappa, and adds a N to M", "m",
           "distance of the neutral axis from the centerline along e_z",
           typical=1e-3, bounds=(-0.1, 0.1), group="left-right leverage", mirror="odd"),
    effect("bending_cubic", "M = EI u (1 + a u^2)", "m^2", "bending stiffens with the curvature",
           typical=0.004, bounds=(-1.0, 1.0), group="bending law", mirror="even"),
    effect("bending_amplitude", "M = EI u (1 + a |u|)", "m", "bending stiffens with the size of the curvature",
           typical=0.014, bounds=(-1.0, 1.0), group="bending law", mirror="even"),
    effect("bending_one_sided", "M = EI u (1 + a u)", "m", "bending is stiffer to one side than to the other",
           typical=0.014, bounds=(-1.0, 1.0), group="one-sided bending", mirror="odd"),
    effect("bimodulus",
           "E (1 + a) where a fibre is stretched; section a rectangle of the height (12 EI/EA)^1/2", "-",
           "the material is stiffer in tension than in compression",
           typical=0.1, bounds=(-0.9, 10.0), group="bending law", mirror="even"),
    effect("neo_hookean_section", "energy + a EI u^2/2 ((1 + 2 g^-3)/3 - 1)", "-",
           "the neo-Hookean law acts in every fibre, not only on the mean: bending stiffens under compression",
           typical=1.0, bounds=(-10.0, 10.0), group="compression-dependent", mirror="even"),
    effect("mooney_rivlin", "N = N0 + a EA/3 (g - g^-2) (1/g - 1)", "-",
           "share of the second Mooney-Rivlin term in Young's modulus",
           typical=0.3, bounds=(-10.0, 10.0), group="x scale", mirror="even"),
    effect("ogden", "N = N0 + 2 EA/(3 m) (g^(m-1) - g^(-m/2-1)) - EA/3 (g - g^-2), m = 2 + a", "-",
           "the exponent of Ogden's axial law is not 2",
           typical=1.0, bounds=(-1.5, 20.0), group="x scale", mirror="even"),
    effect("shear_cubic", "Q = GA gamma_z (1 + a gamma_z^2)", "-", "shear stiffens with the shear",
           typical=45.0, bounds=(-1e4, 1e4), group="bending law", mirror="even"),
    effect("shear_compression", "energy + a N0(g) gamma_z^2/2, so Q = (GA + a N0) gamma_z", "-",
           "shear softens under compression (Haringx against Engesser)",
           typical=1.0, bounds=(-20.0, 20.0), group="compliance ratio", mirror="even"),
    effect("stiffness_taper", "EA, GA and EI times 1 + a (2 s/L - 1)", "-",
           "the beam is stiffer at its tip than at its clamp",
           typical=0.05, bounds=(-0.99, 0.99), group="compliance ratio", mirror="even"),
    effect("soft_spot", "EA, GA and EI times 1 - a where |s - place L| < width/2", "-",
           "share of the stiffness that a stretch of the beam lacks, as at a void",
           also("place", "-", "its middle, as a share of the length from the clamp", 1.0 / 3.0, (0.0, 1.0), 0.1),
           also("width", "m", "its length along the beam", 0.015, (0.0, 1e3), 0.005),
           typical=0.2, bounds=(-10.0, 0.99), group="compliance ratio", mirror="even", size="size"),
    effect("bonded_ends", "EA, GA and EI times 1 + a (exp(-s/decay) + exp(-(L - s)/decay))", "-",
           "both ends are stiffer where they are bonded to their plates",
           also("decay", "m", "length over which that fades", 0.02, (1e-4, 10.0), 0.005),
           typical=0.1, bounds=(-0.9, 100.0), group="compression-dependent", mirror="even", size="size"),
    effect("beam_length", "L + a", "m", "the beam is longer than drawn",
           typical=1e-3, bounds=(-1.0, 1e3), tolerance=3e-5, group="x scale", mirror="even"),
    effect("beam_mass", "rhoA + a", "kg/m", "the beam is heavier than listed",
           typical=1.0, bounds=(-1e6, 1e6), group="x scale", mirror="even"),
)
