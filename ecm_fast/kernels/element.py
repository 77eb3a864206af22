"""One Lagrange element of any order: its internal force less its dead load, and its tangent."""

from ._jit import kernel, step_kernel
from .layout import S_INV_H, S_LOAD_X, S_LOAD_Z, S_WEIGHT
from .section import section_law
from .trig import sincos

__all__ = ["element", "element_residual"]


@step_kernel
def _section_at(basis, station, g, q):
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
    return s, c, gamma_x, gamma_z, kappa, section_law(station, gamma_x, gamma_z, kappa)


@kernel
def element_residual(basis, stations, gravity, q, res):
    """Add one element's residual, [E1] of `reference.element`; real, or complex for the complex step.

    Arguments as in `element`.
    """
    for g in range(basis.shape[1]):
        station = stations[g]
        s, c, gamma_x, gamma_z, _, (N, Q, M, _, _, _, _, _, _) = _section_at(basis, station, g, q)
        w, inv_h = station[S_WEIGHT], station[S_INV_H]
        n_x, n_z = w * inv_h * (N * c + Q * s), w * inv_h * (Q * c - N * s)
        couple, M = w * (Q * gamma_x - N * gamma_z), w * inv_h * M
        load_x, load_z = w * gravity * station[S_LOAD_X], w * gravity * station[S_LOAD_Z]
        for a in range(basis.shape[2]):
            n, d = basis[0, g, a], basis[1, g, a]
            res[3 * a] += d * n_x - n * load_x
            res[3 * a + 1] += d * n_z - n * load_z
            res[3 * a + 2] += n * couple + d * M


@kernel
def element(basis, stations, gravity, q, res, K):
    """Add one element's residual and tangent, [E1] and [E2] of `reference.element`.

    basis : (3, n_gauss, n_a)       shape functions and their derivatives by xi in [0, 1], at the Gauss points; a third
                                    table that only `newton.take` uses
    stations : (n_gauss, N_STATION) the element's Gauss points
    gravity : share of the dead load
    q : (3 n_a,)                    the element's x, z, theta, node by node [m, m, rad]
    res : (3 n_a,), K : (3 n_a, 3 n_a)   added to; of K only the lower triangle
    """
    n_a = basis.shape[2]
    for g in range(basis.shape[1]):
        station = stations[g]
        s, c, gamma_x, gamma_z, _, law = _section_at(basis, station, g, q)
        N, Q, M, N_x, N_z, N_k, Q_z, Q_k, M_k = law
        inv_h, w = station[S_INV_H], station[S_WEIGHT]

        n_x, n_z = N * c + Q * s, Q * c - N * s
        res_theta = w * (Q * gamma_x - N * gamma_z)
        load_x, load_z = w * gravity * station[S_LOAD_X], w * gravity * station[S_LOAD_Z]

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
