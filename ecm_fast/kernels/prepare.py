"""Constants of a solve, computed from the parameter vector.

Everything that does not change while Newton iterates is done here, once per mechanism: geometry, materials along
the beam, weights, and every effect that only alters those. Such an effect costs a solve nothing.
"""

import numpy as np

from ..mechanism.body import ROUTES, TENDON
from ..mechanism.catalogue import FULL_SCALE
from ..mechanism.parameters import FIRST_SEGMENT, N_BUILT_IN, N_TAIL
from ..mechanism.parameters import PLACES as P
from . import layout as at
from ._jit import kernel
from .body import GUIDED, SAME, body_length, body_section, count_pieces, guide, has_pair, next_break, tendon_row
from .trig import sincos
from .user_laws import find_law

__all__ = ["is_top_heavy", "prepare"]

# largest last Newton step, in rad and shares of the length, and largest error of the contact force it may leave, as a
# share of EI/length^2; Newton squares both once more
TOLERANCE, FORCE_TOLERANCE = 1e-9, 1e-7
ROUNDING = 1e-9  # of lengths as shares of an element
NONE = 1e-12  # what rounding may leave of a mass or a radius of 0
TENDON_ROUTE, TENDON_PLATE, TENDON_PULLEY = TENDON["route"], TENDON["plate_x"], TENDON["pulley_x"]
TENDON_RADIUS, TENDON_GAIN, TENDON_ZERO = TENDON["pulley_radius"], TENDON["gain"], TENDON["zero"]
CHORD = ROUTES.index("chord")
LEAST_COMPLIANCE = 0.05  # of a Gauss point beside a soft spot, as a share of what it has without


@kernel
def _points(mesh):
    """Gauss points of an element, which all have equally many: their weights make up its length."""
    share, i = 0.0, 0
    while i < mesh.shape[0] and share * mesh[0, 2] < 1.0 - ROUNDING:
        share += mesh[i, 1]
        i += 1
    return i


@kernel
def _covered(place, lower, upper, points):
    """Share of a Gauss point's length that lies between two ends, [C3] of `reference.section`.

    By Legendre's polynomials P, half the sum of P_k(place) (P_k+1 - P_k-1) between the ends.
    place, lower, upper : in the element, from -1 to 1
    """
    lower = lower if lower.real > -1.0 else -1.0 + 0.0 * lower
    upper = upper if upper.real < 1.0 else 1.0 + 0.0 * upper
    if upper.real <= lower.real:
        return 0.0 * upper
    here, here_before, found = 1.0, 0.0, 0.0 * upper
    top, top_before, bottom, bottom_before = 1.0 + 0.0 * upper, 0.0 * upper, 1.0 + 0.0 * lower, 0.0 * lower
    for k in range(points):
        by, back = (2.0 * k + 1.0) / (k + 1.0), k / (k + 1.0)
        top_next, bottom_next = by * upper * top - back * top_before, by * lower * bottom - back * bottom_before
        found += 0.5 * here * (top_next - top_before - bottom_next + bottom_before)
        top_before, top, bottom_before, bottom = top, top_next, bottom, bottom_next
        here_before, here = here, by * place * here - back * here_before
    return found


@kernel
def _profile(par, place, in_element, lower, upper, points, length):
    """Stiffness at a Gauss point as a share of the mechanism's, [C3] of `reference.section`.

    place : of the point, as a share of the length [-]
    in_element, lower, upper : of the point and of the soft spot's ends, from -1 to 1 in the element
    """
    soft = par[P.effects_soft_spot_size]
    profile = 1.0 + par[P.effects_stiffness_taper] * (2.0 * place - 1.0)
    if soft != 0.0:
        compliance = 1.0 + _covered(in_element, lower, upper, points) * soft / (1.0 - soft)
        profile /= compliance if compliance.real > LEAST_COMPLIANCE else LEAST_COMPLIANCE + 0.0 * compliance
    bonded = par[P.effects_bonded_ends_size]
    if bonded != 0.0:
        fade = -length / par[P.effects_bonded_ends_decay]
        profile *= 1.0 + bonded * (np.exp(place * fade) + np.exp((1.0 - place) * fade))
    return profile


