"""Quantities that a row inherits from the rows before it, and the effects of the path: friction, memory, drift.

`models.instruments.history` states the laws. They are written for one row, real or complex, and serve whole records of
measurements as they serve the control step.
"""

import math

import numpy as np

from ..mechanism.parameters import PLACES as P
from ._jit import array_at, kernel
from .condensed.formulation import condense
from .layout import (
    C_STATION,
    M_FIRST,
    M_GAP,
    M_HELD,
    M_HOURS,
    M_LENGTH_L,
    M_LENGTH_R,
    M_PEAK,
    M_REMEMBERED,
    M_SLIDER,
    M_THETA,
    M_WAY_L,
    M_WAY_R,
    N_PAST,
    N_POINT,
    N_SLOPE,
    N_STATION,
    N_STRETCH,
    N_TIP,
)
from .prepare import prepare

__all__ = ["FULL_LOAD", "begin", "follow", "inherit", "next_row", "row_pieces", "tendon_lengths", "unfaded_rows"]

# a tendon that moves less has not moved [m]
STILL = 1e-9
FULL_LOAD = 320.0  # [N] of both tendons together, the largest of the paper's experiments
N_SIZES = 7  # numbers at the head of the memory of `next_row`: lengths and places of its parts
FIXED = N_SIZES + N_PAST + 15 + 2 * (N_STRETCH + N_SLOPE)  # what the memory of `next_row` holds whatever the mesh


@kernel
def tendon_lengths(pose, attached, pulleys, lengths):
    """Distance from attachment to pulley center of both tendons.

    pose : (n, 3) of the head; attached : (1 or n, 2, 2) attachments in the head's frame, left and right
    pulleys : (1 or n, 2, 2) their centers; lengths : (n, 2)   overwritten
    """
    for i in range(pose.shape[0]):
        row = min(i, attached.shape[0] - 1)
        s, c = np.sin(pose[i, 2]), np.cos(pose[i, 2])
        for side in range(2):
            along, across = attached[row, side, 0], attached[row, side, 1]
            x = pose[i, 0] + along * c + across * s - pulleys[row, side, 0]
            z = pose[i, 1] + across * c - along * s - pulleys[row, side, 1]
            lengths[i, side] = np.sqrt(x * x + z * z)


@kernel
def begin(past, rest):
    """Begin a path: no row so far, tendons of the lengths `rest`, (2,), as on the straight neck."""
    past[:] = 0.0
    past[M_LENGTH_L], past[M_LENGTH_R], past[M_FIRST] = rest[0], rest[1], np.inf


@kernel
def unfaded(value, remembered, held, time):
    """Lag of a memory that fades with `time` [s] behind a value after it was held [s]."""
    return (value - remembered) * np.exp(-held / time)


@kernel
def unfaded_rows(begins, held, values, time, gaps):
    """The same row by row: `begins`, `held`, `values` are (n,), and so are the gaps, which are overwritten."""
    remembered = 0.0
    for i in range(values.shape[0]):
        if begins[i]:
            remembered = 0.0
        gaps[i] = unfaded(values[i], remembered, held[i], time)
        remembered = values[i] - gaps[i]


@kernel
def carry(past, par, theta, lengths, repeats):
    """Carry the past over a row.

    past : (N_PAST,)   overwritten; the row's own time, time held and largest load are there already
    par : (n_parameters,)   of the mechanism; real or complex, as `past` is
    theta, lengths : tip angle [rad] and tendons, (2,) [m], without effects of the path; nan without equilibrium: such
        a row passes nothing on
    repeats : whether the row repeats the load of the row before
    """
    past[M_GAP] = 0.0
    if not abs(theta) < np.inf:
        return
    if not repeats:
        for side in range(2):
            moved = past[M_LENGTH_L + side].real - lengths[side]
            if abs(moved) > STILL:
                past[M_WAY_L + side] = np.sign(moved)
            past[M_LENGTH_L + side] = lengths[side]
    h = past[M_SLIDER] + (theta - past[M_THETA].real) / par[P.effects_bending_hysteresis_angle]
    if abs(h.real) > 1.0:
        h = np.sign(h.real) + 0.0 * h
    past[M_SLIDER], past[M_THETA] = h, theta
    gap = unfaded(theta, past[M_REMEMBERED], past[M_HELD].real, par[P.effects_fading_memory_time])
    past[M_REMEMBERED], past[M_GAP] = theta - gap, gap


