"""One element whose strains are polynomials: its internal force less its dead load, and its tangent.

Pairs (x, z) are read as x + i z; the section's normal is then e^(-i theta). Between its ends r the element closes:

    r_last - r_first = sum over Gauss points of  w e^(-i theta) h gamma,    h gamma = mean + sum P_k G_k

The mean follows from that in closed form, so it is no unknown; the force that a tip-side neighbour must bear, its
Lagrange multiplier, follows just so. With it the residual is the gradient at a fixed mean, and the tangent the second
derivative with the mean's change put in.
"""

from ..._jit import kernel, step_kernel
from ...layout import L_GRAVITY, S_INV_H, S_LOAD_X, S_LOAD_Z, S_WEIGHT
from ...trig import sincos
from ..section import section_law

__all__ = ["apply_step", "element", "element_residual", "sizes"]


@kernel
def sizes(tables):
    """Return how many Gauss points and nodes an element has."""
    return tables.basis.shape[1], tables.basis.shape[2]


@step_kernel
def _section_at(tables, g, q):
    """Sine, cosine and slope of the angle at Gauss point `g`, and h gamma there less its mean."""
    theta, dtheta, i_x, i_z = q[0] * 0.0, q[0] * 0.0, q[0] * 0.0, q[0] * 0.0
    for a in range(tables.basis.shape[2]):
        theta += tables.basis[0, g, a] * q[3 * a + 2]
        dtheta += tables.basis[1, g, a] * q[3 * a + 2]
    for k in range(1, tables.modes.shape[1]):
        i_x += tables.modes[g, k] * q[3 * k]
        i_z += tables.modes[g, k] * q[3 * k + 1]
    s, c = sincos(theta)
    return s, c, dtheta, i_x, i_z


@step_kernel
def _mean(tables, q):
    """Mean of h gamma, and 1 over the mean of e^(-i theta)."""
    last = q.shape[0] - 3
    x, z = q[last] - q[0], q[last + 1] - q[1]
    real, imag = x * 0.0, x * 0.0
    for g in range(tables.weights.shape[0]):
        w = tables.weights[g]
        s, c, _, i_x, i_z = _section_at(tables, g, q)
        real, imag = real + w * c, imag + w * s
        x, z = x - w * (c * i_x + s * i_z), z - w * (c * i_z - s * i_x)
    square = real * real + imag * imag
    a, b = real / square, imag / square
    return x * a - z * b, x * b + z * a, a, b


@step_kernel
def _beyond(tables, stations, loads, g):
    """Dead load of the element between Gauss point `g` and its last node."""
    x, z = stations[g, S_LOAD_X] * 0.0, stations[g, S_LOAD_X] * 0.0
    for k in range(tables.beyond.shape[1]):
        share = tables.beyond[g, k] * loads[L_GRAVITY] / stations[k, S_INV_H]
        x += share * stations[k, S_LOAD_X]
        z += share * stations[k, S_LOAD_Z]
    return x, z


@step_kernel
def _end_force(tables, stations, loads, q, mean_x, mean_z, a, b):
    """Contact force at the last node: what makes the energy stationary in the mean of h gamma."""
    x, z = mean_x * 0.0, mean_x * 0.0
    for g in range(tables.weights.shape[0]):
        s, c, dtheta, i_x, i_z = _section_at(tables, g, q)
        inv_h, w = stations[g, S_INV_H], tables.weights[g]
        gamma_x, gamma_z = inv_h * (mean_x + i_x), inv_h * (mean_z + i_z)
        N, Q, _, _, _, _, _, _, _ = section_law(stations[g], loads, gamma_x, gamma_z, inv_h * dtheta)
        t_x, t_z = _beyond(tables, stations, loads, g)
        x += w * (N - (t_x * c - t_z * s))
        z += w * (Q - (t_x * s + t_z * c))
    return x * a + z * b, z * a - x * b


@step_kernel
def _add_at(tables, station, g, gamma, law, contact, res):
    """Add what one Gauss point gives to the residual, its ends' forces aside.

    gamma, law : stretch and shear, N, Q and M; contact : force that equilibrium asks for, in the section's axes
    """
    inv_h, w = station[S_INV_H], station[S_WEIGHT]
    N, Q, M = law
    couple = w * (contact[1] * gamma[0] - contact[0] * gamma[1])
    for a in range(tables.basis.shape[2]):
        res[3 * a + 2] += tables.basis[0, g, a] * couple + w * inv_h * tables.basis[1, g, a] * M
    for k in range(1, tables.modes.shape[1]):
        share = w * inv_h * tables.modes[g, k]
        res[3 * k] += share * (N - contact[0])
        res[3 * k + 1] += share * (Q - contact[1])


