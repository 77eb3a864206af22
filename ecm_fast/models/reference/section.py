"""The cross-section: strains, energy, contact force and couple, stiffness.

With the stretch g = gamma_x + e kappa and the turn u = kappa - kappa0 of the beam as it was cast, the energy is a
function of g, gamma_z and u; e is the neutral axis offset. Without effects it is the paper's.
"""

from typing import Any

import numpy as np

from .body import guide_energy
from .parameters import Parameters, length

__all__ = [
    "axial_energy",
    "axial_law",
    "section_energy",
    "section_law",
    "section_stiffness",
    "section_strains",
    "station",
]


def section_strains(dr: Any, theta: Any, dtheta: Any) -> Any:
    """[S1] Strains of one section, (3,), from the centerline's tangent and the section's turn.

        gamma_x = x' cos theta - z' sin theta    stretch along the section's normal, 1 undeformed [-]
        gamma_z = x' sin theta + z' cos theta    shear [-]
        kappa   = theta'                         curvature [1/m], > 0 turns the tip towards -z

    Source: the paper, (13) and (14).
    """
    c, s = np.cos(theta), np.sin(theta)
    return np.array([dr[0] * c - dr[1] * s, dr[0] * s + dr[1] * c, dtheta])


def axial_energy(p: Parameters, stretch: Any) -> Any:
    """[C0] Energy per length of an axial stretch [N], zero at 1; its derivative is `axial_law`.

    neo-Hookean   EA/3 (g^2/2 + 1/g - 3/2)
    Hooke         EA/2 (g - 1)^2
    """
    if p["beam.axial_law"] == 1.0:
        return p["beam.EA"] / 2.0 * (stretch - 1.0) ** 2
    return p["beam.EA"] / 3.0 * (stretch**2 / 2.0 + 1.0 / stretch - 1.5)


def axial_law(p: Parameters, stretch: Any) -> tuple[Any, Any]:
    """[C1] Axial force [N] and its derivative by the stretch.

        neo-Hookean   N = EA/3 (g - 1/g^2)
        Hooke         N = EA (g - 1)

    Source: the paper, (19) and the sentence after it.
    """
    EA = p["beam.EA"]
    if p["beam.axial_law"] == 1.0:
        return EA * (stretch - 1.0), EA
    return EA / 3.0 * (stretch - 1.0 / stretch**2), EA / 3.0 * (1.0 + 2.0 / stretch**3)


def section_energy(p: Parameters, strains: Any) -> Any:
    """Energy of the section per length of the undeformed beam [N]; its gradient is `section_law`.

    Beside [C0], GA gamma_z^2/2 and EI u^2/2 it has the terms

        [C4]  EI (a_c u^4/4 + a_a |u|^3/3 + a_o u^3/3)                              nonlinear bending
        [C5]  EA/3 a_m ((g + g^-2/2 - 3/2) - (g^2/2 + 1/g - 3/2))                   Mooney-Rivlin
              2 EA/(3 m) (g^m/m + 2 g^(-m/2)/m - 3/m) - EA/3 (g^2/2 + 1/g - 3/2)    Ogden, m = 2 + a
        [C6]  a_n EI u^2/2 ((1 + 2 g^-3)/3 - 1)                                     neo-Hookean fibres
        [C7]  a_b EA/(2 h) times the integral of eps^2 over the stretched fibres    bimodulus, h = (12 EI/EA)^1/2
        [C8]  GA a_s gamma_z^4/4 + a_h N0(g) gamma_z^2/2                            nonlinear shear
        [C9]  the sum of lam |t| over guided tendons, [B4]
    """
    gamma_x, gamma_z, kappa = strains
    EA, GA, EI = p["beam.EA"], p["beam.GA"], p["beam.EI"]
    u, g = _turn(p, kappa), gamma_x + p["effects.neutral_axis_offset"] * kappa
    uneven = p["effects.bending_amplitude"] * _size(u) + p["effects.bending_one_sided"] * u
    bending = EI * u**2 * (1.0 / 2.0 + p["effects.bending_cubic"] * u**2 / 4.0 + uneven / 3.0)
    shear = GA * (gamma_z**2 / 2.0 + p["effects.shear_cubic"] * gamma_z**4 / 4.0)
    shear = shear + p["effects.shear_compression"] * axial_law(p, g)[0] * gamma_z**2 / 2.0
    fibres = p["effects.neo_hookean_section"] * EI * u**2 / 2.0 * ((1.0 + 2.0 / g**3) / 3.0 - 1.0)
    plain, m = g**2 / 2.0 + 1.0 / g - 1.5, 2.0 + p["effects.ogden"]
    mooney = p["effects.mooney_rivlin"] * (g + 1.0 / g**2 / 2.0 - 1.5 - plain)
    ogden = 2.0 / m**2 * (g**m + 2.0 * g ** (-m / 2.0) - 3.0) - plain
    eps, _, width = _stretched(p, g, u)
    stretched = p["effects.bimodulus"] * EA / (2.0 * _height(p)) * (width @ eps**2)
    guides = sum(tension * guide_energy(strains, *path) for tension, *path in p.get("guides", ()))
    return axial_energy(p, g) + shear + bending + fibres + EA / 3.0 * (mooney + ogden) + stretched + guides


