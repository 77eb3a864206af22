"""The reference model in dense NumPy: each formula once, with its number in the paper; `equations.md` lists them.

Same names as in `ecm_fast.kernels`, but written from the mechanism's named parameters, not from the arrays that
`kernels.prepare` makes. It is the oracle of the tests and a yardstick of time: of the package
`studies.paper.fig7_times` alone imports it. All forces accept complex parameters and coordinates, so that the complex
step differentiates them to rounding.

`p` is a mapping from a parameter's key to its value, see `named`.
"""

from .assembly import energy, gradient, newton_step, residual, rest_coordinates, solve, stations, tangent
from .camera import reading
from .element import element_energy, element_force, element_tangent
from .parameters import length, named
from .se2 import se2_energy
from .section import axial_energy, axial_law, section_energy, section_law, section_stiffness, section_strains, station
from .strain import strain_energy
from .tip import head_pose, tendon, tendon_forces, tip_energy, tip_stiffness, tip_wrench

__all__ = [
    "axial_energy",
    "axial_law",
    "element_energy",
    "element_force",
    "element_tangent",
    "energy",
    "gradient",
    "head_pose",
    "length",
    "named",
    "newton_step",
    "reading",
    "residual",
    "rest_coordinates",
    "se2_energy",
    "section_energy",
    "section_law",
    "section_stiffness",
    "section_strains",
    "solve",
    "station",
    "stations",
    "strain_energy",
    "tangent",
    "tendon",
    "tendon_forces",
    "tip_energy",
    "tip_stiffness",
    "tip_wrench",
]
