"""The cross-section: from strains to contact force and couple, and their derivatives."""

from ._jit import kernel
from .layout import S_EA, S_EI, S_GA, S_HOOKE, S_KAPPA0, S_OFFSET

__all__ = ["axial_law", "section_law"]


@kernel
def axial_law(EA, hooke, stretch):
    """Axial force and its derivative by the stretch, [C1] of `reference.section`."""
    inv = 1.0 / stretch
    inv2 = inv * inv
    third = EA / 3.0
    force = EA * (stretch - 1.0) if hooke.real > 0.5 else third * (stretch - inv2)
    slope = EA if hooke.real > 0.5 else third * (1.0 + 2.0 * inv2 * inv)
    return force, slope


@kernel
def section_law(station, gamma_x, gamma_z, kappa):
    """Contact force and couple of one section, [C2] of `reference.section`.

    station : (N_STATION,)
    gamma_x, gamma_z, kappa : [-, -, 1/m]

    Returns N [N], Q [N], M [N m] and the derivatives dN/dgamma_x, dN/dkappa (= dM/dgamma_x), dM/dkappa; that of Q
    by gamma_z is GA.
    """
    offset = station[S_OFFSET]
    N, dN = axial_law(station[S_EA], station[S_HOOKE], gamma_x + offset * kappa)
    M = station[S_EI] * (kappa - station[S_KAPPA0]) + offset * N
    dN_dkappa = offset * dN
    return N, station[S_GA] * gamma_z, M, dN, dN_dkappa, station[S_EI] + offset * dN_dkappa
