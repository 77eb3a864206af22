"""Constants of the chain of elements, derived from those of the finite element model."""

from .._jit import kernel
from ..condensed.axial_law import HALF
from ..condensed.formulation import plain_section, put_head
from ..layout import (
    B_BEND,
    B_BEYOND_X,
    B_BEYOND_Z,
    B_BY_N,
    B_BY_Q,
    B_CURVED,
    B_RATIO,
    B_SCALE,
    B_UNIT,
    B_WEIGHT,
    C_BASIS,
    C_COUNT,
    C_ORDER,
    COLUMNS,
    N_BEAM,
    S_EA,
    S_EI,
    S_GA,
    S_HOOKE,
    S_INV_H,
    S_KAPPA0,
    S_LOAD_X,
    S_LOAD_Z,
    S_WEIGHT,
    T_CHORDS,
    T_FURTHER,
)
from ..prepare import is_top_heavy

__all__ = ["condense_chain", "constants_size"]


def constants_size(n_elements: int, order: int) -> int:
    """Return how many constants a chain has."""
    blocks = -(-n_elements // COLUMNS)
    return C_BASIS + 2 * order * (order + 1) + blocks * order * N_BEAM


@kernel
def condense_chain(stations, tip, q_rest, basis, turn, stretch, con):
    """Constants of the chain, from those of the finite element model.

    stations : (n_elements * p, N_STATION), tip : (N_TIP,), q_rest : (3 n_nodes,)   see `prepare`
    basis : (2 or more, p, p + 1)   shape functions and their derivatives at the Gauss points
    turn : (p, p)   integrals of the polynomials that are 1 at one Gauss point up to each, for length 1 [-]
    stretch : see `stretch.stretch_polynomials`
    con : (constants_size,)   overwritten

    Returns whether the formulation applies, see `condensed.condense`, and the beam carries its own weight: a chain
    always starts straight.
    """
    p = basis.shape[1]
    n = stations.shape[0] // p
    con[:] = 0.0
    put_head(stations[0, S_HOOKE], tip, q_rest[2], stretch, con)
    con[C_ORDER], con[C_COUNT] = p, n
    i = C_BASIS
    for table in range(2):
        for g in range(p):
            for a in range(p + 1):
                con[i] = basis[table, g, a]
                i += 1
    next_compliance = 0.0
    load_x, load_z = 0.0, 0.0  # of all elements beyond
    applies = tip[T_FURTHER] == 0.0 and tip[T_CHORDS] == 0.0
    for e in range(n - 1, -1, -1):
        element = stations[e * p : (e + 1) * p]
        j = e % COLUMNS
        points = con[i + e // COLUMNS * p * N_BEAM : i + (e // COLUMNS + 1) * p * N_BEAM]
        compliance = 0.0
        for g in range(p):
            row, w, inv_h = element[g], element[g, S_WEIGHT], element[g, S_INV_H]
            applies = applies and plain_section(row) and row[S_HOOKE] == stations[0, S_HOOKE]
            beyond_x, beyond_z = load_x, load_z
            for k in range(p):
                share = element[k, S_WEIGHT] * turn[k, g] / (inv_h * w)
                beyond_x += share * element[k, S_LOAD_X]
                beyond_z += share * element[k, S_LOAD_Z]
            compliance += w / row[S_EI]
            point = points[g * N_BEAM + j :]
            point[B_WEIGHT], point[B_SCALE] = w, 1.0 / (row[S_EA] * HALF)
            point[B_BY_N], point[B_BY_Q] = 1.0 / row[S_EA], 1.0 / row[S_GA]
            point[B_BEYOND_X], point[B_BEYOND_Z] = beyond_x, beyond_z
            point[B_BEND] = w * row[S_EI] * inv_h * inv_h
            point[B_CURVED] = w * row[S_EI] * row[S_KAPPA0] * inv_h
        for k in range(p):
            load_x += element[k, S_WEIGHT] * element[k, S_LOAD_X]
            load_z += element[k, S_WEIGHT] * element[k, S_LOAD_Z]
        points[B_UNIT + j] = compliance
        points[B_RATIO + j] = next_compliance / compliance if e < n - 1 else 1.0
        next_compliance = compliance
    return applies and not is_top_heavy(stations, tip, q_rest[2])
