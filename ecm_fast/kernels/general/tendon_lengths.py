"""Lengths of tendons and their derivatives, and the tip's pose by every tendon force, from the factorized tangent.

The energy of a tendon is its tension times its length, so the derivative of the length by the nodes is the load that
one newton of the tendon puts on them.
"""

import numpy as np

from .._jit import kernel
from ..layout import (
    L_LAM_3,
    N_CHORD,
    N_GUIDE,
    N_TENDONS,
    S_GUIDE,
    S_GUIDES,
    S_INV_H,
    S_WEIGHT,
    T_ATTACH_LX,
    T_CHORD,
    T_CHORDS,
    T_FURTHER,
    T_GAIN_L,
    T_LENGTH,
    T_PULLEY_LX,
    T_REACH_L,
)
from ..prepare import prepare
from ..trig import sincos
from .front import band_of, newton_step, solve_factored, solve_spd3
from .pulleys import chord, tendon
from .sensitivity import STEP, prepare_complex, reaction, residual_change

__all__ = ["node_derivatives", "tendon_derivatives", "tendon_lengths"]


@kernel
def _tendon_of(place):
    """The number of a tendon by the place of its force among the loads."""
    return place if place < 2 else place - L_LAM_3 + 2


@kernel
def _chord_length(pulley_x, attach_x, length, e_x, e_z, free, reach):
    """Free length and what is wrapped, [T1] of `reference.tip`; continuous to half a turn of the tendon's line."""
    side = 1.0 if pulley_x.real > length.real + attach_x.real else -1.0
    x, z = side * e_x.real, side * e_z.real
    # of a complex step the first order: e is a unit vector
    return free + reach * (np.arctan2(z, x) + x * side * (e_z - e_z.real) - z * side * (e_x - e_x.real))


