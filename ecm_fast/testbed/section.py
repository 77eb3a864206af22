"""The cross-section of the test bed: stiffness along the beam, and the section law.

The energy of a section per undeformed length, with g = gamma_x + e kappa, where e is the neutral axis offset, and u the
curvature less that of the beam as it was cast, is

    W = W0(g) + GA gamma_z^2/2 + EI u^2/2 + the terms of `FURTHER`

W0 is that of the axial law, N0 its derivative. Each further term stands below with its energy in the first line and
returns the energy's derivatives by g, gamma_z and u. Arguments may be complex; where a law has a corner, their real
part decides on which side they are. Source of the laws without effects: the paper, (19).
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from .laws import Parameters, length
from .variants import LEVEL, SHEAR_LEVEL, blend, used

__all__ = ["FURTHER", "jumps", "section", "stiffness"]

Array = Any  # NumPy arrays, real or complex
Gradient = tuple[Array, Array, Array]


class Station(NamedTuple):
    """A section under strain: its stiffnesses, g, gamma_z and u, and the axial law with its slope."""

    EA: Array
    GA: Array
    EI: Array
    g: Array
    gamma_z: Array
    u: Array
    N0: Array
    dN0: Array


def stiffness(p: Parameters, s: float) -> tuple[Array, Array, Array]:
    """EA [N], GA [N] and EI [N m^2] at the undeformed arclength `s` [m] from the clamp."""
    L, middle = length(p), p["effects.soft_spot.place"]
    soft = p["effects.soft_spot.size"] if abs(s - middle * L) < p["effects.soft_spot.width"] / 2.0 else 0.0
    decay = p["effects.bonded_ends.decay"]
    bonded = p["effects.bonded_ends.size"] * (np.exp(-s / decay) + np.exp(-(L - s) / decay))
    along = blend(p, "taper_quadratic", 2.0 * s / L - 1.0, 2.0 * (s / L) ** 2 - 2.0 / 3.0)
    share = (1.0 + p["effects.stiffness_taper"] * along) * (1.0 - soft) * (1.0 + bonded)
    return p["beam.EA"] * share, p["beam.GA"] * share, p["beam.EI"] * share


def jumps(p: Parameters) -> list[float]:
    """Arclengths between clamp and tip at which `stiffness` or the cast jumps [m], in order."""
    L, half = length(p), p["effects.soft_spot.width"] / 2.0
    if used(p, "cast_below"):
        return [0.5 * L]
    if p["effects.soft_spot.size"] == 0.0 or half == 0.0:
        return []
    middle = p["effects.soft_spot.place"] * L
    return [s for s in (middle - half, middle + half) if 0.0 < s < L]


def section(p: Parameters, s: float, strains: Array) -> Array:
    """Contact force N, Q [N] and couple M [N m], (3, ...), of the strains gamma_x, gamma_z, kappa, (3, ...)."""
    EA, GA, EI = stiffness(p, s)
    gamma_x, gamma_z, kappa = strains
    e = p["effects.neutral_axis_offset"]
    g, u = gamma_x + e * kappa, kappa - _cast(p, s)
    N0, dN0 = _axial_law(p, EA, g)
    at = Station(EA, GA, EI, g, gamma_z, u, N0, dN0)
    N, Q, M = N0, GA * gamma_z, EI * u
    for key, law in FURTHER.items():
        if (a := p[key]) != 0.0:
            N, Q, M = (mine + more for mine, more in zip((N, Q, M), _levelled(p, law(a, at), at), strict=True))
    return np.stack([N, Q, M + e * N])


def _cast(p: Parameters, s: float) -> Array:
    """Curvature of the beam as it was cast [1/m]."""
    along = blend(p, "cast_below", 1.0, 1.5 if s < 0.5 * length(p) else 0.5)
    return p["effects.precurvature"] * along + p["effects.precurvature_gradient"] * (2.0 * s / length(p) - 1.0)


def _levelled(p: Parameters, gradient: Gradient, at: Station) -> Gradient:
    """Laws of bending and shear that grow less and less; each depends on one strain alone, so that it has an energy."""
    N, Q, M = gradient
    shear, bending = at.gamma_z / SHEAR_LEVEL, at.u / LEVEL
    return (
        N,
        blend(p, "shear_levels_off", Q, Q / (1.0 + shear * shear)),
        blend(p, "bending_levels_off", M, M / (1.0 + bending * bending)),
    )


def _axial_law(p: Parameters, EA: Array, g: Array) -> tuple[Array, Array]:
    """N0 and its derivative by g [N]."""
    if p["beam.axial_law"] == "hooke":
        return EA * (g - 1.0), EA
    square = g * g
    return EA / 3.0 * (g - 1.0 / square), EA / 3.0 * (1.0 + 2.0 / (square * g))


def _size(u: Array) -> Array:
    """|u| of a number whose imaginary part is infinitesimal."""
    return np.where(u.real < 0.0, -u, u)


def _bending_cubic(a: float, at: Station) -> Gradient:
    """The energy a EI u^4/4."""
    return 0.0, 0.0, a * at.EI * at.u * at.u * at.u


def _bending_amplitude(a: float, at: Station) -> Gradient:
    """The energy a EI |u|^3/3."""
    return 0.0, 0.0, a * at.EI * at.u * _size(at.u)


def _bending_one_sided(a: float, at: Station) -> Gradient:
    """The energy a EI u^3/3."""
    return 0.0, 0.0, a * at.EI * at.u * at.u


def _bimodulus(a: float, at: Station) -> Gradient:
    """The energy a EA/(2 h) times the integral over zeta in [-h/2, h/2] of eps^2 where eps = g - 1 + zeta u is > 0.

    The rectangle of the height h has h^2 = 12 EI/EA. With c = |u| h/2, the strain of bending at the edges, the neutral
    fiber lies at -t h/2 on the side that is stretched, t = (g - 1)/c; beyond |t| = 1 it lies outside the section.
    """
    axial, c = at.g - 1.0, _size(at.u) * np.sqrt(3.0 * at.EI / at.EA)
    inside = np.abs(axial.real) < c.real
    t = np.where(inside, axial / np.where(inside, c, 1.0), np.where(axial.real < 0.0, -1.0, 1.0))
    N = np.where(inside, c * (1.0 + t) * (1.0 + t) / 4.0, np.where(axial.real > 0.0, axial, 0.0))
    return a * at.EA * N, 0.0, a * at.EI * at.u * (1.0 + t) * (1.0 + t) * (2.0 - t) / 4.0


def _neo_hookean_section(a: float, at: Station) -> Gradient:
    """The energy a EI u^2/2 ((1 + 2 g^-3)/3 - 1)."""
    cube = 1.0 / (at.g * at.g * at.g)
    return -a * at.EI * at.u * at.u * cube / at.g, 0.0, a * at.EI * at.u * (2.0 * cube - 2.0) / 3.0


def _mooney_rivlin(a: float, at: Station) -> Gradient:
    """The energy a EA/3 (g - g^2/2 + g^-2/2 - 1/g)."""
    return a * at.EA / 3.0 * (at.g - 1.0 / (at.g * at.g)) * (1.0 / at.g - 1.0), 0.0, 0.0


def _ogden(a: float, at: Station) -> Gradient:
    """The energy 2 EA/(3 m) (g^m/m + 2 g^(-m/2)/m) - EA/3 (g^2/2 + 1/g), m = 2 + a."""
    m = 2.0 + a
    law = 2.0 / m * (at.g ** (m - 1.0) - at.g ** (-0.5 * m - 1.0))
    return at.EA / 3.0 * (law - at.g + 1.0 / (at.g * at.g)), 0.0, 0.0


def _shear_cubic(a: float, at: Station) -> Gradient:
    """The energy a GA gamma_z^4/4."""
    return 0.0, a * at.GA * at.gamma_z * at.gamma_z * at.gamma_z, 0.0


def _shear_compression(a: float, at: Station) -> Gradient:
    """The energy a N0(g) gamma_z^2/2."""
    return 0.5 * a * at.dN0 * at.gamma_z * at.gamma_z, a * at.N0 * at.gamma_z, 0.0


FURTHER: Mapping[str, Callable[[float, Station], Gradient]] = {
    "effects.bending_cubic": _bending_cubic,
    "effects.bending_amplitude": _bending_amplitude,
    "effects.bending_one_sided": _bending_one_sided,
    "effects.bimodulus": _bimodulus,
    "effects.neo_hookean_section": _neo_hookean_section,
    "effects.mooney_rivlin": _mooney_rivlin,
    "effects.ogden": _ogden,
    "effects.shear_cubic": _shear_cubic,
    "effects.shear_compression": _shear_compression,
}
"""The further terms of the energy, by the key of their size a."""
