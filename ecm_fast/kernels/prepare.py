"""From the parameter vector to the constants of a solve.

Everything that does not change while Newton iterates is done here, once per mechanism: geometry, materials along
the beam, weights, and every effect that only alters those. Such an effect costs a solve nothing.
"""

from ..parameters import index
from ._jit import kernel
from .layout import (
    S_EA,
    S_EI,
    S_GA,
    S_HOOKE,
    S_INV_H,
    S_KAPPA0,
    S_LOAD_X,
    S_LOAD_Z,
    S_OFFSET,
    S_WEIGHT,
    T_ATTACH_LX,
    T_ATTACH_LZ,
    T_ATTACH_RX,
    T_ATTACH_RZ,
    T_BENDING_FORCE,
    T_COM_X,
    T_COM_Z,
    T_LENGTH,
    T_PULLEY_LX,
    T_PULLEY_LZ,
    T_PULLEY_RX,
    T_PULLEY_RZ,
    T_RADIUS,
    T_TOLERANCE,
    T_WEIGHT_X,
    T_WEIGHT_Z,
)
from .trig import sincos

__all__ = ["prepare"]

LENGTH, EA, GA, EI = index("beam.length"), index("EA"), index("GA"), index("EI")
MASS_PER_LENGTH, AXIAL_LAW = index("mass_per_length"), index("axial_law")
MASS, COM_H, COM_B = index("head.mass"), index("head.h"), index("head.b")
HALF_WIDTH, PULLEY_X, PULLEY_Z = index("plate_half_width"), index("pulley_x"), index("pulley_z")
RADIUS, G = index("tendons.pulley_radius"), index("gravity.g")
PRECURVATURE, NEUTRAL_AXIS_OFFSET = index("precurvature"), index("neutral_axis_offset")
TAPER, SPOT, SPOT_PLACE = index("stiffness_taper"), index("soft_spot.size"), index("soft_spot.place")
SPOT_WIDTH = index("soft_spot.width")
CLAMP_TILT, GRAVITY_TILT, HEAD_MASS = index("clamp_tilt"), index("gravity_tilt"), index("effects.head_mass")
PULLEY_HEIGHT, PULLEY_HEIGHT_ASYMMETRY = index("pulley_height"), index("pulley_height_asymmetry")
PULLEY_SPACING, PULLEY_SHIFT = index("pulley_spacing"), index("pulley_shift")

# largest last Newton step, in rad and shares of the length, and largest error of the contact force it may leave, as a
# share of EI/length^2; Newton squares both once more
TOLERANCE, FORCE_TOLERANCE = 1e-9, 1e-7


@kernel
def _profile(par, place, before, share):
    """Stiffness at a Gauss point as a share of the mechanism's, [C3] of `reference.section`.

    place : of the point; before, share : where the stretch of beam begins that it stands for, and how long that is;
        all as shares of the length [-]
    """
    middle, half = par[SPOT_PLACE], 0.5 * par[SPOT_WIDTH] / par[LENGTH]
    lower, upper = middle - half, middle + half
    lower = lower if lower.real > before else before + 0.0 * lower
    upper = upper if upper.real < before + share else before + share + 0.0 * upper
    covered = (upper - lower) / share if upper.real > lower.real else 0.0 * lower
    return (1.0 + par[TAPER] * (2.0 * place - 1.0)) / (1.0 + covered * par[SPOT] / (1.0 - par[SPOT]))


@kernel
def prepare(par, mesh, nodes, stations, tip, q_rest):
    """Constants of a solve for one parameter vector.

    par : (n_parameters,)    see `parameters.PARAMETERS`; real, or complex for the complex step
    mesh : (n_stations, 3)   Gauss points as shares of the length: place, weight, 1/element length [-]
    nodes : (n_nodes,)       places of the nodes as shares of the length [-]
    stations : (n_stations, N_STATION), tip : (N_TIP,), q_rest : (3 n_nodes,)   overwritten
    """
    sin_tilt, cos_tilt = sincos(par[GRAVITY_TILT])
    gravity_x, gravity_z = -par[G] * cos_tilt, -par[G] * sin_tilt
    length = par[LENGTH]
    before = 0.0
    for i in range(mesh.shape[0]):
        profile = _profile(par, mesh[i, 0], before, mesh[i, 1])
        before += mesh[i, 1]
        stations[i, S_WEIGHT] = mesh[i, 1] * length
        stations[i, S_INV_H] = mesh[i, 2] / length
        stations[i, S_EA] = par[EA] * profile
        stations[i, S_GA] = par[GA] * profile
        stations[i, S_EI] = par[EI] * profile
        stations[i, S_KAPPA0] = par[PRECURVATURE]
        stations[i, S_OFFSET] = par[NEUTRAL_AXIS_OFFSET]
        stations[i, S_HOOKE] = par[AXIAL_LAW]
        stations[i, S_LOAD_X] = par[MASS_PER_LENGTH] * gravity_x
        stations[i, S_LOAD_Z] = par[MASS_PER_LENGTH] * gravity_z

    tip[T_ATTACH_LX], tip[T_ATTACH_LZ] = 0.0, par[HALF_WIDTH]
    tip[T_ATTACH_RX], tip[T_ATTACH_RZ] = 0.0, -par[HALF_WIDTH]
    height, spacing = par[PULLEY_X] + par[PULLEY_HEIGHT], par[PULLEY_Z] + par[PULLEY_SPACING]
    tip[T_PULLEY_LX] = height + 0.5 * par[PULLEY_HEIGHT_ASYMMETRY]
    tip[T_PULLEY_RX] = height - 0.5 * par[PULLEY_HEIGHT_ASYMMETRY]
    tip[T_PULLEY_LZ] = spacing + par[PULLEY_SHIFT]
    tip[T_PULLEY_RZ] = -spacing + par[PULLEY_SHIFT]
    tip[T_RADIUS] = par[RADIUS]
    tip[T_COM_X], tip[T_COM_Z] = par[COM_H], par[COM_B]
    head_mass = par[MASS] + par[HEAD_MASS]
    tip[T_WEIGHT_X], tip[T_WEIGHT_Z] = head_mass * gravity_x, head_mass * gravity_z
    tip[T_LENGTH] = length
    # the verdict on stability needs the contact force to a small share of the bending stiffness, so where stretching
    # is stiff a Newton step must be smaller to be the last
    tip[T_BENDING_FORCE] = par[EI] / (length * length)
    stiff = max(par[EA].real, par[GA].real) / tip[T_BENDING_FORCE].real
    tip[T_TOLERANCE] = min(TOLERANCE, FORCE_TOLERANCE / stiff)

    sin_clamp, cos_clamp = sincos(par[CLAMP_TILT])
    for i in range(nodes.shape[0]):
        q_rest[3 * i] = nodes[i] * length * cos_clamp
        q_rest[3 * i + 1] = -nodes[i] * length * sin_clamp
        q_rest[3 * i + 2] = par[CLAMP_TILT]