@kernel
def tendon_lengths(basis, stations, tip, q, length, gradient, gain):
    """Length of every tendon and its derivative by the nodes.

    basis : of Lagrange elements, (3, n_gauss, n_a)
    stations, tip, q : as in `front.newton_step`
    length : (N_TENDONS,)              overwritten [m]; nan where there is no such tendon
    gradient : (N_TENDONS, 3 n_nodes)  overwritten
    gain : (N_TENDONS,)                overwritten: tendon force by reading [-]
    """
    n, n_gauss, n_a = q.shape[0], basis.shape[1], basis.shape[2]
    m = 3 * n_a
    length[:], gradient[:], gain[:] = np.nan, 0.0, 1.0
    for i in range(stations.shape[0]):
        station, g, first = stations[i], i % n_gauss, (m - 3) * (i // n_gauss)
        if station[S_GUIDES] == 0.0:
            continue
        dx, dz, theta, dtheta = 0.0, 0.0, 0.0, 0.0
        for a in range(n_a):
            dx += basis[1, g, a] * q[first + 3 * a]
            dz += basis[1, g, a] * q[first + 3 * a + 1]
            theta += basis[0, g, a] * q[first + 3 * a + 2]
            dtheta += basis[1, g, a] * q[first + 3 * a + 2]
        s, c = sincos(theta)
        w, inv_h = station[S_WEIGHT], station[S_INV_H]
        gamma_x, gamma_z, kappa = inv_h * (dx * c - dz * s), inv_h * (dx * s + dz * c), inv_h * dtheta
        for k in range(int(station[S_GUIDES].real)):
            guide = station[S_GUIDE + N_GUIDE * k : S_GUIDE + N_GUIDE * (k + 1)]
            t = _tendon_of(int(guide[0].real))
            t_x, t_z = gamma_x + guide[1] * kappa, gamma_z + guide[2]
            stretch = np.sqrt(t_x * t_x + t_z * t_z)
            e_x, e_z = t_x / stretch, t_z / stretch
            length[t] = w * stretch + (length[t] if length[t] == length[t] else 0.0)
            gain[t] = guide[3]
            n_x, n_z, couple = e_x * c + e_z * s, e_z * c - e_x * s, e_z * gamma_x - e_x * gamma_z
            for a in range(n_a):
                value, slope, j = w * basis[0, g, a], w * inv_h * basis[1, g, a], first + 3 * a
                gradient[t, j] += slope * n_x
                gradient[t, j + 1] += slope * n_z
                gradient[t, j + 2] += value * couple + slope * guide[1] * e_x
    x, z, theta = q[n - 3], q[n - 2], q[n - 1]
    s, c = sincos(theta)
    for i in range(2):
        if tip[T_GAIN_L + i] == 0.0:
            continue
        a_x, a_z = tip[T_ATTACH_LX + 2 * i], tip[T_ATTACH_LX + 2 * i + 1]
        p_x, p_z, reach = tip[T_PULLEY_LX + 2 * i], tip[T_PULLEY_LX + 2 * i + 1], tip[T_REACH_L + i]
        r_x, r_z = a_x * c + a_z * s, a_z * c - a_x * s
        e_x, e_z, free = tendon(p_x - x - r_x, p_z - z - r_z, reach)
        length[i] = _chord_length(p_x, a_x, tip[T_LENGTH], e_x, e_z, free, reach)
        gradient[i, n - 3], gradient[i, n - 2], gradient[i, n - 1] = -e_x, -e_z, r_x * e_z - r_z * e_x
        gain[i] = tip[T_GAIN_L + i]
    for i in range(int(tip[T_CHORDS].real)):
        anchors = tip[T_CHORD + N_CHORD * i : T_CHORD + N_CHORD * (i + 1)]
        t = _tendon_of(int(anchors[0].real))
        e_x, e_z, free, r_x, r_z = chord(tip, i, x, z, s, c)
        length[t] = _chord_length(anchors[3], anchors[1], tip[T_LENGTH], e_x, e_z, free, anchors[5])
        gradient[t, n - 3], gradient[t, n - 2], gradient[t, n - 1] = -e_x, -e_z, r_x * e_z - r_z * e_x
        gain[t] = anchors[6]


@kernel
def tendon_derivatives(basis, stations, tip, loads, q, work, step, length, gradient, gain, moved, compliance):
    """Lengths of tendons, and how every node moves by their forces, at an equilibrium `q`.

    basis, stations, tip, loads, q, work, step : as in `front.newton_step`
    length, gradient, gain : as in `tendon_lengths`
    moved : (N_TENDONS, 3 n_nodes)   overwritten: derivative of the nodes by tendon force [m/N, m/N, rad/N]
    compliance : (3, 3)              overwritten: tip pose by a dead wrench at Q

    Returns the number of pivots that are not positive.
    """
    n, m = q.shape[0], 3 * basis.shape[2]
    tendon_lengths(basis, stations, tip, q, length, gradient, gain)
    K = compliance.reshape(9)[:6]  # free until the end
    not_positive, _ = newton_step(basis, stations, tip, loads, q, work, step, K)
    band, clamped = band_of(work, m, n), 3 if tip[T_FURTHER] == 0.0 else 0
    for t in range(N_TENDONS):
        for i in range(n):
            moved[t, i] = -gradient[t, i]
        solve_factored(band, m - 3, K, moved[t], clamped)
    lower = work[work.shape[0] - 6 :]
    for i in range(6):
        lower[i] = K[i]
    for i in range(3):
        for j in range(3):
            compliance[i, j] = 1.0 if i == j else 0.0
        solve_spd3(lower, compliance[i])
    return not_positive


@kernel
def node_derivatives(
    basis, mesh, nodes, par, which, loads, q, system, complex_system, tendons, compliance, by_par, length_by_par
):
    """Derivatives of all nodes and of the lengths of tendons by tendon forces and parameters, at an equilibrium `q`.

    basis, mesh, nodes : the discretization, of Lagrange elements; par : (n_parameters,)
    which : (k,)                       places in the vector
    loads : (N_LOADS,), q : (3 n_nodes,)
    system : work arrays stations, tip, q_rest, work, step
    complex_system : work arrays par, stations, tip, q_rest, q, res, K, see `prepare_complex`; then length, gradient
        and gain as in `tendon_lengths`, all complex
    tendons : length, gradient, gain, moved, and compliance (3, 3)   overwritten, as in `tendon_derivatives`
    by_par : (k, 3 n_nodes)            overwritten: nodes by the parameters, forces held
    length_by_par : (k, N_TENDONS)     overwritten: lengths by the parameters, forces held
    """
    stations, tip, q_rest, work, step = system
    c_par, c_stations, c_tip, c_q_rest, c_q, c_res, c_K, c_length, c_gradient, c_gain = complex_system
    length, gradient, gain, moved = tendons
    n, m = q.shape[0], 3 * basis.shape[2]
    prepare(par, mesh, nodes, stations, tip, q_rest)
    c_par[:] = par
    prepare_complex(c_par, which, mesh, nodes, c_stations, c_tip, c_q_rest)
    tendon_derivatives(basis, stations, tip, loads, q, work, step, length, gradient, gain, moved, compliance)
    band, clamped, K = band_of(work, m, n), 3 if tip[T_FURTHER] == 0.0 else 0, work[work.shape[0] - 6 :]
    reaction(basis, stations, loads, q, step)
    for k in range(which.shape[0]):
        residual_change(basis, c_stations[k], c_tip[k], c_q_rest[k], loads, q, step[:3], c_q, c_res, c_K)
        for i in range(n):
            by_par[k, i] = -c_res[i].imag / STEP
        solve_factored(band, m - 3, K, by_par[k], clamped)
        for i in range(clamped):  # the clamped node goes where the parameter puts it
            by_par[k, i] = c_q_rest[k, i].imag / STEP
        tendon_lengths(basis, c_stations[k], c_tip[k], q, c_length, c_gradient, c_gain)
        for t in range(N_TENDONS):
            total = c_length[t].imag / STEP
            for i in range(n):
                total += gradient[t, i] * by_par[k, i]
            length_by_par[k, t] = total
