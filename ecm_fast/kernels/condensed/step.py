"""The condensed path for every order: Newton's step, batches of load cases and of mechanisms, and the control step.

The order is the length of the tuple `points`, known while these are compiled; its entries mean nothing.
"""

import functools
import math
from typing import Any

import numpy as np

from .._jit import array_at, by_first_type, call_kernel, kernel, step_kernel, wide
from ..layout import (
    CONVERGED,
    LANES,
    NOT_CONVERGED,
    R_DOUBT,
    R_EXTREME,
    R_FX,
    R_FZ,
    R_LAM_L,
    R_LAM_R,
    R_TAU,
    R_THETA,
    R_X,
    R_Z,
)
from ..prepare import prepare
from ..unroll import at_each_point, function
from .equations import written_out
from .formulation import (
    MAX_STEPS,
    accepts,
    all_converged,
    condense,
    constants_size,
    nodes_of,
    put_load,
    read_results,
    reset_straight,
    state_size,
)
from .initial_guess import extrapolate, guess, lane_inside, lanes_inside, remember
from .physics import plate, section
from .step_memory import MOST_STEPS, general_step, hand_over, memory_size, pieces, pulls, symmetric_from_lower

__all__ = [
    "cold_solve",
    "control_step",
    "derivatives",
    "gauss_points",
    "solve_loads",
    "solve_mechanisms",
    "solve_nodes",
    "sweep",
    "sweep_mechanisms",
]


def gauss_points(order: int) -> tuple[int, ...]:
    """Return the tuple whose type stands for an order."""
    return (0,) * order


def _written_out(name: str) -> Any:
    return by_first_type(lambda points: written_out(len(points))[name], forceinline=True)


_assemble, _tangent, _solve = _written_out("assemble"), _written_out("tangent"), _written_out("solve")
_move, _tip_columns, _doubt = _written_out("move"), _written_out("tip_columns"), _written_out("doubt")
_sections = at_each_point(section)


# Many load cases, LANES at a time


@step_kernel
def _section_lanes(con, cr, own, state, g):
    for j in range(LANES):
        section(con, cr, own * j, state, LANES, j, g)


_sections_lanes = at_each_point(_section_lanes)


@step_kernel
def _sweep(points, con, cr, own, state):
    wide()
    # one loop after the other: each body fits the window in which a processor reorders instructions
    _sections_lanes(points, con, cr, own, state)
    for j in range(LANES):
        plate(con, cr, own * j, state, LANES, j)
    for j in range(LANES):
        _assemble(points, con, cr, own * j, state, LANES, j)
    for j in range(LANES):
        _tangent(points, con, cr, own * j, state, LANES, j)
    for j in range(LANES):
        _solve(points, con, cr, own * j, state, LANES, j, False)
    for j in range(LANES):
        _move(points, con, cr, own * j, state, LANES, j)


@kernel
def sweep(points, con, state):
    """Take one Newton step in every lane: many loads, one mechanism."""
    wide()
    _sweep(points, con, 1, 0, state)


@kernel
def sweep_mechanisms(points, con, state):
    """Take one Newton step in every lane, each with constants of its own: `con` holds lanes as `state` does."""
    wide()
    _sweep(points, con, LANES, 1, state)


@step_kernel
def _doubts(points, con, cr, own, state):
    wide()
    for j in range(LANES):
        _doubt(points, con, cr, own * j, state, LANES, j)


@kernel
def lane_doubts(points, con, state):
    """Bound the discretization error in every lane, after `sweep`: many loads, one mechanism."""
    wide()
    _doubts(points, con, 1, 0, state)


@kernel
def lane_doubts_mechanisms(points, con, state):
    """Bound the discretization error in every lane, after `sweep_mechanisms`."""
    wide()
    _doubts(points, con, LANES, 1, state)


