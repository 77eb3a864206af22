"""One element of constant strains between two poses: its internal force less its dead load, and its tangent.

With the chord d = (x, z) from pose to pose, the mean angle m and the turn phi, and pairs (x, z) read as x + i z, the
logarithm of SE(2) is

    h gamma = d e^(i m) u,   h kappa = phi,   u = (phi / 2) / sin(phi / 2)

and the arc's centroid lies at d (1/2 + i v) from the first pose, v = 1 / phi - cot(phi / 2) / 2. Of the two,
u' = u v and v' = (u^2 - 1) / phi^2, so everything below is written in u and v.
"""

import math

import numpy as np

from ..._jit import kernel, step_kernel
from ...layout import L_GRAVITY, S_INV_H, S_LOAD_X, S_LOAD_Z, S_WEIGHT
from ...trig import sincos
from ..section import section_law

__all__ = ["apply_step", "element", "element_residual", "sizes"]

# below this turn [rad] v is its series, of which the term of phi^(2n - 1) has the factor 2 zeta(2n) / (2 pi)^(2n);
# what is left of zeta after 29 terms is below rounding from n = 7 on
NEAR = 1.0
SERIES = (
    *(1 / 12, 1 / 720, 1 / 30240, 1 / 1209600, 1 / 47900160, 691 / 1307674368000),
    *(2.0 * sum((2.0 * math.pi * k) ** (-2 * n) for k in range(1, 30)) for n in range(7, 14)),
)


@kernel
def sizes(tables):
    """Return how many Gauss points and nodes an element has."""
    return tables.points.shape[0], 2


@step_kernel
def _arc(phi):
    """Return u, v, v' and v'' of a turn, to rounding for |phi| < 6; real or complex."""
    if abs(phi.real) < NEAR:
        square = phi * phi
        v, dv, ddv = square * 0.0, square * 0.0, square * 0.0
        for n in range(len(SERIES) - 1, -1, -1):
            v = v * square + SERIES[n]
            dv = dv * square + (2 * n + 1) * SERIES[n]
        for n in range(len(SERIES) - 1, 0, -1):
            ddv = ddv * square + (2 * n + 1) * (2 * n) * SERIES[n]
        return np.sqrt(1.0 + square * dv), phi * v, dv, phi * ddv
    s, c = sincos(0.5 * phi)
    u = 0.5 * phi / s
    return u, 1.0 / phi - 0.5 * c / s, (u * u - 1.0) / (phi * phi), (2.0 - 2.0 * u * u * u * c) / (phi * phi * phi)


@step_kernel
def _strains(q):
    """Chord, its mean frame, turn and what `_arc` makes of it, and the element length times stretch and shear."""
    dx, dz, phi = q[3] - q[0], q[4] - q[1], q[5] - q[2]
    s, c = sincos(0.5 * (q[2] + q[5]))
    u, v, dv, ddv = _arc(phi)
    return dx, dz, s, c, phi, u, v, dv, ddv, u * (dx * c - dz * s), u * (dx * s + dz * c)


@step_kernel
def _forces(stations, loads, g_x, g_z, phi):
    """Means of the contact force and couple over the element, their derivatives by g_x, g_z, phi, and its dead load."""
    N, Q, M = g_x * 0.0, g_x * 0.0, g_x * 0.0
    N_x, N_z, N_k, Q_z, Q_k, M_k = g_x * 0.0, g_x * 0.0, g_x * 0.0, g_x * 0.0, g_x * 0.0, g_x * 0.0
    load_x, load_z = g_x * 0.0, g_x * 0.0
    for g in range(stations.shape[0]):
        station = stations[g]
        inv_h, w = station[S_INV_H], station[S_WEIGHT]
        share = w * inv_h
        n, t, m, n_x, n_z, n_k, t_z, t_k, m_k = section_law(station, loads, inv_h * g_x, inv_h * g_z, inv_h * phi)
        N, Q, M = N + share * n, Q + share * t, M + share * m
        share *= inv_h
        N_x, N_z, N_k = N_x + share * n_x, N_z + share * n_z, N_k + share * n_k
        Q_z, Q_k, M_k = Q_z + share * t_z, Q_k + share * t_k, M_k + share * m_k
        load_x, load_z = (
            load_x + w * loads[L_GRAVITY] * station[S_LOAD_X],
            load_z + w * loads[L_GRAVITY] * station[S_LOAD_Z],
        )
    return N, Q, M, N_x, N_z, N_k, Q_z, Q_k, M_k, load_x, load_z


@step_kernel
def _add_residual(f_x, f_z, turn, bend, load_x, load_z, res):
    """Add a residual by chord, mean angle and turn to that by the two poses."""
    res[0] -= f_x + load_x
    res[1] -= f_z + load_z
    res[2] += 0.5 * turn - bend
    res[3] += f_x
    res[4] += f_z
    res[5] += 0.5 * turn + bend


@kernel
def element_residual(tables, stations, loads, q, res):
    """Add one element's residual; real, or complex for the complex step. Arguments as in `element`."""
    dx, dz, s, c, phi, u, v, dv, _, g_x, g_z = _strains(q)
    N, Q, M, _, _, _, _, _, _, load_x, load_z = _forces(stations, loads, g_x, g_z, phi)
    f_x = u * (N * c + Q * s) - (0.5 * load_x + v * load_z)
    f_z = u * (Q * c - N * s) - (0.5 * load_z - v * load_x)
    bend = v * (N * g_x + Q * g_z) + M - dv * (load_z * dx - load_x * dz)
    _add_residual(f_x, f_z, Q * g_x - N * g_z, bend, load_x, load_z, res)


