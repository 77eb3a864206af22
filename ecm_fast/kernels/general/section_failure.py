"""Failure of a section: whether its law, not the neck as a column, ends the stable branch; `newton` judges the neck."""

from typing import Any

from .._jit import by_first_type, kernel
from ..layout import S_EA, S_EI, S_FURTHER, S_GA
from .elements import lagrange
from .elements.dispatch import kernels_for

__all__ = ["LOST", "section_fails", "softens"]

# stiffness of a section that is as good as lost, as a share of what it has unstrained
LOST = 1e-3


@kernel
def _lagrange_fails(tables, stations, loads, q, lost, sheared):
    """Whether a section fails, at the Gauss points of Lagrange's elements."""
    n_gauss, width = tables.shape[1], 3 * (tables.shape[2] - 1)
    for i in range(stations.shape[0]):
        station, first = stations[i], width * (i // n_gauss)
        _, _, gamma_x, _, _, law = lagrange.section_at(
            tables, station, loads, i % n_gauss, q[first : first + width + 3]
        )
        N, _, _, N_x, Q_x, _, Q_z, _, M_k = law
        det = N_x * Q_z - Q_x * Q_x
        EA, GA, EI = station[S_EA], station[S_GA], station[S_EI]
        if not (N_x > lost * EA and Q_z > lost * GA and det > lost * EA * GA and M_k > lost * EI):
            return True
        if sheared and N > 0.0 and gamma_x * det < N * N_x:
            return True
    return False


@kernel
def _not_looked_at(tables, stations, loads, q, lost, sheared):
    """Of other families the strains are not known here."""
    return False


section_fails: Any = by_first_type(
    lambda tables: _lagrange_fails if kernels_for(tables) is lagrange else _not_looked_at
)
"""Whether the law of a section, not the neck as a column, is what lost stability at `q`.

Either the law has no more than a share `lost` of its stiffness. Or, where `sheared` is looked at, a tension N is more
than what shears the section at a given tension, N > gamma_x (Q_z - Q_x^2/N_x): with the plain law N > GA gamma_x. A
section that turns then gains more from shearing than it loses. What a shear force adds where N is small, and any
compression, bending holds in every column.
"""


@kernel
def softens(tables, stations, loads, q):
    """Whether a section's law has a negative stiffness at `q`: then no equilibrium is stable, by Legendre's condition.

    A mesh hides that where no piece of the beam is short enough to bend alone.
    """
    for i in range(stations.shape[0]):
        if stations[i, S_FURTHER] != 0.0:
            return section_fails(tables, stations, loads, q, 0.0, False)
    return False