@kernel
def _prepare_section(par, station):
    """Sizes of the effects of the section's laws, the user's among them."""
    station[at.S_CUBIC] = par[P.effects_bending_cubic]
    station[at.S_AMPLITUDE] = par[P.effects_bending_amplitude]
    station[at.S_ONE_SIDED] = par[P.effects_bending_one_sided]
    station[at.S_BIMODULUS] = par[P.effects_bimodulus]
    station[at.S_NEO_HOOKEAN] = par[P.effects_neo_hookean_section]
    station[at.S_MOONEY] = par[P.effects_mooney_rivlin]
    station[at.S_OGDEN] = par[P.effects_ogden]
    station[at.S_SHEAR_CUBIC] = par[P.effects_shear_cubic]
    station[at.S_SHEAR_COMPRESSION] = par[P.effects_shear_compression]
    station[at.S_FURTHER] = 1.0 if _put_user(par, 0, station[at.S_LAW :]) else 0.0
    for i in range(at.S_CUBIC, at.S_SHEAR_COMPRESSION + 1):
        if station[i] != 0.0:
            station[at.S_FURTHER] = 1.0


@kernel
def _put_user(par, which, room):
    """Put the number of the user's laws, of the section (0) or of the head (1), and the values of their effects.

    Returns whether any of these effects is there.
    """
    count = par.shape[0] - N_TAIL - N_BUILT_IN
    room[0] = find_law(par[par.shape[0] - N_TAIL].real, which) if count > 0 else 0.0
    present = False
    for i in range(at.N_USER):
        room[1 + i] = par[N_BUILT_IN + i] if i < count else 0.0
        present = present or (i < count and room[1 + i] != 0.0 and (int(par[par.shape[0] - 1].real) >> i) % 2 == 1)
    return present and room[0] != 0.0


@kernel
def _prepare_tendons(par, tip):
    """Attachments, pulleys, and the way from the readings of the force cells to the forces."""
    s, c = sincos(par[P.effects_plate_misalignment])
    height, lever = par[P.effects_attachment_height], par[P.tendons_plate_half_width] + par[P.effects_lever_arm]
    lever_l = lever + 0.5 * par[P.effects_lever_arm_asymmetry]
    lever_r = lever - 0.5 * par[P.effects_lever_arm_asymmetry]
    tip[at.T_ATTACH_LX], tip[at.T_ATTACH_LZ] = height * c + lever_l * s, lever_l * c - height * s
    tip[at.T_ATTACH_RX], tip[at.T_ATTACH_RZ] = height * c - lever_r * s, -lever_r * c - height * s
    x, z = par[P.tendons_pulley_x] + par[P.effects_pulley_height], par[P.tendons_pulley_z]
    z += par[P.effects_pulley_spacing]
    tip[at.T_PULLEY_LX] = x + 0.5 * par[P.effects_pulley_height_asymmetry]
    tip[at.T_PULLEY_RX] = x - 0.5 * par[P.effects_pulley_height_asymmetry]
    tip[at.T_PULLEY_LZ], tip[at.T_PULLEY_RZ] = z + par[P.effects_pulley_shift], -z + par[P.effects_pulley_shift]
    # on the outer side: to the left of a tendon that runs down to the left pulley, to the right of one that runs up
    radius, top = par[P.tendons_pulley_radius] + par[P.effects_pulley_radius], body_length(par)
    below_l = tip[at.T_PULLEY_LX].real <= (top + tip[at.T_ATTACH_LX]).real
    below_r = tip[at.T_PULLEY_RX].real <= (top + tip[at.T_ATTACH_RX]).real
    tip[at.T_REACH_L], tip[at.T_REACH_R] = -radius if below_l else radius, radius if below_r else -radius
    gain, zero = 1.0 + par[P.effects_force_gain], par[P.effects_force_zero]
    tip[at.T_GAIN_L] = gain + 0.5 * par[P.effects_force_gain_asymmetry]
    tip[at.T_GAIN_R] = gain - 0.5 * par[P.effects_force_gain_asymmetry]
    tip[at.T_ZERO_L] = zero + 0.5 * par[P.effects_force_zero_asymmetry]
    tip[at.T_ZERO_R] = zero - 0.5 * par[P.effects_force_zero_asymmetry]
    tip[at.T_NONLINEARITY] = par[P.effects_force_nonlinearity] / FULL_SCALE
    tip[at.T_CROSSTALK] = par[P.effects_force_crosstalk]


