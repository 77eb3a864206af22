"""The sweeps along a chain of elements: elimination to the tip, the tip equations, back substitution.

Each step of a sweep waits for the one before, so what is on that path is kept short: one multiplication and addition.
"""

from .._jit import kernel, ordered_kernel
from ..layout import (
    B_RATIO,
    B_UNIT,
    C_BASIS,
    C_INV_FORCE2,
    C_INV_LENGTH2,
    COLUMNS,
    E_COUPLING,
    E_LL,
    E_LR,
    E_RES,
    E_RES_L,
    E_RES_R,
    E_RIGHT,
    E_RR,
    E_X,
    E_X_L,
    E_X_R,
    E_Z,
    E_Z_L,
    E_Z_R,
    G_NODE,
    H_CXX,
    H_CXZ,
    H_CZZ,
    H_DOUBT,
    H_DX,
    H_DZ,
    H_FORCE_X,
    H_FORCE_Z,
    H_NEGATIVE,
    H_STIFFNESS,
    H_THETA,
    H_WRENCH,
    H_X,
    H_XR,
    H_XX,
    H_XZ,
    H_Z,
    H_ZR,
    H_ZZ,
    N_BEAM,
    N_ENDS,
    N_HEAD,
    N_SAMPLES,
)
from .element import SAFE, angles, recover

__all__ = ["border", "eliminate", "turn_back"]


@ordered_kernel
def _less(a, b, c):
    """Difference a - b c, as it stands: in a recurrence the compiler must not move work between the steps."""
    return a - b * c


@kernel
def eliminate(con, state, p, n):
    """Eliminate the angles at all ends of elements, from the clamp up to the tip.

    Column j of a block keeps what the elimination of element j's left end leaves.

    Returns 1/pivot of the tip's angle [1/(N m)], its residual [N m] and its two entries of the tip force's columns [m].
    """
    xx, xz, zz, xr, zr = state[H_XX], state[H_XZ], state[H_ZZ], state[H_XR], state[H_ZR]
    first_point, first_block = C_BASIS + 2 * p * (p + 1), N_HEAD
    points, block = con[first_point : first_point + N_BEAM], state[first_block : first_block + N_ENDS]
    # leading minors: up to the node eliminated last, and the one before; the clamped node has a minor of 1
    minor, before, share = 1.0, 0.0, 1.0
    coupling, stiff, ratio, unit = 0.0, block[E_RR], points[B_RATIO], points[B_UNIT]
    factor, r, x, z = 0.0, 0.0, 0.0, 0.0
    r_right, x_right, z_right = block[E_RES_R], block[E_X_R], block[E_Z_R]
    block[E_COUPLING], block[E_RES], block[E_X], block[E_Z] = 0.0, 0.0, 0.0, 0.0
    negative, largest = 0, 0.0
    for first in range(0, n, COLUMNS):
        points, block = con[first_point : first_point + N_BEAM], state[first_block : first_block + N_ENDS]
        for j in range(1 if first == 0 else 0, min(COLUMNS, n - first)):
            new = _less((stiff * ratio + block[E_LL + j]) * minor, coupling * coupling * ratio, before)
            share = minor / new
            before, minor = minor, new
            negative += 1 if share < 0.0 else 0
            largest = abs(share) if abs(share) > largest else largest
            unit = points[B_UNIT + j]
            inv = unit * share
            r = _less(r_right + block[E_RES_L + j], factor, r)
            x = _less(x_right + block[E_X_L + j], factor, x)
            z = _less(z_right + block[E_Z_L + j], factor, z)
            u, v = x * inv, z * inv
            xx += x * u
            xz += x * v
            zz += z * v
            xr += r * u
            zr += r * v
            coupling = block[E_LR + j]
            factor = coupling * share
            block[E_COUPLING + j], block[E_RES + j], block[E_X + j], block[E_Z + j] = factor, r * inv, u, v
            stiff, ratio = block[E_RR + j], points[B_RATIO + j]
            r_right, x_right, z_right = block[E_RES_R + j], block[E_X_R + j], block[E_Z_R + j]
        first_point += p * N_BEAM
        first_block += N_ENDS + p * N_SAMPLES
    share = minor / _less((stiff + unit * state[H_STIFFNESS + 5]) * minor, coupling * coupling, before)
    negative += 1 if share < 0.0 else 0
    largest = max(largest, abs(share))
    inv = unit * share
    r = _less(r_right - state[H_WRENCH + 2], factor, r)
    x, z = _less(x_right, factor, x), _less(z_right, factor, z)
    u, v = x * inv, z * inv
    state[H_XX], state[H_XZ], state[H_ZZ] = xx + x * u, xz + x * v, zz + z * v
    state[H_XR], state[H_ZR] = xr + r * u, zr + r * v
    state[H_NEGATIVE] += negative
    state[H_DOUBT] += 0.0 if largest * SAFE < 1.0 else 1.0
    return inv, r, x, z


