"""Element families: everything that distinguishes one kind of element from another, below the kernels.

To add one: declare it in a file here and in `FAMILIES`, write its kernels and name them in `kernels.families`, and
its energy in `reference`. The front, Newton's method, batches, steppers, sensitivities and shapes then take it.
"""

from ....errors import InputError, did_you_mean, shown
from .family import Family
from .lagrange import LAGRANGE
from .quadrature import gauss_rule, integrals, lagrange, lobatto_nodes
from .se2 import SE2, Se2Tables
from .strain import STRAIN, StrainTables

__all__ = [
    "FAMILIES",
    "Family",
    "Se2Tables",
    "StrainTables",
    "find_family",
    "gauss_rule",
    "integrals",
    "lagrange",
    "lobatto_nodes",
]

FAMILIES: dict[str, Family] = {family.name: family for family in (LAGRANGE, SE2, STRAIN)}


def find_family(name: object) -> Family:
    """Return the family of a name.

    Raises
    ------
    InputError : no family has it; names the nearest.
    """
    if isinstance(name, str) and name in FAMILIES:
        return FAMILIES[name]
    allowed = ", ".join(repr(family) for family in FAMILIES)
    hint = did_you_mean(name, FAMILIES) if isinstance(name, str) else ""
    raise InputError(f"family = {shown(name)}: allowed is one of {allowed}{hint}")