@kernel
def solve_loads(points, con, coefficients, lam_max, lam, wrench, step_tol2, state, x, z, theta, status, doubt):
    """Solve load cases on one mechanism, LANES at a time.

    coefficients, lam_max : see `initial_guess.guess`, used where both tendon forces are at most `lam_max`; else, and
        for lam_max = 0 always, the beam starts straight
    lam : (n, 2), wrench : (n, 3) or (1, 3), step_tol2 : largest squared last step
    state : (LANES * state_size,)   work space
    x, z, theta, status : (n,)   overwritten; CONVERGED, or NOT_CONVERGED where the general path must decide
    doubt : (n,)   overwritten: a bound of the discretization error, see `equations.written_out`
    """
    order, n, last_wrench = len(points), lam.shape[0], wrench.shape[0] - 1
    for first in range(0, n, LANES):
        for j in range(LANES):
            i = min(first + j, n - 1)
            put_load(state, LANES, j, lam[i], wrench[min(i, last_wrench)])
        inside = lanes_inside(state, lam_max)
        if inside > 0:
            guess(coefficients, lam_max, state, LANES, LANES, order)
        if inside < LANES:
            for j in range(LANES):
                if not lane_inside(state, lam_max, j):
                    reset_straight(con, 1, 0, state, LANES, j, order)
        for _ in range(MAX_STEPS):
            sweep(points, con, state)
            if all_converged(state, step_tol2):
                break
        lane_doubts(points, con, state)
        end = min(first + LANES, n)
        own = x[first:end], z[first:end], theta[first:end], status[first:end], doubt[first:end]
        read_results(state, step_tol2, *own)


@kernel
def solve_mechanisms(
    points, par, mesh, nodes, turn, slopes, stretch, lam, wrench, step_tol2, system, con, lanes, state,
    x, z, theta, status, doubt,
):  # fmt: skip
    """Solve cases that each have a mechanism of their own, from the straight beam, LANES at a time.

    par : (n, n_parameters)
    mesh, nodes, turn, slopes, stretch : see `prepare` and `formulation.condense`
    system : work arrays of one thread: stations, tip, q_rest; con : (constants_size,), lanes : LANES times that
    the rest as in `solve_loads`
    """
    n, last_wrench = lam.shape[0], wrench.shape[0] - 1
    stations, tip, q_rest = system
    for first in range(0, n, LANES):
        for j in range(LANES):
            i = min(first + j, n - 1)
            prepare(par[i], mesh, nodes, stations, tip, q_rest)
            applies = condense(stations, tip, q_rest, turn, slopes, stretch, con)
            for k in range(con.shape[0]):
                lanes[LANES * k + j] = con[k]
            put_load(state, LANES, j, lam[i], wrench[min(i, last_wrench)])
            reset_straight(lanes, LANES, j, state, LANES, j, len(points))
            if not applies:
                state[LANES * R_EXTREME + j] = 2.0
        for _ in range(MAX_STEPS):
            sweep_mechanisms(points, lanes, state)
            if all_converged(state, step_tol2):
                break
        lane_doubts_mechanisms(points, lanes, state)
        end = min(first + LANES, n)
        own = x[first:end], z[first:end], theta[first:end], status[first:end], doubt[first:end]
        read_results(state, step_tol2, *own)


# One load case


@step_kernel
def _step(points, con, state, keep):
    """Take one Newton step for the one load case that `state` holds; with `keep`, leave the factor to `tip_columns`."""
    _sections(points, con, 1, 0, state, 1, 0)
    plate(con, 1, 0, state, 1, 0)
    _assemble(points, con, 1, 0, state, 1, 0)
    _tangent(points, con, 1, 0, state, 1, 0)
    _solve(points, con, 1, 0, state, 1, 0, keep)
    _move(points, con, 1, 0, state, 1, 0)


@kernel
def _iterate(points, con, state, step_tol2, keep):
    """Take Newton steps until the equilibrium is accepted; return their number, 0 where none did."""
    for i in range(MAX_STEPS):
        _step(points, con, state, keep)
        if accepts(state, 1, 0, step_tol2):
            return i + 1
    return 0


@kernel
def solve_nodes(
    points, par, mesh, nodes, turn, slopes, stretch, tables, lam, wrench, step_tol2, system, con, state, q, status
):
    """Solve cases one after the other, each from the straight beam, into their nodes.

    par : (1 or n, n_parameters)   one mechanism for all, or one for each
    tables : (3, p, p + 1); the other arguments as in `solve_mechanisms`, of one lane
    q : (n, 3 n_nodes), status : (n,)   overwritten; CONVERGED, or NOT_CONVERGED where the general path must decide
    """
    n, last_wrench = lam.shape[0], wrench.shape[0] - 1
    stations, tip, q_rest = system
    applies = False
    for i in range(n):
        if i < par.shape[0]:
            prepare(par[i], mesh, nodes, stations, tip, q_rest)
            applies = condense(stations, tip, q_rest, turn, slopes, stretch, con)
        put_load(state, 1, 0, lam[i], wrench[min(i, last_wrench)])
        reset_straight(con, 1, 0, state, 1, 0, len(points))
        found = _iterate(points, con, state, step_tol2, False) > 0 and applies
        status[i] = CONVERGED if found else NOT_CONVERGED
        nodes_of(con, state, tables, slopes, len(points), q[i])


