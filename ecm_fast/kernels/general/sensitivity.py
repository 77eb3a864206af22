"""Derivatives of the tip pose by loads and parameters, from the factorized tangent.

Implicit function theorem: at an equilibrium K dq = -dR, so the tip pose's derivative is -W . dR with W = K^-1 of the
three tip rows: what all nodes do under a unit wrench at Q. W costs no solve, only a back-substitution. How the
residual R depends on a parameter is not written down: the same residual, compiled for complex numbers, gives it by
the complex step, exact to rounding. Only the section's three stiffnesses are written out, as virtual work, because
every fit needs them.
"""

from typing import Any

import numpy as np

from .._jit import by_first_type, kernel
from ..layout import (
    L_LAM_L,
    L_LAM_R,
    S_EA,
    S_INV_H,
    S_KAPPA0,
    S_OFFSET,
    S_WEIGHT,
    T_CLAMP_TILT,
    T_CLAMP_X,
    T_FURTHER,
    UNSTABLE,
)
from ..prepare import prepare
from ..trig import sincos
from .elements import lagrange
from .elements.dispatch import element_residual, kernels_for, sizes
from .front import back_substitute, band_of, newton_step, solve_spd3
from .pulleys import tendon_directions
from .section import section_law
from .tip import force_slopes, plate_turn, tip_wrench

__all__ = ["STEP", "pose_sensitivities", "prepare_complex", "reaction", "residual_change", "tip_derivatives"]

# of the complex step: no difference is taken, so it only has to be far below rounding
STEP = 1e-100


@kernel
def tip_derivatives(tables, stations, tip, loads, q, work, step, compliance, jacobian):
    """Derivative of the tip pose by a wrench at Q and by the tendon forces, at an equilibrium `q`.

    tables, stations, tip, loads, q, work, step : as in `front.newton_step`
    compliance : (3, 3)   overwritten: d(x, z, theta)/d(fx, fz, tau) [m/N, rad/N, ...]
    jacobian : (3, 2)     overwritten: d(x, z, theta)/d(lam_l, lam_r) = compliance P, P the coupling matrix (40)

    Returns the number of pivots that are not positive.
    """
    K = jacobian.reshape(6)  # its six places are free until the end
    not_positive, _ = newton_step(tables, stations, tip, loads, q, work, step, K)
    for i in range(3):
        for k in range(3):
            compliance[i, k] = 1.0 if i == k else 0.0
        solve_spd3(K, compliance[i])
    n = q.shape[0]
    x, z, theta = q[n - 3], q[n - 2], q[n - 1]
    if tip[T_FURTHER] != 0.0:
        theta = _through_joint(tip, loads, x, z, theta, work, compliance)
    s, c = sincos(theta)
    e_lx, e_lz, _, e_rx, e_rz, _, l_x, l_z, r_x, r_z = tendon_directions(tip, x, z, s, c)
    tau_l, tau_r = l_z * e_lx - l_x * e_lz, r_z * e_rx - r_x * e_rz
    for i in range(3):
        jacobian[i, 0] = compliance[i, 0] * e_lx + compliance[i, 1] * e_lz + compliance[i, 2] * tau_l
        jacobian[i, 1] = compliance[i, 0] * e_rx + compliance[i, 1] * e_rz + compliance[i, 2] * tau_r
    force_slopes(tip, loads[L_LAM_L], loads[L_LAM_R], jacobian)
    return not_positive


@kernel
def _through_joint(tip, loads, x, z, theta, work, compliance):
    """Turn the compliance of the tip section into that of the head, which the plate's joint lets turn further.

    work : (12 or more,)   overwritten

    Returns the head's angle.
    """
    _, turned = tip_wrench(tip, loads, x, z, theta, work[9:12], work)
    by_x, by_z, by_theta, by_couple = plate_turn(tip, loads, x, z, turned, work)
    for i in range(3):  # the wrench acts on the head ...
        compliance[i, 2] = by_x * compliance[i, 0] + by_z * compliance[i, 1] + by_theta * compliance[i, 2]
    for k in range(3):  # ... whose pose is asked for
        compliance[2, k] = by_x * compliance[0, k] + by_z * compliance[1, k] + by_theta * compliance[2, k]
    compliance[2, 2] += by_couple
    return turned