@kernel
def _prepare_guides(par, s, length, station):
    """Guided tendons at a place of the body."""
    count = 0
    for i in range(at.N_TENDONS):
        row = tendon_row(par, i)
        if int(row[TENDON_ROUTE].real) == GUIDED:
            offset, slope, there = guide(row, s, length)
            if there:
                entry = station[at.S_GUIDE + at.N_GUIDE * count :]
                entry[0], entry[1], entry[2] = float(i if i < 2 else at.L_LAM_3 + i - 2), offset, slope
                entry[3], entry[4] = 1.0 + row[TENDON_GAIN], row[TENDON_ZERO]
                count += 1
    station[at.S_GUIDES] = float(count)


@kernel
def _prepare_chords(par, length, tip):
    """Chords of named tendons: the first two stand where the pair would, and what is not there has no force."""
    count = 0
    tip[at.T_NONLINEARITY], tip[at.T_CROSSTALK] = 0.0, 0.0
    for i in range(at.N_TENDONS):
        row = tendon_row(par, i)
        chord = int(row[TENDON_ROUTE].real) == CHORD
        if i < 2:
            tip[at.T_GAIN_L + i], tip[at.T_ZERO_L + i], tip[at.T_REACH_L + i] = 0.0, 0.0, 0.0
            tip[at.T_ATTACH_LX + 2 * i], tip[at.T_ATTACH_LZ + 2 * i] = 0.0, 0.0
            # out of the way: a direction without length would be none, and no number
            tip[at.T_PULLEY_LX + 2 * i], tip[at.T_PULLEY_LZ + 2 * i] = -10.0 * length, 0.0
        if not chord:
            continue
        a_x, a_z, radius = row[TENDON_PLATE], row[TENDON_PLATE + 1], row[TENDON_RADIUS]
        # on the outer side, as in `_prepare_tendons`
        below = row[TENDON_PULLEY].real <= (length + a_x).real
        reach = -radius if below == (a_z.real >= 0.0) else radius
        gain, zero = 1.0 + row[TENDON_GAIN], row[TENDON_ZERO]
        if i < 2:
            tip[at.T_ATTACH_LX + 2 * i], tip[at.T_ATTACH_LZ + 2 * i] = a_x, a_z
            tip[at.T_PULLEY_LX + 2 * i], tip[at.T_PULLEY_LZ + 2 * i] = row[TENDON_PULLEY], row[TENDON_PULLEY + 1]
            tip[at.T_REACH_L + i], tip[at.T_GAIN_L + i], tip[at.T_ZERO_L + i] = reach, gain, zero
        else:
            entry = tip[at.T_CHORD + at.N_CHORD * count :]
            entry[0], entry[1], entry[2] = float(at.L_LAM_3 + i - 2), a_x, a_z
            entry[3], entry[4], entry[5] = row[TENDON_PULLEY], row[TENDON_PULLEY + 1], reach
            entry[6], entry[7] = gain, zero
            count += 1
    tip[at.T_CHORDS] = float(count)


@kernel
def _sound(par, stations, tip):
    """Whether pulleys, force cells and sections can be built, see `mechanism.derived`."""
    sound = (par[P.tendons_pulley_radius] + par[P.effects_pulley_radius]).real > -NONE
    sound = sound and (not has_pair(par) or (tip[at.T_GAIN_L].real > 0.0 and tip[at.T_GAIN_R].real > 0.0))
    for i in range(stations.shape[0]):
        EA, GA, EI = stations[i, at.S_EA], stations[i, at.S_GA], stations[i, at.S_EI]
        sound = sound and EA.real > 0.0 and GA.real > 0.0 and EI.real > 0.0
    return sound