@step_kernel
def _add_ends(stations, loads, f_x, f_z, res):
    """Add the force at the last node, and at the first what balances it and the element's dead load."""
    last = res.shape[0] - 3
    res[last] += f_x
    res[last + 1] += f_z
    res[0] -= f_x
    res[1] -= f_z
    for g in range(stations.shape[0]):
        res[0] -= stations[g, S_WEIGHT] * loads[L_GRAVITY] * stations[g, S_LOAD_X]
        res[1] -= stations[g, S_WEIGHT] * loads[L_GRAVITY] * stations[g, S_LOAD_Z]


@kernel
def element_residual(tables, stations, loads, q, res):
    """Add one element's residual; real, or complex for the complex step. Arguments as in `element`."""
    mean_x, mean_z, a, b = _mean(tables, q)
    f_x, f_z = _end_force(tables, stations, loads, q, mean_x, mean_z, a, b)
    _add_ends(stations, loads, f_x, f_z, res)
    for g in range(stations.shape[0]):
        s, c, dtheta, i_x, i_z = _section_at(tables, g, q)
        inv_h = stations[g, S_INV_H]
        gamma_x, gamma_z = inv_h * (mean_x + i_x), inv_h * (mean_z + i_z)
        N, Q, M, _, _, _, _, _, _ = section_law(stations[g], loads, gamma_x, gamma_z, inv_h * dtheta)
        n_x, n_z = _beyond(tables, stations, loads, g)
        n_x, n_z = n_x + f_x, n_z + f_z
        contact = n_x * c - n_z * s, n_x * s + n_z * c
        _add_at(tables, stations[g], g, (gamma_x, gamma_z), (N, Q, M), contact, res)


@kernel
def element(tables, stations, loads, q, res, K, room):
    """Add one element's residual and tangent: gradient and second derivatives of the energy of `reference.strain`.

    tables : `families.StrainTables`
    stations : (n_gauss, N_STATION)   the element's Gauss points
    loads : (N_LOADS,), of which the section takes guided tendons and the share of the dead load
    q : (3 n_a,)                      poses at the ends; of inner nodes coefficients and angle, see `families._strain`
    res : (3 n_a,), K : (3 n_a, 3 n_a)   added to; of K only the lower triangle
    room : (18 n_a,)                  work space
    """
    m = q.shape[0]
    G, B = room[: 2 * m].reshape(2, m), room[2 * m : 6 * m].reshape(4, m)
    mean_x, mean_z, a, b = _mean(tables, q)
    f_x, f_z = _end_force(tables, stations, loads, q, mean_x, mean_z, a, b)
    _add_ends(stations, loads, f_x, f_z, res)
    _mean_by_unknowns(tables, q, mean_x, mean_z, a, b, G)
    for g in range(stations.shape[0]):
        s, c, dtheta, i_x, i_z = _section_at(tables, g, q)
        inv_h, w = stations[g, S_INV_H], stations[g, S_WEIGHT]
        gamma_x, gamma_z = inv_h * (mean_x + i_x), inv_h * (mean_z + i_z)
        law = section_law(stations[g], loads, gamma_x, gamma_z, inv_h * dtheta)
        N, Q, M, N_x, N_z, N_k, Q_z, Q_k, M_k = law
        n_x, n_z = _beyond(tables, stations, loads, g)
        n_x, n_z = n_x + f_x, n_z + f_z
        l_x, l_z = n_x * c - n_z * s, n_x * s + n_z * c
        _add_at(tables, stations[g], g, (gamma_x, gamma_z), (N, Q, M), (l_x, l_z), res)
        _changes_at(tables, g, inv_h, G, B)
        tt = l_x * gamma_x + l_z * gamma_z
        for i in range(m):
            d_x, d_z, turn, bend = w * B[0, i], w * B[1, i], w * B[2, i], w * B[3, i]
            h_x = N_x * d_x + N_z * d_z + N_k * bend + l_z * turn
            h_z = N_z * d_x + Q_z * d_z + Q_k * bend - l_x * turn
            h_t, h_k = l_z * d_x - l_x * d_z + tt * turn, N_k * d_x + Q_k * d_z + M_k * bend
            for k in range(i + 1):
                K[i, k] += h_x * B[0, k] + h_z * B[1, k] + h_t * B[2, k] + h_k * B[3, k]