def _turn(p: Parameters, kappa: Any) -> Any:
    return kappa - p["effects.precurvature"]


def _size(u: Any) -> Any:
    """|u|, continued to complex numbers as the complex step needs it."""
    return u if np.real(u) > 0.0 else -u


def _height(p: Parameters) -> Any:
    """Height of a rectangle with the section's EI/EA [m]."""
    return np.sqrt(12.0 * p["beam.EI"] / p["beam.EA"])


def _fibres(p: Parameters, g: Any, u: Any) -> tuple[Any, Any]:
    """Heights between which fibres are stretched, of those from -h/2 to h/2 on the side that bending stretches [m]."""
    h = _height(p)
    if np.real(_size(u)) * np.real(h) / 2.0 <= abs(np.real(g) - 1.0):
        return (-h / 2.0, h / 2.0) if np.real(g) > 1.0 else (h / 2.0, h / 2.0)
    return -(g - 1.0) / _size(u), h / 2.0


def _stretched(p: Parameters, g: Any, u: Any) -> tuple[Any, Any, Any]:
    """Strain eps = g - 1 + zeta |u| of stretched fibres, their heights zeta [m] and weights [m], by Gauss's rule."""
    first, last = _fibres(p, g, u)
    points, weights = np.polynomial.legendre.leggauss(3)
    zeta = first + (last - first) * (points + 1.0) / 2.0
    return g - 1.0 + zeta * _size(u), zeta, (last - first) / 2.0 * weights


def section_law(p: Parameters, strains: Any) -> Any:
    """[C2] Contact force N, Q [N] and couple M [N m] in the section's axes, (3,).

        N = N0(g) + ...,   Q = GA gamma_z + ...,   M = EI u + e N + ...

    the gradient of `section_energy`, term by term; without effects the paper's (19).
    """
    gamma_x, gamma_z, kappa = strains
    EA, GA, EI = p["beam.EA"], p["beam.GA"], p["beam.EI"]
    offset = p["effects.neutral_axis_offset"]
    u, g = _turn(p, kappa), gamma_x + offset * kappa
    N0, slope = axial_law(p, g)
    m, along = 2.0 + p["effects.ogden"], p["effects.shear_compression"]
    plain = g - 1.0 / g**2
    N = N0 + EA / 3.0 * p["effects.mooney_rivlin"] * plain * (1.0 / g - 1.0)
    N = N + EA / 3.0 * (2.0 / m * (g ** (m - 1.0) - g ** (-m / 2.0 - 1.0)) - plain)
    N = N + along * slope * gamma_z**2 / 2.0 - p["effects.neo_hookean_section"] * EI * u**2 / g**4
    Q = GA * gamma_z * (1.0 + p["effects.shear_cubic"] * gamma_z**2) + along * N0 * gamma_z
    further = p["effects.bending_cubic"] * u**2 + p["effects.bending_amplitude"] * _size(u)
    M = EI * u * (1.0 + further + p["effects.bending_one_sided"] * u)
    M = M + p["effects.neo_hookean_section"] * EI * u * ((1.0 + 2.0 / g**3) / 3.0 - 1.0)
    eps, zeta, width = _stretched(p, g, u)
    force = p["effects.bimodulus"] * EA / _height(p) * width * eps
    N = N + force.sum()
    M = M + (1.0 if np.real(u) > 0.0 else -1.0) * (force @ zeta)
    M = M + offset * N
    for tension, o, slope in p.get("guides", ()):
        t_x, t_z = gamma_x + o * kappa, gamma_z + slope
        pull = tension / np.sqrt(t_x**2 + t_z**2)
        N, Q, M = N + pull * t_x, Q + pull * t_z, M + pull * o * t_x
    return np.array([N, Q, M])


