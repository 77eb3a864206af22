"""One Newton step: element assembly with immediate elimination of completed nodes (frontal method).

A front of one element's size walks from the clamp to the tip. Interior nodes meet only their own element, so this
is static condensation and band factorization in one; what is left at the end is the 3 x 3 tangent stiffness seen
at the tip. The factor is kept in band storage, 3 n_a - 1 entries below the diagonal.
"""

from .._jit import copy, kernel
from ..layout import T_CLAMP_TILT, T_CLAMP_X, T_FURTHER
from .elements.dispatch import element, sizes
from .tip import tip_wrench

__all__ = ["back_substitute", "band_of", "eliminate", "newton_step", "solve_factored", "solve_spd3", "work_size"]


def work_size(n_elements: int, order: int) -> int:
    """Return how many numbers `newton_step` needs as work space."""
    m = 3 * (order + 1)
    return m * m + m + n_elements * 3 * order * m + 6 * m


@kernel
def eliminate(front, first, last, res, band):
    """Factor columns `first` to `last` of a symmetric front into L D L^T, carrying the right-hand side along.

    front : (m, m)    lower triangle; overwritten, rows and columns from `last` on become the Schur complement
    res : (m,)        overwritten: entries before `last` become D^-1 L^-1 res, the others are reduced
    band : (last, m)  row j overwritten with column j of L below the diagonal, and with 1/D on it

    Returns the number of pivots that are not positive: by Sylvester's law of inertia the number of directions in
    which the energy falls, among those eliminated.
    """
    m = front.shape[0]
    not_positive = 0
    for j in range(first, last):
        pivot = front[j, j]
        if not pivot > 0.0:
            not_positive += 1
        inv = 1.0 / pivot
        for i in range(j + 1, m):
            band[j, i] = front[i, j]
        y = res[j]
        for i in range(j + 1, m):
            factor = band[j, i] * inv
            for k in range(j + 1, i + 1):
                front[i, k] -= factor * band[j, k]
            res[i] -= factor * y
        for i in range(j + 1, m):
            band[j, i] *= inv
        band[j, j] = inv
        res[j] = y * inv
    return not_positive


