"""Elements of a chain with order above 1: the inner nodes are eliminated within the element.

Each element keeps a small dense matrix: rows and columns for its inner nodes, its left and its right end, then columns
for the residual and for the two components of the tip force. Only what lies on and right of the diagonal counts.
"""

from .._jit import kernel
from ..layout import (
    B_BEND,
    B_CURVED,
    B_UNIT,
    C_BASIS,
    E_COUPLING,
    E_LL,
    E_LR,
    E_RES,
    E_RES_L,
    E_RES_R,
    E_RIGHT,
    E_RR,
    E_X_L,
    E_X_R,
    E_Z_L,
    E_Z_R,
    G_ANGLE,
    G_NODE,
    G_RES,
    G_SLOPE,
    G_X,
    G_Z,
    H_DOUBT,
    H_NEGATIVE,
    H_XR,
    H_XX,
    H_XZ,
    H_ZR,
    H_ZZ,
    N_BEAM,
    N_ENDS,
    N_SAMPLES,
)

__all__ = ["SAFE", "angles", "assemble", "dense_size", "eliminate_inner", "recover"]

# a pivot below this share of what it was before the elimination has no sign to rely on
SAFE = 1e-6


def dense_size(order: int) -> int:
    """Return how many numbers an element's matrix has; none for linear elements, which have no inner nodes."""
    return (order + 1) * (order + 4) if order > 1 else 0


@kernel
def assemble(con, p, points, block, j, dense):
    """Fill one element's matrix from its Gauss points.

    con : constants; points, block : rows of constants and of the state, see `layout`
    p : order; j : column of the element
    dense : (p + 1, p + 4)   overwritten
    """
    dense[:] = 0.0
    derivative = C_BASIS + p * (p + 1)
    for g in range(p):
        row, samples = points[g * N_BEAM :], block[N_ENDS + g * N_SAMPLES :]
        bend = row[B_BEND + j]
        turn = con[derivative + g * (p + 1) + p] * block[E_RIGHT + j]
        for a in range(p):
            turn += con[derivative + g * (p + 1) + a] * block[N_ENDS + a * N_SAMPLES + G_NODE + j]
        couple = bend * turn - row[B_CURVED + j]
        for a in range(p + 1):
            i = a - 1 if 0 < a < p else p - 1 + a // p
            n, d = con[C_BASIS + g * (p + 1) + a], con[derivative + g * (p + 1) + a]
            dense[i, p + 1] += d * couple + n * samples[G_RES + j]
            dense[i, p + 2] += n * samples[G_X + j]
            dense[i, p + 3] += n * samples[G_Z + j]
            slope = n * samples[G_SLOPE + j]
            for b in range(p + 1):
                k = b - 1 if 0 < b < p else p - 1 + b // p
                if k >= i:
                    n_b, d_b = con[C_BASIS + g * (p + 1) + b], con[derivative + g * (p + 1) + b]
                    dense[i, k] += d * d_b * bend + slope * n_b


@kernel
def eliminate_inner(p, points, block, j, dense, head):
    """Eliminate the inner nodes of one element and hand what is left to its ends; arguments as for `assemble`.

    dense : rows of inner nodes overwritten with those of the factor
    head : numbers of negative and of doubtful pivots, and what the tip force's columns leave, added to
    """
    r, x, z = p + 1, p + 2, p + 3
    for i in range(p - 1):
        pivot = dense[i, i]
        inv = 1.0 / pivot
        head[H_NEGATIVE] += 1.0 if pivot < 0.0 else 0.0
        # all are stiffnesses of this element's angles, so they compare with its bending stiffness
        head[H_DOUBT] += 0.0 if abs(pivot) * points[B_UNIT + j] > SAFE else 1.0
        head[H_XX] += dense[i, x] * dense[i, x] * inv
        head[H_XZ] += dense[i, x] * dense[i, z] * inv
        head[H_ZZ] += dense[i, z] * dense[i, z] * inv
        head[H_XR] += dense[i, x] * dense[i, r] * inv
        head[H_ZR] += dense[i, z] * dense[i, r] * inv
        for k in range(i + 1, p + 1):
            factor = dense[i, k] * inv
            for c in range(k, p + 4):
                dense[k, c] -= factor * dense[i, c]
        for c in range(i + 1, p + 4):
            dense[i, c] *= inv
    unit = points[B_UNIT + j]
    block[E_LL + j], block[E_LR + j] = dense[p - 1, p - 1] * unit, dense[p - 1, p] * unit
    block[E_RR + j] = dense[p, p] * unit
    block[E_RES_L + j], block[E_RES_R + j] = dense[p - 1, r], dense[p, r]
    block[E_X_L + j], block[E_X_R + j] = dense[p - 1, x], dense[p, x]
    block[E_Z_L + j], block[E_Z_R + j] = dense[p - 1, z], dense[p, z]


@kernel
def recover(p, block, j, dense, step_x, step_z):
    """Turn the inner nodes of one element by what the steps of its ends and of the tip force ask.

    block : the ends' steps stand in rows `E_COUPLING` (left) and `E_RES` (right)
    dense : as `eliminate_inner` left it; the diagonal is overwritten with the steps
    step_x, step_z : of the tip force [N]

    Returns the largest squared step [rad^2].
    """
    largest = 0.0
    for i in range(p - 2, -1, -1):
        turned = -dense[i, p + 1] - dense[i, p + 2] * step_x - dense[i, p + 3] * step_z
        turned -= dense[i, p - 1] * block[E_COUPLING + j] + dense[i, p] * block[E_RES + j]
        for k in range(i + 1, p - 1):
            turned -= dense[i, k] * dense[k, k]
        dense[i, i] = turned
        block[N_ENDS + (i + 1) * N_SAMPLES + G_NODE + j] += turned
        largest = max(largest, turned * turned)
    return largest


@kernel
def angles(con, p, block, m):
    """Angles at the Gauss points of a block of `m` elements, from those at their nodes."""
    for g in range(p):
        first = N_ENDS + g * N_SAMPLES + G_ANGLE
        n = con[C_BASIS + g * (p + 1) + p]
        for j in range(m):
            block[first + j] = n * block[E_RIGHT + j]
        for a in range(p):
            n, node = con[C_BASIS + g * (p + 1) + a], N_ENDS + a * N_SAMPLES + G_NODE
            for j in range(m):
                block[first + j] += n * block[node + j]
