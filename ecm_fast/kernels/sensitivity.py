"""Derivatives of the tip pose by the loads, from the factor that Newton's step leaves."""

from ._jit import kernel
from .front import newton_step, solve_spd3
from .tip import tendon_directions
from .trig import sincos

__all__ = ["tip_derivatives"]


@kernel
def tip_derivatives(basis, stations, tip, loads, q, work, step, compliance, jacobian):
    """Derivative of the tip pose by a wrench at Q and by the tendon forces, at an equilibrium `q`.

    basis, stations, tip, loads, q, work, step : as in `front.newton_step`
    compliance : (3, 3)   overwritten: d(x, z, theta)/d(fx, fz, tau) [m/N, rad/N, ...]
    jacobian : (3, 2)     overwritten: d(x, z, theta)/d(lam_l, lam_r) = compliance P, P the coupling matrix (40)

    Implicit function theorem: K dq = d(loads), and the stiffness seen at the tip is all of K that the tip needs.
    Returns the number of pivots that are not positive.
    """
    K = jacobian.reshape(6)  # its six places are free until the end
    not_positive, _ = newton_step(basis, stations, tip, loads, q, work, step, K)
    for i in range(3):
        for k in range(3):
            compliance[i, k] = 1.0 if i == k else 0.0
        solve_spd3(K, compliance[i])
    n = q.shape[0]
    s, c = sincos(q[n - 1])
    e_lx, e_lz, _, e_rx, e_rz, _, l_x, l_z, r_x, r_z = tendon_directions(tip, q[n - 3], q[n - 2], s, c)
    tau_l, tau_r = l_z * e_lx - l_x * e_lz, r_z * e_rx - r_x * e_rz
    for i in range(3):
        jacobian[i, 0] = compliance[i, 0] * e_lx + compliance[i, 1] * e_lz + compliance[i, 2] * tau_l
        jacobian[i, 1] = compliance[i, 0] * e_rx + compliance[i, 1] * e_rz + compliance[i, 2] * tau_r
    return not_positive