@kernel
def element(tables, stations, loads, q, res, K, room):
    """Add one element's residual and tangent: gradient and second derivatives of the energy of `reference.se2`.

    The dead load of the element is spread evenly over it.

    tables : `families.Se2Tables`
    stations : (n_gauss, N_STATION) the element's Gauss points
    loads : (N_LOADS,), of which the section takes guided tendons and the share of the dead load
    q : (6,)                        both poses [m, m, rad]
    res : (6,), K : (6, 6)          added to; of K only the lower triangle
    room : not used
    """
    dx, dz, s, c, phi, u, v, dv, ddv, g_x, g_z = _strains(q)
    N, Q, M, N_x, N_z, N_k, Q_z, Q_k, M_k, load_x, load_z = _forces(stations, loads, g_x, g_z, phi)
    n_x, n_z = u * (N * c + Q * s), u * (Q * c - N * s)
    f_x, f_z = n_x - (0.5 * load_x + v * load_z), n_z - (0.5 * load_z - v * load_x)
    along, turn, moment = N * g_x + Q * g_z, Q * g_x - N * g_z, load_z * dx - load_x * dz
    _add_residual(f_x, f_z, turn, v * along + M - dv * moment, load_x, load_z, res)

    # second derivatives by chord (x, z), mean angle (m) and turn (k)
    square, cross = u * u, 2.0 * s * c * N_z
    xx, zz = square * (c * c * N_x + s * s * Q_z + cross), square * (s * s * N_x + c * c * Q_z - cross)
    xz = square * (s * c * (Q_z - N_x) + (c * c - s * s) * N_z)
    # the force's derivative by the turn, in the mean frame
    bend_x, bend_z = v * (g_x * N_x + g_z * N_z) + N_k, v * (g_x * N_z + g_z * Q_z) + Q_k
    xm = u * (s * g_x * Q_z - c * g_z * N_x + (c * g_x - s * g_z) * N_z) + n_z
    zm = u * (s * g_z * N_x + c * g_x * Q_z - (s * g_x + c * g_z) * N_z) - n_x
    xk = u * (c * bend_x + s * bend_z) + v * n_x - dv * load_z
    zk = u * (c * bend_z - s * bend_x) + v * n_z + dv * load_x
    mm = g_z * g_z * N_x + g_x * g_x * Q_z - 2.0 * g_x * g_z * N_z - along
    mk = g_x * bend_z - g_z * bend_x + v * turn
    kk = v * (g_x * (bend_x + N_k) + g_z * (bend_z + Q_k)) + M_k + (v * v + dv) * along - ddv * moment
    _expand(xx, xz, zz, xm, zm, xk, zk, mm, mk, kk, K)


@step_kernel
def _expand(xx, xz, zz, xm, zm, xk, zk, mm, mk, kk, K):
    """Add a tangent by chord, mean angle and turn to that by the two poses."""
    first_x, first_z, last_x, last_z = 0.5 * xm - xk, 0.5 * zm - zk, 0.5 * xm + xk, 0.5 * zm + zk
    K[0, 0] += xx
    K[1, 0] += xz
    K[1, 1] += zz
    K[2, 0] -= first_x
    K[2, 1] -= first_z
    K[2, 2] += 0.25 * mm - mk + kk
    K[3, 0] -= xx
    K[3, 1] -= xz
    K[3, 2] += first_x
    K[3, 3] += xx
    K[4, 0] -= xz
    K[4, 1] -= zz
    K[4, 2] += first_z
    K[4, 3] += xz
    K[4, 4] += zz
    K[5, 0] -= last_x
    K[5, 1] -= last_z
    K[5, 2] += 0.25 * mm - kk
    K[5, 3] += last_x
    K[5, 4] += last_z
    K[5, 5] += 0.25 * mm + mk + kk


@kernel
def apply_step(tables, q, step, fresh):
    """Move `q` by a step that is linear in the strains and the angles, see `elements.lagrange`."""
    for i in range(3):
        fresh[i] = q[i] + step[i]
    for first in range(0, q.shape[0] - 3, 3):
        last = first + 3
        _, _, s, c, phi, u, v, _, _, g_x, g_z = _strains(q[first : first + 6])
        step_x, step_z = step[last] - step[first], step[last + 1] - step[first + 1]
        turn, bend = 0.5 * (step[first + 2] + step[last + 2]), step[last + 2] - step[first + 2]
        new_x = g_x + u * (step_x * c - step_z * s) - g_z * turn + v * bend * g_x
        new_z = g_z + u * (step_x * s + step_z * c) + g_x * turn + v * bend * g_z
        fresh[last + 2] = q[last + 2] + step[last + 2]
        s, c = sincos(0.5 * (fresh[first + 2] + fresh[last + 2]))
        u, _, _, _ = _arc(phi + bend)
        fresh[last] = fresh[first] + (new_x * c + new_z * s) / u
        fresh[last + 1] = fresh[first + 1] + (new_z * c - new_x * s) / u
    q[:] = fresh
