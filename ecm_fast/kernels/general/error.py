"""Estimate of the discretization error: one Newton step on elements of half the length.

The solution, as a function along the beam, is a state of the finer mesh that is not yet in equilibrium there: its
angles are polynomials that the finer elements take over exactly, its strains are those at the Gauss points, and the
positions follow from both. One Newton step on the finer mesh then shows where its tip would go: the dual weighted
residual, with the finer mesh's tangent for the dual problem. Where it is not small a second one follows. What is left
after halving is at most as much again for elements of any order and for stiffnesses that jump inside an element, so the
change counts twice.
"""

import numpy as np

from .._jit import kernel
from ..layout import N_LOADS, S_INV_H, T_FURTHER, T_LENGTH, UNSTABLE
from ..prepare import prepare
from ..trig import sincos
from .elements.lagrange import apply_step
from .front import newton_step
from .newton import step_size
from .tip import tip_wrench

__all__ = ["tip_error", "tip_errors"]

# of the finer mesh's Newton step. Over 5e3 worlds of `bench/robustness/random_worlds.py` twice the step is above the
# error in 99.3 % to 99.6 % for orders 3 to 6, and below 30 times the error in 99.9 %
SAFETY = 2.0
# largest step, in rad and shares of the length, after which one is enough. Near a critical load what is left goes with
# its square, some hundred times: world 28129 of seed 90 takes 6e-5 along the beam, 1e-7 of it at the tip, 1.4e-6 with
# the second one
TRUSTED = 1e-5


@kernel
def _refine(tables, halves, stations, q, fine, strains):
    """Put the state `q` of a mesh onto the mesh of half elements.

    tables : (3, p, p + 1)            of both meshes, see `Discretization.tables`
    halves : (2, 2 p + 1, p + 1)      see `Discretization.halves`
    stations : (2 n_elements p, N_STATION)   Gauss points of the finer mesh
    q : (3 n_nodes,), fine : (3 n_fine_nodes,)   the latter overwritten
    strains : (p, 2)                  work space
    """
    p = tables.shape[1]
    fine[:3] = q[:3]
    for e in range(stations.shape[0] // (2 * p)):
        q_e = q[3 * p * e : 3 * p * (e + 1) + 3]
        length = 1.0 / stations[2 * p * e, S_INV_H]
        for g in range(p):
            dx, dz, theta = 0.0, 0.0, 0.0
            for a in range(p + 1):
                dx += tables[1, g, a] * q_e[3 * a]
                dz += tables[1, g, a] * q_e[3 * a + 1]
                theta += tables[0, g, a] * q_e[3 * a + 2]
            s, c = sincos(theta)
            strains[g, 0], strains[g, 1] = 0.5 * (dx * c - dz * s) / length, 0.5 * (dx * s + dz * c) / length
        for half in range(2):
            first = 3 * p * (2 * e + half)
            for a in range(1, p + 1):
                node, angle = first + 3 * a, 0.0
                for b in range(p + 1):
                    angle += halves[half, a, b] * q_e[3 * b + 2]
                fine[node], fine[node + 1], fine[node + 2] = fine[first], fine[first + 1], angle
            for g in range(p):
                gamma_x, gamma_z, theta = 0.0, 0.0, 0.0
                for k in range(p):
                    gamma_x += halves[half, p + 1 + g, k] * strains[k, 0]
                    gamma_z += halves[half, p + 1 + g, k] * strains[k, 1]
                for a in range(p + 1):
                    theta += tables[0, g, a] * fine[first + 3 * a + 2]
                s, c = sincos(theta)
                for a in range(1, p + 1):
                    lift = length * tables[2, g, a]
                    fine[first + 3 * a] += lift * (gamma_x * c + gamma_z * s)
                    fine[first + 3 * a + 1] += lift * (gamma_z * c - gamma_x * s)


@kernel
def tip_error(tables, halves, stations, tip, loads, q, fine, step, work):
    """Estimate the discretization error of the tip pose of an equilibrium `q`, in rad and shares of the length.

    tables, halves : see `_refine`
    stations : Gauss points of the finer mesh; tip, loads : as in `front.newton_step`
    q : (3 n_nodes,)   the equilibrium
    fine, step : (3 n_fine_nodes,), work : see `newton.solve_work_size`   work space of the finer mesh

    Returns the estimate; inf where there is none.
    """
    n, m = q.shape[0], fine.shape[0]
    strains = step[: 2 * tables.shape[1]].reshape(-1, 2)
    _refine(tables, halves, stations, q, fine, strains)
    newton_step(tables, stations, tip, loads, fine, work, step, work[work.shape[0] - 6 :])
    first = step_size(step, tip[T_LENGTH])
    apply_step(tables, fine, step, work[work.shape[0] - m :])
    if first > TRUSTED:
        newton_step(tables, stations, tip, loads, fine, work, step, work[work.shape[0] - 6 :])
        apply_step(tables, fine, step, work[work.shape[0] - m :])
    turned, moved = q[n - 1], fine[m - 1]
    if tip[T_FURTHER] != 0.0:
        _, turned = tip_wrench(tip, loads, q[n - 3], q[n - 2], turned, work[:3], work[3:9])
        _, moved = tip_wrench(tip, loads, fine[m - 3], fine[m - 2], moved, work[:3], work[3:9])
    along, across = abs(fine[m - 3] - q[n - 3]), abs(fine[m - 2] - q[n - 2])
    size = max(max(along, across) / tip[T_LENGTH], abs(moved - turned))
    return SAFETY * size if size < np.inf else np.inf


@kernel
def tip_errors(tables, halves, mesh, nodes, par, loads, q, status, system, error):
    """Estimate the errors of many equilibria, see `tip_error`.

    mesh, nodes : the finer discretization, see `Discretization`
    par : (1 or n, n_parameters), loads : (n, N_LOADS), q : (n, 3 n_nodes), status : (n,)
    system : work arrays of the finer mesh: stations, tip, q_rest, q, work
    error : (n,)   overwritten; nan where there is no equilibrium
    """
    stations, tip, q_rest, fine, work = system
    m = fine.shape[0]
    for i in range(loads.shape[0]):
        if i < par.shape[0]:
            prepare(par[i], mesh, nodes, stations, tip, q_rest)
        error[i] = np.nan
        if status[i] <= UNSTABLE:
            rest = work[2 * m + N_LOADS :]
            error[i] = tip_error(tables, halves, stations, tip, loads[i], q[i], fine, work[:m], rest)
