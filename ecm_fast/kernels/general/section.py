"""The cross-section: contact force and couple as functions of the strains, with derivatives."""

import numpy as np

from .._jit import kernel
from ..layout import (
    L_GRAVITY,
    L_PRESTRAIN,
    N_GUIDE,
    S_AMPLITUDE,
    S_BIMODULUS,
    S_CUBIC,
    S_EA,
    S_EI,
    S_FURTHER,
    S_GA,
    S_GUIDE,
    S_GUIDES,
    S_HOOKE,
    S_KAPPA0,
    S_LAW,
    S_MOONEY,
    S_NEO_HOOKEAN,
    S_OFFSET,
    S_OGDEN,
    S_ONE_SIDED,
    S_PLACE,
    S_SHEAR_COMPRESSION,
    S_SHEAR_CUBIC,
    S_USER,
)
from ..user_laws import added

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
def section_law(station, loads, gamma_x, gamma_z, kappa):
    """Contact force and couple of one section, [C2] of `reference.section`, with what guided tendons add, [B4].

    station : (N_STATION,), loads : (N_LOADS,)
    gamma_x, gamma_z, kappa : [-, -, 1/m]

    Returns N [N], Q [N], M [N m] and their derivatives, which are symmetric: N by gamma_x, gamma_z, kappa, Q by gamma_z
    and kappa, M by kappa.
    """
    law = _rod_law(station, loads[L_PRESTRAIN], gamma_x, gamma_z, kappa)
    return law if station[S_GUIDES] == 0.0 else _with_guides(station, loads, gamma_x, gamma_z, kappa, law)


@kernel
def _with_guides(station, loads, gamma_x, gamma_z, kappa, law):
    """Add the tendons that guides hold at the section: tension times the stretch |t| of their paths is their energy."""
    N, Q, M, N_x, N_z, N_k, Q_z, Q_k, M_k = law
    for i in range(int(station[S_GUIDES].real)):
        guide = station[S_GUIDE + N_GUIDE * i : S_GUIDE + N_GUIDE * (i + 1)]
        tension = loads[int(guide[0].real)] * guide[3] + loads[L_GRAVITY] * guide[4]
        o = guide[1]
        t_x, t_z = gamma_x + o * kappa, gamma_z + guide[2]
        inv = 1.0 / np.sqrt(t_x * t_x + t_z * t_z)
        e_x, e_z, pull = t_x * inv, t_z * inv, tension * inv
        N, Q, M = N + tension * e_x, Q + tension * e_z, M + tension * o * e_x
        xx, xz, zz = pull * e_z * e_z, -pull * e_x * e_z, pull * e_x * e_x
        N_x, N_z, N_k = N_x + xx, N_z + xz, N_k + o * xx
        Q_z, Q_k, M_k = Q_z + zz, Q_k + o * xz, M_k + o * o * xx
    return N, Q, M, N_x, N_z, N_k, Q_z, Q_k, M_k


@kernel
def _rod_law(station, prestrain, gamma_x, gamma_z, kappa):
    """Contact force and couple of the rod alone; `prestrain`: share of its curvature as built and the user's laws."""
    offset = station[S_OFFSET]
    g, u = gamma_x + offset * kappa, kappa - prestrain * station[S_KAPPA0]
    N, N_g = axial_law(station[S_EA], station[S_HOOKE], g)
    if station[S_FURTHER] == 0.0:
        Q, M = station[S_GA] * gamma_z, station[S_EI] * u + offset * N
        none, N_kappa = 0.0 * N_g, offset * N_g
        return N, Q, M, N_g, none, N_kappa, station[S_GA] + none, none, station[S_EI] + offset * N_kappa
    b, b_u = _bending(station, u)
    c, c_g = _axial(station, g)
    d_g, d_u, d_gg, d_gu, d_uu = _compressed(station, g, u)
    m_g, m_u, m_gg, m_gu, m_uu = _bimodular(station, g, u)
    Q, Q_z, Q_g, q_g, q_gg = _shear(station, g, gamma_z, N_g)
    Q, Q_z = Q + station[S_SHEAR_COMPRESSION] * N * gamma_z, Q_z + station[S_SHEAR_COMPRESSION] * N
    N, N_g, N_u = N + c + d_g + m_g + q_g, N_g + c_g + d_gg + m_gg + q_gg, d_gu + m_gu
    M, M_u = station[S_EI] * u + b + d_u + m_u, station[S_EI] + b_u + d_uu + m_uu
    N_kappa = offset * N_g + N_u
    M, Q_kappa, M_kappa = M + offset * N, offset * Q_g, M_u + offset * (N_u + N_kappa)
    if station[S_LAW] != 0.0:
        a = prestrain
        (n, q, m), by = added(gamma_x, gamma_z, kappa, station[S_LAW], station[S_USER:], station[S_PLACE])
        N, Q, M = N + a * n, Q + a * q, M + a * m
        N_g, Q_g, N_kappa = N_g + a * by[0], Q_g + a * by[1], N_kappa + a * by[2]
        Q_z, Q_kappa, M_kappa = Q_z + a * by[3], Q_kappa + a * by[4], M_kappa + a * by[5]
    return N, Q, M, N_g, Q_g, N_kappa, Q_z, Q_kappa, M_kappa