@kernel
def inherit(row, past):
    """Write what the effects of the path make of a row's parameter vector, (n_parameters,), real or complex."""
    hours, held, peak = past[M_HOURS].real, past[M_HELD].real, past[M_PEAK].real
    way_l, way_r = past[M_WAY_L].real, past[M_WAY_R].real
    length = row[P.beam_length] + row[P.effects_beam_length]
    bent = row[P.effects_bending_hysteresis_couple] * past[M_SLIDER] / row[P.beam_EI]
    row[P.effects_precurvature] -= bent + row[P.effects_fading_memory_share] * past[M_GAP] / length
    factor = (1.0 - row[P.effects_mullins_softening] * peak) * (1.0 + row[P.effects_stiffness_drift] * hours)
    factor /= 1.0 + row[P.effects_creep] * np.log10(1.0 + held)
    row[P.beam_EA] *= factor
    row[P.beam_GA] *= factor
    row[P.beam_EI] *= factor

    gain, uneven = 1.0 + row[P.effects_force_gain], 0.5 * row[P.effects_force_gain_asymmetry]
    grip = row[P.effects_tendon_capstan_friction_coefficient] * row[P.effects_tendon_capstan_friction_wrap]
    left, right = (gain + uneven) * np.exp(-grip * way_l), (gain - uneven) * np.exp(-grip * way_r)
    row[P.effects_force_gain], row[P.effects_force_gain_asymmetry] = 0.5 * (left + right) - 1.0, left - right
    drag = row[P.effects_tendon_coulomb_friction]
    row[P.effects_force_zero] += row[P.effects_force_zero_drift] * hours - 0.5 * drag * (way_l + way_r)
    apart = row[P.effects_force_zero_drift_asymmetry] * hours - drag * (way_l - way_r)
    row[P.effects_force_zero_asymmetry] += apart
    row[P.effects_camera_x_offset] += row[P.effects_camera_drift_x] * hours
    row[P.effects_camera_z_offset] += row[P.effects_camera_drift_z] * hours


@kernel
def follow(record, theta, lengths, rest, par, past, places, rows, travel):
    """Follow a record row by row, and write what the rows inherit.

    record : whether a row begins a path and whether it repeats the load of the row before; time since the path's
        first row [h], time held [s] and largest load so far [-], (n,) each
    theta, lengths : (n,), (n, 2)   as in `carry`; rest : (2,)
    par : (n_parameters,), past : (N_PAST,)   real or complex; the past is overwritten
    places : (k,) of rows in the record, rising; rows : (k, n_parameters) their vectors, overwritten
    travel : (n, 2)   overwritten: in which direction either tendon last travelled
    """
    begins, repeats, hours, held, peak = record
    k = 0
    for i in range(theta.shape[0]):
        if begins[i]:
            begin(past, rest)
        past[M_HOURS], past[M_HELD], past[M_PEAK] = hours[i], held[i], peak[i]
        carry(past, par, theta[i], lengths[i], repeats[i])
        travel[i, 0], travel[i, 1] = past[M_WAY_L].real, past[M_WAY_R].real
        if k < places.shape[0] and places[k] == i:
            inherit(rows[k], past)
            k += 1


# The same for a control step. As in `condensed.step_memory`, everything lies in one array whose address is passed.