def section_stiffness(p: Parameters, strains: Any) -> Any:
    """Second derivatives of `section_energy`, (3, 3), symmetric: those of `section_law` by the complex step."""
    probes = np.asarray(strains, dtype=float) + 1e-100j * np.eye(3)
    return np.column_stack([section_law(p, probe).imag / 1e-100 for probe in probes])


def station(p: Parameters, place: Any, begin: Any, share: Any, i: int, gauss: int) -> Parameters:
    """[C3] The parameters of Gauss point i of an element: stiffnesses EA, GA, EI and the curvature as cast.

        (EA, GA, EI) (1 + t (2 s/L - 1)) (1 + b (exp(-s/l) + exp(-(L - s)/l))) / (1 + c v/(1 - v))

    t is the taper, b the gain of bonded ends that fades over l; the soft spot takes the share v of the stiffness of a
    stretch of beam. The element goes from `begin` to `begin + share` [shares of the length], and c is what of the
    stretch falls to the point, see `covered`; a point beside the stretch, where c may be below 0, keeps 0.05 of its
    compliance whatever v is.
    """
    half, fade = 0.5 * p["effects.soft_spot.width"] / length(p), length(p) / p["effects.bonded_ends.decay"]
    middle, size, along = p["effects.soft_spot.place"], p["effects.soft_spot.size"], 2.0 * place - 1.0
    falls = covered((middle - half - begin) / share, (middle + half - begin) / share, i, gauss)
    compliance = max(1.0 + falls * size / (1.0 - size), 0.05, key=np.real)
    profile = (1.0 + p["effects.stiffness_taper"] * along) / compliance
    profile = profile * (1.0 + p["effects.bonded_ends.size"] * (np.exp(-place * fade) + np.exp((place - 1.0) * fade)))
    stiffness = {key: p[key] * profile for key in ("beam.EA", "beam.GA", "beam.EI")}
    cast = p["effects.precurvature"] + p["effects.precurvature_gradient"] * along
    return {**p, **stiffness, "effects.precurvature": cast}


def covered(first: Any, last: Any, i: int, gauss: int) -> Any:
    """[C3] What falls to Gauss point i of a stretch of an element, its ends as shares of the element.

    The integral over the stretch of the polynomial that is 1 at this Gauss point and 0 at the others, less the point's
    weight: then a sum over the Gauss points is the integral over the stretch, for all polynomials that they determine.
    It is 1 where the stretch is the whole element, and may be below 0 beside it.
    """
    first, last = (min(max(end, 0.0, key=np.real), 1.0, key=np.real) for end in (first, last))
    points, weights = np.polynomial.legendre.leggauss(gauss)
    others = np.delete(points, i)
    whole = (np.poly1d(others, r=True) / np.prod(points[i] - others)).integ()
    return (whole(2.0 * last - 1.0) - whole(2.0 * first - 1.0)) / weights[i]