@step_kernel
def _mean_by_unknowns(tables, q, mean_x, mean_z, a, b, G):
    """Derivatives of the mean of h gamma by the unknowns, (2, m): those of the closing, divided by e^(-i theta)'s."""
    m = q.shape[0]
    G[:] = 0.0
    G[0, 0], G[1, 1], G[0, m - 3], G[1, m - 2] = -1.0, -1.0, 1.0, 1.0
    for g in range(tables.weights.shape[0]):
        w = tables.weights[g]
        s, c, _, i_x, i_z = _section_at(tables, g, q)
        h_x, h_z = mean_x + i_x, mean_z + i_z
        y_x, y_z = w * (c * h_x + s * h_z), w * (c * h_z - s * h_x)
        for k in range(tables.basis.shape[2]):
            n = tables.basis[0, g, k]
            G[0, 3 * k + 2] -= n * y_z
            G[1, 3 * k + 2] += n * y_x
        for k in range(1, tables.modes.shape[1]):
            p = w * tables.modes[g, k]
            G[0, 3 * k] -= p * c
            G[1, 3 * k] += p * s
            G[0, 3 * k + 1] -= p * s
            G[1, 3 * k + 1] -= p * c
    for i in range(m):
        x, z = G[0, i], G[1, i]
        G[0, i], G[1, i] = x * a - z * b, x * b + z * a


@step_kernel
def _changes_at(tables, g, inv_h, G, B):
    """Derivatives of stretch, shear, angle and curvature at Gauss point `g` by the unknowns, (4, m)."""
    for i in range(G.shape[1]):
        B[0, i], B[1, i], B[2, i], B[3, i] = inv_h * G[0, i], inv_h * G[1, i], 0.0, 0.0
    for k in range(tables.basis.shape[2]):
        B[2, 3 * k + 2], B[3, 3 * k + 2] = tables.basis[0, g, k], inv_h * tables.basis[1, g, k]
    for k in range(1, tables.modes.shape[1]):
        B[0, 3 * k] += inv_h * tables.modes[g, k]
        B[1, 3 * k + 1] += inv_h * tables.modes[g, k]


@kernel
def apply_step(tables, q, step, fresh):
    """Move `q` by a step that is linear in the strains and the angles, see `elements.lagrange`."""
    m = 3 * tables.basis.shape[2]
    for i in range(3):
        fresh[i] = q[i] + step[i]
    for first in range(0, q.shape[0] - 3, m - 3):
        last = first + m - 3
        q_e, change, new = q[first : first + m], step[first : first + m], fresh[first : first + m]
        mean_x, mean_z, a, b = _mean(tables, q_e)
        d_x, d_z = step[last] - step[first], step[last + 1] - step[first + 1]
        for g in range(tables.weights.shape[0]):
            w = tables.weights[g]
            s, c, _, i_x, i_z = _section_at(tables, g, q_e)
            turn, p_x, p_z = _change_at(tables, g, change)
            p_x, p_z = p_x + (mean_z + i_z) * turn, p_z - (mean_x + i_x) * turn
            d_x, d_z = d_x - w * (c * p_x + s * p_z), d_z - w * (c * p_z - s * p_x)
        mean_x, mean_z = mean_x + d_x * a - d_z * b, mean_z + d_x * b + d_z * a
        for i in range(3, m):
            new[i] = q_e[i] + change[i]
        x, z = new[0], new[1]
        for g in range(tables.weights.shape[0]):
            w = tables.weights[g]
            s, c, _, i_x, i_z = _section_at(tables, g, new)
            x += w * (c * (mean_x + i_x) + s * (mean_z + i_z))
            z += w * (c * (mean_z + i_z) - s * (mean_x + i_x))
        new[m - 3], new[m - 2] = x, z
    q[:] = fresh


@step_kernel
def _change_at(tables, g, step):
    """Change of the angle at Gauss point `g`, and of h gamma there less its mean."""
    turn, p_x, p_z = 0.0, 0.0, 0.0
    for a in range(tables.basis.shape[2]):
        turn += tables.basis[0, g, a] * step[3 * a + 2]
    for k in range(1, tables.modes.shape[1]):
        p_x += tables.modes[g, k] * step[3 * k]
        p_z += tables.modes[g, k] * step[3 * k + 1]
    return turn, p_x, p_z
