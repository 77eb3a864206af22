"""The camera's reading of the tip pose: the effects of `mechanism.catalogue.camera`, with derivatives."""

from ..mechanism.parameters import PLACES as P
from ._jit import kernel
from .trig import sincos

__all__ = ["read", "read_derivatives"]

# of the complex step, as in `sensitivity`
STEP = 1e-100


@kernel
def _reading(par, x, z, theta):
    """Reading of one pose, [V1] of `reference.camera`; real, or complex for the complex step."""
    s, c = sincos(theta)
    lever_x, lever_z = par[P.effects_marker_lever_x], par[P.effects_marker_lever_z]
    x, z = x + lever_x * c + lever_z * s, z + lever_z * c - lever_x * s
    lens = 1.0 + par[P.effects_lens_distortion] * (x * x + z * z)
    x, z = x * lens, z * lens
    keystone = 1.0 + par[P.effects_camera_keystone] * z
    x, z = x * keystone, z * keystone
    scale, uneven = 1.0 + par[P.effects_camera_scale], 0.5 * par[P.effects_camera_anisotropy]
    x, z = x * scale * (1.0 + uneven), z * scale * (1.0 - uneven)
    turn = par[P.effects_camera_rotation]
    s, c = sincos(turn)
    x, z = x * c + z * s, z * c - x * s
    x, z = x + par[P.effects_camera_x_offset], z + par[P.effects_camera_z_offset]
    return x, z, theta + turn + par[P.effects_marker_angle_offset]


@kernel
def read(par, pose):
    """Turn poses (n, 3) into readings; par : (1 or n, n_parameters)."""
    for i in range(pose.shape[0]):
        row = par[min(i, par.shape[0] - 1)]
        pose[i, 0], pose[i, 1], pose[i, 2] = _reading(row, pose[i, 0], pose[i, 1], pose[i, 2])


@kernel
def _turn(J, by, column):
    """Replace a column (3, ...) of pose derivatives by that of the readings."""
    x, z, theta = by[0, column], by[1, column], by[2, column]
    for row in range(3):
        by[row, column] = J[row, 0] * x + J[row, 1] * z + J[row, 2] * theta


@kernel
def read_derivatives(par, which, columns, c_par, J, pose, jacobian, compliance, by):
    """Turn poses into readings, and their derivatives with them.

    par : (1 or n, n_parameters); c_par : (n_parameters,) complex, J : (3, 3)   work space
    which : (m,)     places of the camera's parameters that are asked for; columns : (m,) where they are in `by`
    pose : (n, 3), jacobian : (n, 3, 2), compliance : (n, 3, 3), by : (n, 3, k)   overwritten
    """
    for i in range(pose.shape[0]):
        if i < par.shape[0]:
            c_par[:] = par[i]
        x, z, theta = complex(pose[i, 0]), complex(pose[i, 1]), complex(pose[i, 2])
        for k in range(3):
            step = complex(0.0, STEP)
            a, b, c = _reading(
                c_par, x + (step if k == 0 else 0.0), z + (step if k == 1 else 0.0), theta + (step if k == 2 else 0.0)
            )
            J[0, k], J[1, k], J[2, k] = a.imag / STEP, b.imag / STEP, c.imag / STEP
        for k in range(2):
            _turn(J, jacobian[i], k)
        for k in range(3):
            _turn(J, compliance[i], k)
        for k in range(by.shape[2]):
            _turn(J, by[i], k)
        for m in range(which.shape[0]):
            value = c_par[which[m]]
            c_par[which[m]] = complex(value.real, STEP)
            a, b, c = _reading(c_par, x, z, theta)
            c_par[which[m]] = value
            by[i, 0, columns[m]] += a.imag / STEP
            by[i, 1, columns[m]] += b.imag / STEP
            by[i, 2, columns[m]] += c.imag / STEP
        a, b, c = _reading(c_par, x, z, theta)
        pose[i, 0], pose[i, 1], pose[i, 2] = a.real, b.real, c.real
