"""The cross-section: strains, energy, contact force and couple, stiffness."""

from typing import Any

import numpy as np

from .parameters import Parameters

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
    """Energy of the section per length of the undeformed beam [N]; its gradient is `section_law`."""
    gamma_x, gamma_z, kappa = strains
    bending = p["beam.EI"] / 2.0 * (kappa - p["effects.precurvature"]) ** 2
    stretch = gamma_x + p["effects.neutral_axis_offset"] * kappa
    return axial_energy(p, stretch) + p["beam.GA"] / 2.0 * gamma_z**2 + bending


def section_law(p: Parameters, strains: Any) -> Any:
    """[C2] Contact force N, Q [N] and couple M [N m] in the section's axes, (3,).

        N = N(gamma_x + e kappa),   Q = GA gamma_z,   M = EI (kappa - kappa0) + e N

    e is the neutral axis offset, kappa0 the precurvature; both are 0 in the paper's (19).
    """
    gamma_x, gamma_z, kappa = strains
    offset = p["effects.neutral_axis_offset"]
    N, _ = axial_law(p, gamma_x + offset * kappa)
    M = p["beam.EI"] * (kappa - p["effects.precurvature"]) + offset * N
    return np.array([N, p["beam.GA"] * gamma_z, M])


def section_stiffness(p: Parameters, strains: Any) -> Any:
    """Second derivatives of `section_energy`, (3, 3), symmetric."""
    gamma_x, _, kappa = strains
    offset = p["effects.neutral_axis_offset"]
    _, slope = axial_law(p, gamma_x + offset * kappa)
    coupling = offset * slope
    return np.array(
        [
            [slope, 0.0, coupling],
            [0.0, p["beam.GA"], 0.0],
            [coupling, 0.0, p["beam.EI"] + offset * coupling],
        ]
    )


def station(p: Parameters, place: Any, before: Any, share: Any) -> Parameters:
    """[C3] The parameters with the stiffnesses EA, GA, EI of one Gauss point.

        (EA, GA, EI) (1 + t (2 s/L - 1)) / (1 + c v/(1 - v))

    t is the taper; the soft spot takes the share v of the stiffness of a stretch of beam. A Gauss point stands for as
    much of the beam as its weight says, from `before` to `before + share` [shares of the length], of which the soft
    spot covers the share c: the compliance there is the mean one, and over the beam the soft spot adds the compliance
    that it has, wherever the Gauss points are. With the ends of elements at its ends, c is 0 or 1.
    """
    half = 0.5 * p["effects.soft_spot.width"] / p["beam.length"]
    ends = p["effects.soft_spot.place"] - half, p["effects.soft_spot.place"] + half
    first, last = (min(max(end, before, key=np.real), before + share, key=np.real) for end in ends)
    size = p["effects.soft_spot.size"]
    taper = 1.0 + p["effects.stiffness_taper"] * (2.0 * place - 1.0)
    profile = taper / (1.0 + (last - first) / share * size / (1.0 - size))
    return {**p, **{key: p[key] * profile for key in ("beam.EA", "beam.GA", "beam.EI")}}