@kernel
def _prepare_ends(par, tip):
    """Springs and stops of the head, and compliances at both ends of the beam."""
    tip[at.T_SIDE] = par[P.effects_side_force]
    tip[at.T_SPRING_Z] = par[P.effects_lateral_spring]
    tip[at.T_SPRING_T] = par[P.effects_rotational_spring]
    tip[at.T_STOP] = par[P.effects_contact_stop_stiffness]
    tip[at.T_STOP_ANGLE] = par[P.effects_contact_stop_angle]
    tip[at.T_STOP_1] = par[P.effects_contact_stop_one_sided_stiffness]
    tip[at.T_STOP_1_ANGLE] = par[P.effects_contact_stop_one_sided_angle]
    tip[at.T_JOINT] = par[P.effects_plate_joint_compliance]
    tip[at.T_CLAMP_X] = par[P.effects_clamp_axial_compliance]
    tip[at.T_CLAMP_Z] = par[P.effects_clamp_lateral_compliance]
    tip[at.T_CLAMP_T] = par[P.effects_clamp_rotation_compliance]
    tip[at.T_CLAMP_TILT] = par[P.effects_clamp_tilt]
    tip[at.T_FURTHER] = 1.0 if _put_user(par, 1, tip[at.T_LAW :]) else 0.0
    for i in (at.T_STOP, at.T_STOP_1, at.T_JOINT, at.T_CLAMP_X, at.T_CLAMP_Z, at.T_CLAMP_T):
        if tip[i] != 0.0:
            tip[at.T_FURTHER] = 1.0


@kernel
def prepare(par, mesh, nodes, stations, tip, q_rest):
    """Constants of a solve for one parameter vector.

    par : (n_parameters,)    see `parameters.PARAMETERS`; real, or complex for the complex step
    mesh : (n_stations, 3)   Gauss points as shares of the length: place, weight, 1/element length [-]; of a body of
        several pieces, see `body`, each has an equal share
    nodes : (n_nodes,)       places of the nodes as such shares [-]
    stations : (n_stations, N_STATION), tip : (N_TIP,), q_rest : (3 n_nodes,)   overwritten

    X
    """
    sin_tilt, cos_tilt = sincos(par[P.gravity_tilt] + par[P.effects_gravity_tilt])
    gravity_x, gravity_z = -par[P.gravity_g] * cos_tilt, -par[P.gravity_g] * sin_tilt
    length, pieces, conforms = body_length(par), 1, True
    pair, segmented = has_pair(par), par[FIRST_SEGMENT].real > 0.0
    EA, GA, EI, mass_per_length = par[P.beam_EA], par[P.beam_GA], par[P.beam_EI], par[P.beam_mass_per_length]
    pieces = count_pieces(par, length)
    half, points, begin = 0.5 * par[P.effects_soft_spot_width] / length, _points(mesh), 0.0
    lower, upper = par[P.effects_soft_spot_place] - half, par[P.effects_soft_spot_place] + half
    piece, piece_begin, piece_end = 1, 0.0 * length, next_break(par, 0.0 * length, length)
    stiffest, softest, lightest = 0.0, np.inf, np.inf
    for i in range(mesh.shape[0]):
        station, on_mesh, scale = stations[i], mesh[i, 0], 2.0 * mesh[i, 2]
        while on_mesh * pieces > piece and piece < pieces:
            piece, piece_begin, piece_end = piece + 1, piece_end, next_break(par, piece_end, length)
        stretched = (piece_end - piece_begin) * pieces  # length of the body by share of the mesh
        s = piece_begin + (on_mesh - (piece - 1.0) / pieces) * stretched
        place, begin_place = s / length, (s - (on_mesh - begin) * stretched) / length
        by_place = scale * length / stretched
        profile = _profile(par, place, scale * (on_mesh - begin) - 1.0, by_place * (lower - begin_place) - 1.0,
                           by_place * (upper - begin_place) - 1.0, points, length)  # fmt: skip
        if (i + 1) % points == 0:
            end = begin + 1.0 / mesh[i, 2]
            conforms = conforms and np.floor(begin * pieces + SAME) + 1.0 >= np.ceil(end * pieces - SAME)
            begin = end
        station[at.S_WEIGHT], station[at.S_INV_H] = mesh[i, 1] * stretched, mesh[i, 2] / stretched
        if segmented:
            EA, GA, EI, mass_per_length = body_section(par, s)
        mass = mass_per_length + par[P.effects_beam_mass]
        stiffest = max(stiffest, max(EA.real, GA.real))
        softest, lightest = min(softest, EI.real), min(lightest, mass.real)
        station[at.S_EA], station[at.S_GA], station[at.S_EI] = EA * profile, GA * profile, EI * profile
        gradient = par[P.effects_precurvature_gradient] * (2.0 * place - 1.0)
        station[at.S_KAPPA0] = par[P.effects_precurvature] + gradient
        station[at.S_OFFSET] = par[P.effects_neutral_axis_offset]
        station[at.S_HOOKE], station[at.S_PLACE] = par[P.beam_axial_law], place
        station[at.S_LOAD_X], station[at.S_LOAD_Z] = mass * gravity_x, mass * gravity_z
        _prepare_section(par, station)
        station[at.S_GUIDES] = 0.0
        if not pair:
            _prepare_guides(par, s, length, station)

    _prepare_tendons(par, tip)
    tip[at.T_CHORDS] = 0.0
    if not pair:
        _prepare_chords(par, length, tip)
    _prepare_ends(par, tip)
    tip[at.T_COM_X] = par[P.head_h] + par[P.effects_head_com_height]
    tip[at.T_COM_Z] = par[P.head_b] + par[P.effects_head_com_sideways]
    head_mass = par[P.head_mass] + par[P.effects_head_mass]
    tip[at.T_WEIGHT_X], tip[at.T_WEIGHT_Z] = head_mass * gravity_x, head_mass * gravity_z
    tip[at.T_LENGTH] = length
    # the verdict on stability needs the contact force to a small share of the bending stiffness, so where stretching
    # is stiff a Newton step must be smaller to be the last
    tip[at.T_BENDING_FORCE] = EI / (length * length)
    stiff = stiffest * length.real * length.real / softest
    tip[at.T_TOLERANCE] = min(TOLERANCE, FORCE_TOLERANCE / stiff)

    possible = conforms and length.real > 0.0 and min(lightest, head_mass.real) > -NONE
    if not (possible and _sound(par, stations, tip)):
        tip[at.T_LENGTH] = np.nan

    sin_clamp, cos_clamp = sincos(par[P.effects_clamp_tilt])
    piece, piece_begin, piece_end = 1, 0.0 * length, next_break(par, 0.0 * length, length)
    for i in range(nodes.shape[0]):
        while nodes[i] * pieces > piece * (1.0 + ROUNDING) and piece < pieces:
            piece, piece_begin, piece_end = piece + 1, piece_end, next_break(par, piece_end, length)
        s = piece_begin + (nodes[i] * pieces - (piece - 1.0)) * (piece_end - piece_begin)
        s = s if nodes[i] > 0.0 else 0.0 * length
        q_rest[3 * i] = s * cos_clamp
        q_rest[3 * i + 1] = -s * sin_clamp
        q_rest[3 * i + 2] = par[P.effects_clamp_tilt]