@kernel
def _inertia(a, b, c):
    """Negative eigenvalues of a symmetric 2 x 2 matrix, 1 where their number is in doubt, and its inverse."""
    det = a * c - b * b
    doubt = 0 if abs(det) > SAFE * abs(a * c) else 1
    negative = 1 if det < 0.0 else (2 if a < 0.0 else 0)
    inv = 1.0 / det
    return negative, doubt, c * inv, -b * inv, a * inv


@kernel
def border(con, state, inv, r, x, z):
    """Solve for the steps of tip force, tip position and tip angle, and take them.

    inv, r, x, z : what the elimination of the angles leaves at the tip, see `eliminate`

    Returns the step of the force [N, N] and of the angle [rad], and the squared size of all.
    """
    K = state[H_STIFFNESS:N_HEAD]
    h_x, h_z = K[3], K[4]
    # force: minus its block, with what the angles leave
    a, b, c = state[H_CXX] + state[H_XX], state[H_CXZ] + state[H_XZ], state[H_CZZ] + state[H_ZZ]
    negative, doubt, i_xx, i_xz, i_zz = _inertia(-a, -b, -c)
    gap_x = state[H_X] - state[H_DX] - state[H_XR]
    gap_z = state[H_Z] - state[H_DZ] - state[H_ZR]
    # position by force, then position: Schur complement of the force
    t_xx, t_xz = 1.0 - h_x * inv * x, -h_x * inv * z
    t_zx, t_zz = -h_z * inv * x, 1.0 - h_z * inv * z
    y_xx, y_xz = t_xx * i_xx + t_xz * i_xz, t_xx * i_xz + t_xz * i_zz
    y_zx, y_zz = t_zx * i_xx + t_zz * i_xz, t_zx * i_xz + t_zz * i_zz
    s_xx = K[0] - h_x * inv * h_x - (y_xx * t_xx + y_xz * t_xz)
    s_xz = K[1] - h_x * inv * h_z - (y_xx * t_zx + y_xz * t_zz)
    s_zz = K[2] - h_z * inv * h_z - (y_zx * t_zx + y_zz * t_zz)
    more, more_doubt, j_xx, j_xz, j_zz = _inertia(s_xx, s_xz, s_zz)
    e_x = state[H_FORCE_X] - state[H_WRENCH] - h_x * inv * r - (y_xx * gap_x + y_xz * gap_z)
    e_z = state[H_FORCE_Z] - state[H_WRENCH + 1] - h_z * inv * r - (y_zx * gap_x + y_zz * gap_z)
    move_x, move_z = -(j_xx * e_x + j_xz * e_z), -(j_xz * e_x + j_zz * e_z)
    e_x, e_z = gap_x + t_xx * move_x + t_zx * move_z, gap_z + t_xz * move_x + t_zz * move_z
    step_x, step_z = -(i_xx * e_x + i_xz * e_z), -(i_xz * e_x + i_zz * e_z)
    turned = -inv * (r + x * step_x + z * step_z + h_x * move_x + h_z * move_z)
    state[H_NEGATIVE] += negative + more
    state[H_DOUBT] += doubt + more_doubt
    state[H_X] += move_x
    state[H_Z] += move_z
    state[H_FORCE_X] += step_x
    state[H_FORCE_Z] += step_z
    state[H_THETA] += turned
    position = (move_x * move_x + move_z * move_z) * con[C_INV_LENGTH2]
    force = (step_x * step_x + step_z * step_z) * con[C_INV_FORCE2]
    return step_x, step_z, turned, position + force + turned * turned


@kernel
def turn_back(con, state, p, n, turned, step_x, step_z):
    """Turn all nodes, from the tip back to the clamp; returns the largest squared step [rad^2].

    turned : step of the tip's angle [rad]; step_x, step_z : of the tip force [N]
    """
    n_blocks = (n + COLUMNS - 1) // COLUMNS
    first_block = N_HEAD + n_blocks * (N_ENDS + p * N_SAMPLES)
    dense_at = first_block
    if p > 1:
        dense_at += n * (p + 1) * (p + 4)
    largest, right = 0.0, state[H_THETA]
    for k in range(n_blocks - 1, -1, -1):
        first_block -= N_ENDS + p * N_SAMPLES
        block = state[first_block : first_block + N_ENDS + p * N_SAMPLES]
        count = min(COLUMNS, n - k * COLUMNS)
        for j in range(count - 1, -1, -1):
            block[E_RIGHT + j] = right
            step_right = turned
            turned = _less(
                -block[E_RES + j] - block[E_X + j] * step_x - block[E_Z + j] * step_z, block[E_COUPLING + j], turned
            )
            right = block[N_ENDS + G_NODE + j] + turned
            block[N_ENDS + G_NODE + j] = right
            block[E_COUPLING + j], block[E_RES + j] = turned, step_right
            square = turned * turned
            largest = square if square > largest else largest
        if p > 1:
            for j in range(count - 1, -1, -1):
                dense_at -= (p + 1) * (p + 4)
                dense = state[dense_at : dense_at + (p + 1) * (p + 4)].reshape(p + 1, p + 4)
                largest = max(largest, recover(p, block, j, dense, step_x, step_z))
            angles(con, p, block, count)
    return largest