@kernel
def _unit_responses(work, m, tip, compliance, turn, W):
    """Displacements of all nodes under a unit fx, fz, tau at Q, (3, n), after `tip_derivatives`.

    turn : what `plate_turn` returns, by which the tip section follows from the head
    """
    n = W.shape[1]
    band = band_of(work, m, n)
    by_x, by_z, by_theta, by_couple = turn
    for i in range(3):
        W[i] = 0.0
        x, z, theta = compliance[i, 0], compliance[i, 1], compliance[i, 2]
        if by_theta != 1.0:
            theta = (theta - (by_couple if i == 2 else 0.0) - by_x * x - by_z * z) / by_theta
        W[i, n - 3], W[i, n - 2], W[i, n - 1] = -x, -z, -theta
        back_substitute(band, m - 3, W[i], 3 if tip[T_FURTHER] == 0.0 else 0)


@kernel
def _lagrange_by_stiffness(basis, stations, loads, q, W, by_EA, by_GA, by_EI):
    """Pose by EA, GA and EI, (3,) each: minus the virtual work of what a stiffness of 1 adds to the contact force."""
    n_gauss, m = basis.shape[1], 3 * basis.shape[2]
    by_EA[:], by_GA[:], by_EI[:] = 0.0, 0.0, 0.0
    for i in range(stations.shape[0]):
        station, g = stations[i], i % n_gauss
        first = (m - 3) * (i // n_gauss)
        q_e, w, inv_h = q[first : first + m], station[S_WEIGHT], station[S_INV_H]
        dx, dz, theta, dtheta = 0.0, 0.0, 0.0, 0.0
        for a in range(m // 3):
            dx += basis[1, g, a] * q_e[3 * a]
            dz += basis[1, g, a] * q_e[3 * a + 1]
            theta += basis[0, g, a] * q_e[3 * a + 2]
            dtheta += basis[1, g, a] * q_e[3 * a + 2]
        s, c = sincos(theta)
        gamma_x, gamma_z, kappa = inv_h * (dx * c - dz * s), inv_h * (dx * s + dz * c), inv_h * dtheta
        N = section_law(station, loads, gamma_x, gamma_z, kappa)[0]
        for k in range(3):
            d_x, d_z, turn, bend = 0.0, 0.0, 0.0, 0.0
            for a in range(m // 3):
                d_x += basis[1, g, a] * W[k, first + 3 * a]
                d_z += basis[1, g, a] * W[k, first + 3 * a + 1]
                turn += basis[0, g, a] * W[k, first + 3 * a + 2]
                bend += inv_h * basis[1, g, a] * W[k, first + 3 * a + 2]
            d_gamma_x = inv_h * (d_x * c - d_z * s) - gamma_z * turn
            d_gamma_z = inv_h * (d_x * s + d_z * c) + gamma_x * turn
            by_EA[k] -= w * N / station[S_EA] * (d_gamma_x + station[S_OFFSET] * bend)
            by_GA[k] -= w * gamma_z * d_gamma_z
            by_EI[k] -= w * (kappa - station[S_KAPPA0]) * bend


@kernel
def _not_written_out(tables, stations, loads, q, W, by_EA, by_GA, by_EI):
    """Other families leave the stiffnesses to the complex step: this is never called."""


_by_stiffness: Any = by_first_type(
    lambda tables: _lagrange_by_stiffness if kernels_for(tables) is lagrange else _not_written_out
)


@kernel
def prepare_complex(par, which, mesh, nodes, stations, tip, q_rest):
    """Constants of a solve with an imaginary step in one parameter after the other.

    par : (n_parameters,) complex, its imaginary parts zero; which : (k,) places in it
    stations : (k, n_stations, N_STATION), tip : (k, N_TIP), q_rest : (k, 3 n_nodes)   complex, overwritten
    """
    for i in range(which.shape[0]):
        value = par[which[i]]
        par[which[i]] = complex(value.real, STEP)
        prepare(par, mesh, nodes, stations[i], tip[i], q_rest[i])
        par[which[i]] = value


@kernel
def _changes(constants):
    """Whether the imaginary step has reached any of these constants."""
    changed = False
    for i in range(constants.shape[0]):
        changed = changed or constants[i].imag != 0.0
    return changed


@kernel
def residual_change(tables, stations, tip, q_rest, loads, q, reaction, q_complex, res, K):
    """Derivative of the residual by the parameter in which `prepare_complex` stepped, into res.imag / STEP.

    reaction : (3,)   the beam's force and couple on its clamp

    Returns the head's angle, whose imaginary part tells how it depends on the parameter where the beam stands still.
    """
    n_gauss, n_a = sizes(tables)
    m, n = 3 * n_a, q.shape[0]
    for i in range(n):
        q_complex[i] = q[i]
        res[i] = 0.0
    for i in range(3):  # the clamped node goes where the parameter puts it
        if tip[T_CLAMP_X + i].real == 0.0:
            q_complex[i] = complex(q[i], q_rest[i].imag + tip[T_CLAMP_X + i].imag * reaction[i])
    if _changes(stations.reshape(stations.size)) or _changes(q_complex[:3]):
        for e in range(stations.shape[0] // n_gauss):
            first = e * (m - 3)
            points = stations[e * n_gauss : (e + 1) * n_gauss]
            element_residual(tables, points, loads, q_complex[first : first + m], res[first : first + m])
    for i in range(3):
        if tip[T_CLAMP_X + i].real > 0.0:
            rest = tip[T_CLAMP_TILT] if i == 2 else 0.0 * tip[T_CLAMP_TILT]
            res[i] += (q[i] - rest) / tip[T_CLAMP_X + i]
        else:
            res[i] = 0.0
    if not _changes(tip):
        return q_complex[n - 1]
    wrench = K[6:9]
    _, turned = tip_wrench(tip, loads, q_complex[n - 3], q_complex[n - 2], q_complex[n - 1], wrench, K)
    for i in range(3):
        res[n - 3 + i] -= wrench[i]
    return turned


@kernel
def reaction(tables, stations, loads, q, res):
    """Force and couple of the beam on its clamp, into the first three entries of `res`, (3 n_a or more,)."""
    n_gauss, n_a = sizes(tables)
    m = 3 * n_a
    res[:m] = 0.0
    element_residual(tables, stations[:n_gauss], loads, q[:m], res[:m])
    for i in range(3):
        res[i] = -res[i]


@kernel
def pose_sensitivities(
    tables, mesh, nodes, par, stiffness, which, loads, q, status, system, complex_system, pose, jacobian, compliance, by
):
    """Derivatives of many tip poses by tendon forces, wrench and parameters.

    tables, mesh, nodes : the discretization; par : (1 or n, n_parameters)
    stiffness : (3,)   columns of `by` for EA, GA, EI, or -1
    which : (k,)       places in the vector of the others, whose derivatives fill the first columns of `by`
    loads : (n, N_LOADS), q : (n, 3 n_nodes), status : (n,)   equilibria; where there is none, nan is left
    system : work arrays stations, tip, q_rest, work, step, W, and a spare (3, 3)
    complex_system : work arrays par, stations, tip, q_rest, q, res, K, see `prepare_complex`
    pose : (n, 3), jacobian : (n, 3, 2), compliance : (n, 3, 3), by : (n, 3, n_names)   overwritten
    """
    stations, tip, q_rest, work, step, W, spare = system
    c_par, c_stations, c_tip, c_q_rest, c_q, c_res, c_K = complex_system
    m = 3 * sizes(tables)[1]
    for i in range(loads.shape[0]):
        if i < par.shape[0]:
            prepare(par[i], mesh, nodes, stations, tip, q_rest)
            c_par[:] = par[i]
            prepare_complex(c_par, which, mesh, nodes, c_stations, c_tip, c_q_rest)
        if status[i] > UNSTABLE:
            pose[i], jacobian[i], compliance[i], by[i] = np.nan, np.nan, np.nan, np.nan
            continue
        tip_derivatives(tables, stations, tip, loads[i], q[i], work, step, compliance[i], jacobian[i])
        x, z, theta = q[i, q.shape[1] - 3], q[i, q.shape[1] - 2], q[i, q.shape[1] - 1]
        turn = 0.0, 0.0, 1.0, 0.0
        if tip[T_FURTHER] != 0.0:
            _, theta = tip_wrench(tip, loads[i], x, z, theta, work[6:9], work)
            turn = plate_turn(tip, loads[i], x, z, theta, work)
        pose[i, 0], pose[i, 1], pose[i, 2] = x, z, theta
        _unit_responses(work, m, tip, compliance[i], turn, W)
        reaction(tables, stations, loads[i], q[i], step)
        if stiffness[0] >= 0 or stiffness[1] >= 0 or stiffness[2] >= 0:
            _by_stiffness(tables, stations, loads[i], q[i], W, spare[0], spare[1], spare[2])
            for k in range(3):
                if stiffness[k] >= 0:
                    by[i, :, stiffness[k]] = spare[k]
        for k in range(which.shape[0]):
            c_system = c_stations[k], c_tip[k], c_q_rest[k]
            turned = residual_change(tables, *c_system, loads[i], q[i], step[:3], c_q, c_res, c_K)
            for row in range(3):
                total = turned.imag if row == 2 else 0.0
                for a in range(q.shape[1]):
                    total -= W[row, a] * c_res[a].imag
                by[i, row, k] = total / STEP
