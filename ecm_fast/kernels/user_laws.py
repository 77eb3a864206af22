"""User-defined laws: called by address, differentiated here.

Addresses hold in one process alone. They stand in a table of this process, and nowhere else: a parameter vector names
its laws by the digest of `vector.tail`, `prepare` looks that up, and what it prepares has the number of an entry.

A law is given the values of all user effects and three coordinates (strains, or the head's pose), and at a section its
place; it returns three forces. It is compiled for complex numbers: for real ones the complex step gives the tangent,
for complex ones, whose imaginary parts are a complex step already, the forces alone.
"""

from typing import Any

import numpy as np

from ._jit import array_at, by_first_type, call_at, kernel, named_address
from .layout import N_USER

__all__ = ["LAWS", "STEP", "added", "find_law"]

STEP = 1e-100  # of the complex step: no subtraction, so it may be as small as numbers go

MOST_LAWS, N_LAW = 10_000, 3  # a table of fixed size, so that its address stays; numbers of an entry, below
LAWS = np.zeros(N_LAW * (1 + MOST_LAWS))
"""Number of entries; then, entry by entry: digest, address of the laws of the section and of the head, or 0.

Numbers below 2^53 all of them. Entries are only added: what was prepared with older laws keeps them.
"""
_laws = named_address("ecm_fast_laws", LAWS.ctypes.data)


@kernel
def find_law(digest, which):
    """Number of the law of the section (0) or the head (1) for a digest; 0: none enters there, -1: never added here."""
    laws = array_at(_laws(), N_LAW * (1 + MOST_LAWS))
    for entry in range(int(laws[0]), 0, -1):
        if laws[N_LAW * entry] == digest:
            return N_LAW * entry + 1 + which if laws[N_LAW * entry + 1 + which] != 0.0 else 0
    return -1


@kernel
def _at(a, b, c, law, values, place):
    """Three forces at the coordinates a, b, c, complex; nan where there is no such law."""
    laws, number = array_at(_laws(), N_LAW * (1 + MOST_LAWS)), int(law.real)
    address = int(laws[number]) if 0 < number < N_LAW * (1 + int(laws[0])) else 0
    if address == 0:
        nothing = complex(np.nan)
        return nothing, nothing, nothing
    return call_at(
        address,
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
"""``added(a, b, c, law, values, place)``: what the user's laws add; `law` their number, `values` (N_USER,)."""

assert N_USER == 8  # as many as `_at` passes on
