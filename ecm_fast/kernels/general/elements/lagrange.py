"""One Lagrange element of any order: its internal force less its dead load, and its tangent."""

from ..._jit import copy, kernel, step_kernel
from ...layout import L_GRAVITY, S_INV_H, S_LOAD_X, S_LOAD_Z, S_WEIGHT
from ...trig import sincos
from ..section import section_law

__all__ = ["apply_step", "element", "element_residual", "section_at", "sizes"]


@kernel
def sizes(basis):
    """Return how many Gauss points and nodes an element has."""
    return basis.shape[1], basis.shape[2]


@step_kernel
def section_at(basis, station, loads, g, q):
    """Angle's sine and cosine, strains and section law at Gauss point `g`; arguments as in `element`."""
    dx, dz, theta, dtheta = q[0] * 0.0, q[0] * 0.0, q[0] * 0.0, q[0] * 0.0  # real or complex, as q is
    for a in range(basis.shape[2]):
        dx += basis[1, g, a] * q[3 * a]
        dz += basis[1, g, a] * q[3 * a + 1]
        theta += basis[0, g, a] * q[3 * a + 2]
        dtheta += basis[1, g, a] * q[3 * a + 2]
    inv_h = station[S_INV_H]
    s, c = sincos(theta)
    gamma_x, gamma_z, kappa = inv_h * (dx * c - dz * s), inv_h * (dx * s + dz * c), inv_h * dtheta
    return s, c, gamma_x, gamma_z, kappa, section_law(station, loads, gamma_x, gamma_z, kappa)


@kernel
def element_residual(basis, stations, loads, q, res):
    """Add one element's residual, [E1] of `reference.element`; real, or complex for the complex step.

    Arguments as in `element`.
    """
    for g in range(basis.shape[1]):
        station = stations[g]
        s, c, gamma_x, gamma_z, _, (N, Q, M, _, _, _, _, _, _) = section_at(basis, station, loads, g, q)
        w, inv_h = station[S_WEIGHT], station[S_INV_H]
        n_x, n_z = w * inv_h * (N * c + Q * s), w * inv_h * (Q * c - N * s)
        couple, M = w * (Q * gamma_x - N * gamma_z), w * inv_h * M
        load_x, load_z = w * loads[L_GRAVITY] * station[S_LOAD_X], w * loads[L_GRAVITY] * station[S_LOAD_Z]
        for a in range(basis.shape[2]):
            n, d = basis[0, g, a], basis[1, g, a]
            res[3 * a] += d * n_x - n * load_x
            res[3 * a + 1] += d * n_z - n * load_z
            res[3 * a + 2] += n * couple + d * M


