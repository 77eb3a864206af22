"""SE(2) elements of constant strain: two poses joined by the arc that the logarithm of SE(2) gives.

Source of the idea: Sonneville, Cardona & Brüls, Comput. Methods Appl. Mech. Engrg. 268 (2014) 451-474, on SE(3).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .family import Family
from .quadrature import gauss_rule

__all__ = ["SE2", "Se2Tables"]

Array = NDArray[np.float64]


class Se2Tables(NamedTuple):
    """Tables for the kernel `kernels.se2`: the Gauss points' places in the element, (gauss,)."""

    points: Array


def _tables(order: int, gauss: int) -> Se2Tables:
    return Se2Tables(gauss_rule(gauss)[0])


def _centerline(order: int, gauss: int, q: Array, places: Array) -> Array:
    """Poses on the arc: a part xi of it has the chord xi sin(xi phi / 2) / (xi sin(phi / 2)), turned back."""
    first, last = q[:, 0], q[:, 1]
    turn = last[:, 2] - first[:, 2]
    along = places * np.sinc(places * turn / (2.0 * np.pi)) / np.sinc(turn / (2.0 * np.pi))
    chord = (last[:, 0] - first[:, 0]) + 1j * (last[:, 1] - first[:, 1])
    r = chord * along * np.exp(0.5j * (1.0 - places) * turn)
    return np.stack([first[:, 0] + r.real, first[:, 1] + r.imag, first[:, 2] + places * turn], axis=1)


SE2 = Family(
    name="se2",
    meaning="constant strains between two poses, exactly integrated (helicoidal); never locks",
    highest_order=1,
    points=lambda order: 1,
    tip_order=lambda order: 2,
    inner_places=True,
    tables=_tables,
    centerline=_centerline,
)