@kernel
def newton_step(tables, stations, tip, loads, q, work, step, K_tip):
    """Newton's step at `q`, [A1] of `reference.assembly`.

    tables : the elements' family and shape functions, see `mechanism.mesh.families`
    stations : (n_stations, N_STATION), tip : (N_TIP,), loads : (N_LOADS,)
    q : (3 n_nodes,)      all nodes, the clamped one first
    work : see `work_size`
    step : (3 n_nodes,)   overwritten
    K_tip : (6,)          overwritten: tangent stiffness seen at Q, lower triangle xx, zx, zz, tx, tz, tt

    Returns the number of pivots that are not positive and the free length of the shorter tendon.
    """
    n_gauss, n_a = sizes(tables)
    m = 3 * n_a
    width = m - 3  # unknowns that one element completes
    front, res = work[: m * m].reshape(m, m), work[m * m : m * m + m]
    band = band_of(work, m, q.shape[0])
    room = work[m * m + m + band.size : m * m + m + band.size + 6 * m]

    K_tip[:] = 0.0  # carries what earlier elements leave at the node they share with the next
    res[width:] = 0.0
    not_positive = 0
    first_row = 0
    for e in range(stations.shape[0] // n_gauss):
        _open_front(front, res, K_tip)
        points = stations[e * n_gauss : (e + 1) * n_gauss]
        element(tables, points, loads, q[first_row : first_row + m], res, front, room)
        clamped = 3 if e == 0 else 0
        if e == 0 and tip[T_FURTHER] != 0.0:
            clamped = 0
            _support(front, res, tip, q)
        not_positive += eliminate(front, clamped, width, res, band[first_row : first_row + width])
        copy(res[:width], step[first_row:])
        _read_lower(front, width, K_tip)
        first_row += width

    last = step[first_row:]
    # every element is done: the front's first row and the residual's head are free to hold the tip's
    free_length, _ = tip_wrench(tip, loads, q[first_row], q[first_row + 1], q[first_row + 2], res, front[0])
    for i in range(3):
        last[i] = res[width + i] - res[i]
    for i in range(6):
        K_tip[i] += front[0, i]
    not_positive += solve_spd3(K_tip, last)
    back_substitute(band, width, step, 3 if tip[T_FURTHER] == 0.0 else 0)
    return not_positive, free_length


@kernel
def _support(front, res, tip, q):
    """Add the clamp where it gives way, as springs on the first node; where it does not, hold that coordinate."""
    m = front.shape[0]
    for j in range(3):
        compliance = tip[T_CLAMP_X + j]
        if compliance > 0.0:
            rest = tip[T_CLAMP_TILT] if j == 2 else 0.0
            front[j, j] += 1.0 / compliance
            res[j] += (q[j] - rest) / compliance
        else:
            for k in range(j):
                front[j, k] = 0.0
            for i in range(j + 1, m):
                front[i, j] = 0.0
            front[j, j], res[j] = 1.0, 0.0


@kernel
def band_of(work, m, n):
    """Return the factor that `newton_step` leaves in its work space: (n - 3, m), m an element's unknowns, n all."""
    return work[m * m + m : m * m + m + (n - 3) * m].reshape(-1, m)


@kernel
def _open_front(front, res, carried):
    """Start an element's front with what the element before it left at their common node."""
    m = front.shape[0]
    for i in range(m):
        for k in range(i + 1):
            front[i, k] = 0.0
    front[0, 0], front[1, 0], front[1, 1] = carried[0], carried[1], carried[2]
    front[2, 0], front[2, 1], front[2, 2] = carried[3], carried[4], carried[5]
    for i in range(3):
        res[i] = res[m - 3 + i]
    for i in range(3, m):
        res[i] = 0.0


@kernel
def _read_lower(front, first, lower):
    """Copy the lower triangle of the 3 x 3 block that starts at `first`."""
    lower[0], lower[1], lower[2] = front[first, first], front[first + 1, first], front[first + 1, first + 1]
    lower[3], lower[4] = front[first + 2, first], front[first + 2, first + 1]
    lower[5] = front[first + 2, first + 2]


@kernel
def solve_spd3(lower, rhs):
    """Solve a symmetric 3 x 3 system in place; returns the number of pivots that are not positive.

    lower : (6,)   xx, zx, zz, tx, tz, tt
    rhs : (3,)     overwritten with the solution
    """
    d0 = lower[0]
    l10, l20 = lower[1] / d0, lower[3] / d0
    d1 = lower[2] - l10 * lower[1]
    b21 = lower[4] - l20 * lower[1]
    l21 = b21 / d1
    d2 = lower[5] - l20 * lower[3] - l21 * b21
    y1 = rhs[1] - l10 * rhs[0]
    y2 = rhs[2] - l20 * rhs[0] - l21 * y1
    rhs[2] = y2 / d2
    rhs[1] = y1 / d1 - l21 * rhs[2]
    rhs[0] = rhs[0] / d0 - l10 * rhs[1] - l20 * rhs[2]
    return (0 if d0 > 0.0 else 1) + (0 if d1 > 0.0 else 1) + (0 if d2 > 0.0 else 1)


@kernel
def solve_factored(band, width, K_tip, rhs, clamped):
    """Solve the factorized system of `newton_step` for another right-hand side, (n,), in place.

    band, K_tip : what that leaves; width : unknowns that one element completes; clamped : held entries at the start
    """
    n, m = rhs.shape[0], band.shape[1]
    rhs[:clamped] = 0.0
    for row in range(clamped, n - 3):
        local, y = row % width, rhs[row]
        first = row - local
        for i in range(local + 1, m):
            rhs[first + i] -= band[row, i] * y
        rhs[row] = y * band[row, local]
    solve_spd3(K_tip, rhs[n - 3 :])
    for i in range(n):  # which `back_substitute` turns round again
        rhs[i] = -rhs[i]
    back_substitute(band, width, rhs, clamped)


@kernel
def back_substitute(band, width, step, clamped):
    """Turn D^-1 L^-1 res into Newton's step: L^T step = -(what the elimination left), the first `clamped` held."""
    n = step.shape[0]
    m = band.shape[1]
    for i in range(n - 3, n):
        step[i] = -step[i]
    for row in range(n - 4, clamped - 1, -1):
        local = row % width
        total = -step[row]
        first = row - local
        for i in range(local + 1, m):
            total -= band[row, i] * step[first + i]
        step[row] = total
    step[:clamped] = 0.0