@kernel
def _bending(station, u):
    """Share of nonlinear bending laws in the couple, and its derivative by u, [C4] of `reference.section`."""
    size = u if u.real > 0.0 else -u
    cubic, amplitude, one_sided = station[S_CUBIC], station[S_AMPLITUDE], station[S_ONE_SIDED]
    further = u * (cubic * u * u + amplitude * size + one_sided * u)
    slope = 3.0 * cubic * u * u + 2.0 * (amplitude * size + one_sided * u)
    return station[S_EI] * further, station[S_EI] * slope


@kernel
def _axial(station, g):
    """Share of other axial laws in the axial force, and its derivative by g, [C5] of `reference.section`."""
    third, inv = station[S_EA] / 3.0, 1.0 / g
    inv2 = inv * inv
    plain, plain_g = g - inv2, 1.0 + 2.0 * inv2 * inv
    share = third * station[S_MOONEY]
    force, slope = share * plain * (inv - 1.0), share * (plain_g * (inv - 1.0) - plain * inv2)
    if station[S_OGDEN] != 0.0:
        m = 2.0 + station[S_OGDEN]
        log = np.log(g)
        up, down = np.exp((m - 1.0) * log), np.exp(-(0.5 * m + 1.0) * log)
        force += third * (2.0 / m * (up - down) - plain)
        slope += third * (2.0 / m * ((m - 1.0) * up + (0.5 * m + 1.0) * down) * inv - plain_g)
    return force, slope


@kernel
def _compressed(station, g, u):
    """Neo-Hookean law in every fibre: derivatives of the energy it adds by g, u, gg, gu, uu, [C6]."""
    size, inv = station[S_NEO_HOOKEAN] * station[S_EI], 1.0 / g
    inv3 = inv * inv * inv
    stiffer, inv4 = size * 2.0 / 3.0 * (inv3 - 1.0), size * inv3 * inv
    return -u * u * inv4, u * stiffer, 4.0 * u * u * inv4 * inv, -2.0 * u * inv4, stiffer


@kernel
def _bimodular(station, g, u):
    """Stiffer in tension: derivatives of the energy it adds by g, u, gg, gu, uu, [C7]."""
    h = np.sqrt(12.0 * station[S_EI] / station[S_EA])
    size = 0.5 * station[S_BIMODULUS] * station[S_EA] / h
    v, mean = u if u.real > 0.0 else -u, g - 1.0
    outer, inner = mean + 0.5 * h * v, mean - 0.5 * h * v
    if not outer.real > 0.0:
        return 0.0 * mean, 0.0 * mean, 0.0 * mean, 0.0 * mean, 0.0 * mean
    if inner.real >= 0.0:
        third = size * h * h * h / 6.0
        return 2.0 * size * h * mean, third * u, 2.0 * size * h + 0.0 * mean, 0.0 * mean, third + 0.0 * mean
    sign, by = 1.0 if u.real > 0.0 else -1.0, outer / v
    I_v = by * (0.5 * h * outer - outer * by / 3.0)
    I_vv = by * (0.5 * h * h - h * by + 2.0 / 3.0 * by * by)
    return size * outer * by, sign * size * I_v, 2.0 * size * by, sign * size * by * (h - by), size * I_vv


@kernel
def _shear(station, g, gamma_z, N_g):
    """Shear force but for its share of N; derivatives of Q by gamma_z and g; what N and its slope gain, [C8]."""
    size = station[S_SHEAR_COMPRESSION]
    cubic, gamma2 = station[S_SHEAR_CUBIC], gamma_z * gamma_z
    inv2 = 1.0 / (g * g)
    N_gg = 0.0 * g if station[S_HOOKE].real > 0.5 else -2.0 * station[S_EA] * inv2 * inv2
    Q, Q_z = station[S_GA] * gamma_z * (1.0 + cubic * gamma2), station[S_GA] * (1.0 + 3.0 * cubic * gamma2)
    return Q, Q_z, size * N_g * gamma_z, 0.5 * size * N_g * gamma2, 0.5 * size * N_gg * gamma2
