"""User-defined laws: called by address, differentiated here.

A law is given the values of all user effects and three coordinates (strains, or the head's pose), and at a section its
place; it returns three forces. It is compiled for complex numbers: for real ones the complex step gives the tangent,
for complex ones, whose imaginary parts are a complex step already, the forces alone.
"""

from typing import Any

import numpy as np

from ._jit import by_first_type, call_at, kernel
from .layout import N_USER

__all__ = ["STEP", "added"]

STEP = 1e-100  # of the complex step: no subtraction, so it may be as small as numbers go


@kernel
def _at(a, b, c, law, values, place):
    """Three forces at the coordinates a, b, c, complex."""
    return call_at(
        int(law.real),
        (
            complex(values[0]), complex(values[1]), complex(values[2]), complex(values[3]), complex(values[4]),
            complex(values[5]), complex(values[6]), complex(values[7]), a, b, c, complex(place),
        ),
    )  # fmt: skip


@kernel
def _real(a, b, c, law, values, place):
    """Three forces and their derivatives aa, ab, ac, bb, bc, cc; real."""
    x, y, z = complex(a), complex(b), complex(c)
    step = complex(0.0, STEP)
    by_a, by_b = _at(x + step, y, z, law, values, place), _at(x, y + step, z, law, values, place)
    by_c = _at(x, y, z + step, law, values, place)
    forces = by_a[0].real, by_a[1].real, by_a[2].real
    first = by_a[0].imag / STEP, by_b[0].imag / STEP, by_c[0].imag / STEP
    return forces, (*first, by_b[1].imag / STEP, by_c[1].imag / STEP, by_c[2].imag / STEP)


@kernel
def _complex(a, b, c, law, values, place):
    """Three forces; no derivatives, which nobody asks for along a complex step."""
    none = 0.0 * a
    return _at(a, b, c, law, values, place), (none, none, none, none, none, none)


def _choose(coordinate: Any) -> Any:
    return _complex if np.iscomplexobj(coordinate) or str(coordinate) == "complex128" else _real


added: Any = by_first_type(_choose)
"""``added(a, b, c, law, values, place)``: what the user's laws add; `law` their address, `values` (N_USER,)."""

assert N_USER == 8  # as many as `_at` passes on