@kernel
def element(basis, stations, loads, q, res, K, room):
    """Add one element's residual and tangent, [E1] and [E2] of `reference.element`.

    basis : (3, n_gauss, n_a)       shape functions and their derivatives by xi in [0, 1], at the Gauss points; a third
                                    table that only `apply_step` uses
    stations : (n_gauss, N_STATION) the element's Gauss points
    loads : (N_LOADS,), of which the section takes guided tendons and the share of the dead load
    q : (3 n_a,)                    the element's x, z, theta, node by node [m, m, rad]
    res : (3 n_a,), K : (3 n_a, 3 n_a)   added to; of K only the lower triangle
    room : not used
    """
    n_a = basis.shape[2]
    for g in range(basis.shape[1]):
        station = stations[g]
        s, c, gamma_x, gamma_z, _, law = section_at(basis, station, loads, g, q)
        N, Q, M, N_x, N_z, N_k, Q_z, Q_k, M_k = law
        inv_h, w = station[S_INV_H], station[S_WEIGHT]

        n_x, n_z = N * c + Q * s, Q * c - N * s
        res_theta = w * (Q * gamma_x - N * gamma_z)
        load_x, load_z = w * loads[L_GRAVITY] * station[S_LOAD_X], w * loads[L_GRAVITY] * station[S_LOAD_Z]

        # the energy's second derivatives by (x', z', theta, theta'), times the weight
        cross = 2.0 * s * c * N_z
        h_xx, h_zz = w * (c * c * N_x + s * s * Q_z + cross), w * (s * s * N_x + c * c * Q_z - cross)
        h_xz = w * (s * c * (Q_z - N_x) + (c * c - s * s) * N_z)
        h_xt = w * (s * Q_z * gamma_x - c * N_x * gamma_z + n_z + N_z * (c * gamma_x - s * gamma_z))
        h_zt = w * (c * Q_z * gamma_x + s * N_x * gamma_z - n_x - N_z * (s * gamma_x + c * gamma_z))
        h_tt = N_x * gamma_z * gamma_z + Q_z * gamma_x * gamma_x - N * gamma_x - Q * gamma_z
        h_tt = w * (h_tt - 2.0 * N_z * gamma_x * gamma_z)
        h_xk, h_zk = w * (c * N_k + s * Q_k), w * (c * Q_k - s * N_k)
        h_tk, h_kk = w * (gamma_x * Q_k - gamma_z * N_k), w * M_k

        for a in range(n_a):
            n, d = basis[0, g, a], inv_h * basis[1, g, a]
            i = 3 * a
            res[i] += w * d * n_x - n * load_x
            res[i + 1] += w * d * n_z - n * load_z
            res[i + 2] += n * res_theta + w * d * M
            r_xt, r_zt = n * h_xt + d * h_xk, n * h_zt + d * h_zk
            r_tt, r_tk = n * h_tt + d * h_tk, n * h_tk + d * h_kk
            for b in range(a + 1):
                n_b, d_b = basis[0, g, b], inv_h * basis[1, g, b]
                j = 3 * b
                K[i, j] += d * d_b * h_xx
                K[i + 1, j] += d * d_b * h_xz
                K[i, j + 1] += d * d_b * h_xz
                K[i + 1, j + 1] += d * d_b * h_zz
                K[i + 2, j] += d_b * r_xt
                K[i + 2, j + 1] += d_b * r_zt
                K[i, j + 2] += d * (n_b * h_xt + d_b * h_xk)
                K[i + 1, j + 2] += d * (n_b * h_zt + d_b * h_zk)
                K[i + 2, j + 2] += n_b * r_tt + d_b * r_tk


@kernel
def apply_step(basis, q, step, fresh):
    """Move `q` by a step that is linear in the strains and the angles, not in the positions.

    basis : (3, n_gauss, n_a), q : (3 n_nodes,), step : (3 n_nodes,)
    fresh : (3 n_nodes,)   work space

    A turn of the sections at fixed slopes would stretch the beam by half its square, and a stiff EA would answer
    with a force that throws Newton off. So angles and strains take the step, and the positions are rebuilt from
    them: the same to first order, and exact because the slopes at the Gauss points determine the positions. With
    more Gauss points than the order they do not; then the step is added as it is.
    """
    n_gauss, n_a = basis.shape[1], basis.shape[2]
    if basis[2, 0, n_a - 1] == 0.0:
        for i in range(q.shape[0]):
            q[i] += step[i]
        return
    for i in range(3):
        fresh[i] = q[i] + step[i]
    for first in range(0, q.shape[0] - 3, 3 * (n_a - 1)):
        for i in range(first + 3, first + 3 * n_a, 3):
            fresh[i], fresh[i + 1], fresh[i + 2] = fresh[first], fresh[first + 1], q[i + 2] + step[i + 2]
        for g in range(n_gauss):
            dx, dz, theta, step_x, step_z, turn = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for a in range(n_a):
                i = first + 3 * a
                dx += basis[1, g, a] * q[i]
                dz += basis[1, g, a] * q[i + 1]
                theta += basis[0, g, a] * q[i + 2]
                step_x += basis[1, g, a] * step[i]
                step_z += basis[1, g, a] * step[i + 1]
                turn += basis[0, g, a] * step[i + 2]
            s, c = sincos(theta)
            gamma_x, gamma_z = dx * c - dz * s, dx * s + dz * c
            new_x = gamma_x + step_x * c - step_z * s - gamma_z * turn
            new_z = gamma_z + step_x * s + step_z * c + gamma_x * turn
            s, c = sincos(theta + turn)
            for a in range(1, n_a):
                fresh[first + 3 * a] += basis[2, g, a] * (new_x * c + new_z * s)
                fresh[first + 3 * a + 1] += basis[2, g, a] * (new_z * c - new_x * s)
    copy(fresh, q)