def row_pieces(n_par: int, n_stations: int, n_nodes: int, order: int) -> dict[str, tuple[int, tuple[int, ...]]]:
    """Return where each part of the memory of `next_row` begins, and its shape.

    order : of the condensed formulation, 0 where there is none
    """
    shapes: dict[str, tuple[int, ...]] = {
        "sizes": (N_SIZES,),
        "past": (N_PAST,),
        "pose": (1, 3),
        "lengths": (1, 2),
        "rest": (2,),
        "attached": (1, 2, 2),
        "pulleys": (1, 2, 2),
        "stretch": (2, N_STRETCH + N_SLOPE),
        "par": (n_par,),
        "row": (n_par,),
        "mesh": (n_stations, 3),
        "nodes": (n_nodes,),
        "q_rest": (3 * n_nodes,),
        "turn": (order, order),
        "slopes": (order, order),
    }
    places, first = {}, 0
    for name, shape in shapes.items():
        places[name] = (first, shape)
        first += math.prod(shape)
    return places


@kernel
def _part(memory, first, size):
    return memory[first : first + size]


@kernel
def next_row(address, system, lam_l, lam_r, t, dwell, x, z, theta):
    """Carry the past over a control step, and put the constants that the mechanism has there.

    address : of the memory, see `row_pieces`; its sizes are n_parameters, n_stations, n_nodes, order, and where in
        `system` stations, tip and the constants of the condensed formulation begin
    system : address of what is overwritten, see `prepare` and `condense`
    lam_l, lam_r : readings of the force cells [N]
    t, dwell : time stamp and time held [s]; nan where they are not given
    x, z, theta : pose without effects of the path, nan where there is none

    Returns whether t and dwell are times.
    """
    if abs(t) == np.inf or dwell < 0.0 or dwell == np.inf:
        return False
    sizes = array_at(address, N_SIZES)
    n_par, n_stations, n_nodes, order = int(sizes[0]), int(sizes[1]), int(sizes[2]), int(sizes[3])
    memory = array_at(address, FIXED + 2 * n_par + 3 * n_stations + 4 * n_nodes + 2 * order * order)
    past, seen = _part(memory, N_SIZES, N_PAST), _part(memory, N_SIZES + N_PAST, FIXED - N_SIZES - N_PAST)
    pose, lengths, rest = seen[0:3].reshape((1, 3)), seen[3:5].reshape((1, 2)), seen[5:7]
    attached, pulleys = seen[7:11].reshape((1, 2, 2)), seen[11:15].reshape((1, 2, 2))
    stretch = seen[15:].reshape((2, N_STRETCH + N_SLOPE))
    par, row = _part(memory, FIXED, n_par), _part(memory, FIXED + n_par, n_par)
    first = FIXED + 2 * n_par
    mesh, nodes = _part(memory, first, 3 * n_stations).reshape((n_stations, 3)), memory[first + 3 * n_stations :]

    if past[M_FIRST] == np.inf:
        begin(past, rest)
        past[M_FIRST] = t
    hours = (t - past[M_FIRST]) / 3600.0
    # comparisons, since arithmetic in a free order lets a compiler take `isfinite` of a difference for true
    past[M_HOURS], past[M_HELD] = hours if abs(hours) < np.inf else 0.0, dwell if dwell < np.inf else 0.0
    past[M_PEAK] = max(past[M_PEAK], (lam_l + lam_r) / FULL_LOAD)
    pose[0, 0], pose[0, 1], pose[0, 2] = x, z, theta
    tendon_lengths(pose, attached, pulleys, lengths)
    carry(past, par, theta, lengths[0], False)
    row[:] = par
    inherit(row, past)

    stations = array_at(system + 8 * int(sizes[4]), n_stations * N_STATION).reshape((n_stations, N_STATION))
    tip, q_rest = array_at(system + 8 * int(sizes[5]), N_TIP), nodes[n_nodes : 4 * n_nodes]
    prepare(row, mesh, nodes[:n_nodes], stations, tip, q_rest)
    if order > 0:
        square = order * order
        turn = _part(nodes, 4 * n_nodes, square).reshape((order, order))
        slopes = _part(nodes, 4 * n_nodes + square, square).reshape((order, order))
        con = array_at(system + 8 * int(sizes[6]), C_STATION + N_POINT * order + order * (order + 1) // 2)
        condense(stations, tip, q_rest, turn, slopes, stretch, con)
    return True