@kernel
def is_top_heavy(stations, tip, theta0):
    """Whether the straight beam may not carry what it weighs alone.

    From straight, Newton's method may go to the full load at once only where no branch can end in between. The
    stiffness of the straight beam is linear in the loads, so it stays stable from its own weight to the full load if
    it is stable at both. The first is looked at here, the second by Newton's first step.

    With the turns theta from straight, theta(s)^2 <= s int theta'^2; so int P theta^2 ds, what a compression P takes,
    is less than int EI theta'^2 ds, what bending gives, where int P s ds < EI. Of what is really carried that claims
    81 % for a weight on top and 77 % for the beam's own. Shear adds P/GA to P.
    """
    length, s, c = tip[at.T_LENGTH], np.sin(theta0), np.cos(theta0)
    on_top = max(tip[at.T_WEIGHT_Z] * s - tip[at.T_WEIGHT_X] * c, 0.0)
    lever_x, lever_z = tip[at.T_COM_X] * c + tip[at.T_COM_Z] * s, tip[at.T_COM_Z] * c - tip[at.T_COM_X] * s
    couple = max(-(lever_x * tip[at.T_WEIGHT_X] + lever_z * tip[at.T_WEIGHT_Z]), 0.0)
    total, moment, EI, GA = on_top, 0.5 * on_top * length * length, np.inf, np.inf
    for i in range(stations.shape[0]):
        row = stations[i]
        own = row[at.S_WEIGHT] * max(row[at.S_LOAD_Z] * s - row[at.S_LOAD_X] * c, 0.0)
        total += own
        moment += 0.5 * own * (row[at.S_PLACE] * length) ** 2
        EI, GA = min(EI, row[at.S_EI]), min(GA, row[at.S_GA])
    return moment * (1.0 + total / GA) + couple * length > EI