@functools.cache
def cold_solve(order: int) -> Any:
    """Return the solve of one load case from the straight beam, a kernel; see `control_step` for its arguments.

    Arrays: the constants, the state, and the largest squared last step.
    """
    points = gauss_points(order)
    n_con, n_state = constants_size(order), state_size(order)

    @call_kernel
    def solve(address, lam_l, lam_r, f_x, f_z, tau):
        """Solve for two tendon forces and a dead wrench.

        Returns x, z, theta, a bound of the discretization error, and the number of Newton steps: 0 where the general
        path must decide.
        """
        memory = array_at(address, n_con + n_state + 1)
        con, state = memory[:n_con], memory[n_con : n_con + n_state]
        state[R_LAM_L], state[R_LAM_R] = lam_l, lam_r
        state[R_FX], state[R_FZ], state[R_TAU] = f_x, f_z, tau
        reset_straight(con, 1, 0, state, 1, 0, len(points))
        steps = _iterate(points, con, state, memory[n_con + n_state], False)
        _doubt(points, con, 1, 0, state, 1, 0)
        return state[R_X], state[R_Z], state[R_THETA], state[R_DOUBT], steps

    return solve


@kernel
def derivatives(points, con, state, compliance, jacobian):
    """Derivatives of the pose by a wrench, (3, 3), and by the tendon forces, (3, 2), from a solved case's state."""
    columns = np.empty(6)
    _step(points, con, state, True)
    _tip_columns(points, con, state, columns)
    symmetric_from_lower(con, state, columns, compliance, jacobian)


# The control step


@step_kernel
def _follow(points, con, coefficients, settings, state, before, followed, known, lam_l, lam_r):
    step_tol2, keep, lam_max = settings[0], settings[1] > 0.0, settings[2]
    followed[0] = 1.0
    if known:
        extrapolate(state, before, lam_l, lam_r, len(points))
        if _iterate(points, con, state, step_tol2, keep) > 0:
            return True
    state[R_LAM_L], state[R_LAM_R] = lam_l, lam_r
    if lam_l <= lam_max and lam_r <= lam_max and lam_max > 0.0:
        guess(coefficients, lam_max, state, 1, 1, len(points))
    else:
        reset_straight(con, 1, 0, state, 1, 0, len(points))
    if _iterate(points, con, state, step_tol2, keep) == 0:
        return False
    followed[0] = 0.0
    remember(state, before, len(points))
    return True


@functools.cache
def _parts_of(order: int) -> Any:
    cuts = []
    for first, shape in pieces(order).values():
        reshaped = f".reshape({shape})" if len(shape) > 1 else ""
        cuts.append(f"memory[{first}:{first + math.prod(shape)}]{reshaped}")
    return function("parts", ["points", "memory"], [f"return {', '.join(cuts)}"], {})


_parts = by_first_type(lambda points: _parts_of(len(points)), forceinline=True)


@functools.cache
def control_step(order: int) -> Any:
    """Return the control step of an order, a kernel.

    It takes an address and two forces: `points` would be unpacked at each call, which costs a tenth of a step. It
    keeps the interpreter's lock, so that calls from several threads follow one another.
    """
    points, size = gauss_points(order), memory_size(order)

    @call_kernel
    def advance(address, lam_l, lam_r):
        """Take a control step: to new tendon forces, from where the memory at `address` stands; see `control_step`.

        Returns x, z, theta, status.
        """
        (
            settings, con, state, followed, before, columns, jacobian, compliance, coefficients,
            loads, tables, slopes, stations, tip, start, trail, out, work,
        ) = _parts(points, array_at(address, size))  # fmt: skip
        afresh, possible = settings[2] != 0.0, pulls(con, lam_l, lam_r)
        known = possible and not afresh and accepts(state, 1, 0, settings[0])
        if possible and _follow(points, con, coefficients, settings, state, before, followed, known, lam_l, lam_r):
            if settings[1] > 0.0:
                _tip_columns(points, con, state, columns)
                symmetric_from_lower(con, state, columns, compliance, jacobian)
            return state[R_X], state[R_Z], state[R_THETA], CONVERGED
        if known:
            hand_over(con, state, before, tables, slopes, len(points), loads, trail)
        if afresh:
            followed[0] = 0.0
        call = afresh, MOST_STEPS, lam_l, lam_r
        return general_step(tables, stations, tip, start, trail, loads, work, out, compliance, jacobian, *call)

    return advance
