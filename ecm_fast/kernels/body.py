"""Bodies of segments and guided tendons, from the parameter vector: what the section is at a place along the body.

The section's law jumps, or has a kink, where a segment begins, where a guided tendon ends, and where the offset of a
guide bends. These places are breaks, and so are those of markers: an element ends there, where its pose is exact to
the order of the tip's. The body between two breaks is a piece. A mesh of as many pieces as there are has equal
shares of its length for each, so that a place on the mesh goes with its piece when lengths change.
"""

import numpy as np

from ..mechanism.body import MARKER, MOST, N_POINTS, ROUTES, SEGMENT, SHAPES, TENDON
from ..mechanism.parameters import FIRST_MARKER, FIRST_SEGMENT, FIRST_TENDON
from ..mechanism.parameters import PLACES as P
from ._jit import kernel

__all__ = ["GUIDED", "body_length", "body_section", "count_pieces", "guide", "has_pair", "next_break", "tendon_row"]

N_SEGMENTS, N_TENDONS, _SIZE, _TENDON_SIZE = MOST["segment"], MOST["tendon"], SEGMENT.size, TENDON.size
CHORD, GUIDED = ROUTES.index("chord"), ROUTES.index("guided")
CIRCLE, RING, RECTANGLE = (SHAPES.index(shape) for shape in ("circle", "ring", "rectangle"))
_LENGTH, _SHAPE, _E, _NU = SEGMENT["length"], SEGMENT["shape"], SEGMENT["E"], SEGMENT["nu"]
_DENSITY, _FACTOR, _TAPER = SEGMENT["density"], SEGMENT["shear_factor"], SEGMENT["taper"]
_R, _INNER, _W, _H = (SEGMENT[f"{name}_start"] for name in ("radius", "inner_radius", "width", "height"))
_EA, _GA, _EI, _M = (SEGMENT[f"{name}_start"] for name in ("EA", "GA", "EI", "mass_per_length"))
_ROUTE, _POINTS, _PLACE_1, _OFFSET_1 = TENDON["route"], TENDON["points"], TENDON["place_1"], TENDON["offset_1"]
_ENDS_AT, _SHIFT = TENDON["ends_at"], TENDON["shift"]
MARKER_PLACE, MARKER_SIZE, N_MARKERS = MARKER["place"], MARKER.size, MOST["marker"]
MOST_PIECES = N_SEGMENTS + N_TENDONS * (N_POINTS + 1) + N_MARKERS + 1
SAME = 1e-9  # breaks closer than this, as a share of the length, are one


@kernel
def has_pair(par):
    """Whether the two tendons are the pair of the section `tendons`."""
    return par[FIRST_SEGMENT + _LENGTH].real == 0.0 and par[FIRST_TENDON + _ROUTE].real == 0.0


@kernel
def body_length(par):
    """Length of the undeformed body [m]."""
    total = 0.0 * par[0]
    for i in range(N_SEGMENTS):
        total += par[FIRST_SEGMENT + _SIZE * i + _LENGTH]
    return (total if total.real > 0.0 else par[P.beam_length]) + par[P.effects_beam_length]


@kernel
def tendon_row(par, i):
    """The numbers of a named tendon."""
    return par[FIRST_TENDON + _TENDON_SIZE * i : FIRST_TENDON + _TENDON_SIZE * (i + 1)]


@kernel
def is_guided(row):
    """Whether a named tendon is guided along the body."""
    return int(row[_ROUTE].real) == GUIDED


@kernel
def _nearer(found, place, at, length):
    """The nearer of two breaks beyond a place."""
    gap = SAME * length.real
    return place if at.real + gap < place.real < found.real - gap else found


@kernel
def next_break(par, at, length):
    """The break that follows a place; the length where none does [m]."""
    found, end = length, 0.0 * par[0]
    for i in range(N_SEGMENTS):
        end += par[FIRST_SEGMENT + _SIZE * i + _LENGTH]
        found = _nearer(found, end, at, length)
    for i in range(N_TENDONS):
        row = tendon_row(par, i)
        if is_guided(row):
            last = row[_ENDS_AT] if row[_ENDS_AT].real > 0.0 else length
            found = _nearer(found, last, at, length)
            for k in range(int(row[_POINTS].real)):
                if row[_PLACE_1 + k].real < last.real:
                    found = _nearer(found, row[_PLACE_1 + k], at, length)
    for i in range(N_MARKERS):
        found = _nearer(found, par[FIRST_MARKER + MARKER_SIZE * i + MARKER_PLACE], at, length)
    return found


@kernel
def count_pieces(par, length):
    """Number of pieces of the body; 1 without segments, guided tendons and markers."""
    pieces, at = 1, next_break(par, 0.0 * length, length)
    while at.real < length.real * (1.0 - SAME) and pieces < MOST_PIECES:
        pieces, at = pieces + 1, next_break(par, at, length)
    return pieces


@kernel
def guide(row, s, length):
    """Offset of a guided tendon at a place, its slope, and whether it is there; see [B3] of `reference.body`."""
    last = row[_ENDS_AT] if row[_ENDS_AT].real > 0.0 else length
    there = s.real < last.real * (1.0 + SAME)
    offset, slope = row[_OFFSET_1], 0.0 * s
    for k in range(1, int(row[_POINTS].real)):
        before, after = row[_PLACE_1 + k - 1], row[_PLACE_1 + k]
        if s.real >= before.real:
            slope = (row[_OFFSET_1 + k] - row[_OFFSET_1 + k - 1]) / (after - before)
            offset = row[_OFFSET_1 + k - 1] + slope * (s - before)
        if s.real >= after.real:
            offset, slope = row[_OFFSET_1 + k], 0.0 * s
    return offset + row[_SHIFT], slope, there


@kernel
def _end(row, name, start):
    """Size or stiffness at the end of a segment."""
    return row[name + 1] if row[name + 1].real > 0.0 else start


@kernel
def _start(row, name, before):
    """Size or stiffness at the start of a segment: what is given, or what the segment before ended with."""
    return row[name] if row[name].real > 0.0 else before


@kernel
def body_section(par, s):
    """EA [N], GA [N], EI [N m^2] and mass per length [kg/m] at a place of a body of segments, [B1] of `reference.body`.

    s : place along the undeformed body [m]
    """
    none = 0.0 * par[0]
    begin, stated, shape = none, False, 0
    E, nu, density, factor = none, none, none, none
    R, r, W, H, EA, GA, EI, M = none, none, none, none, none, none, none, none
    for i in range(N_SEGMENTS):
        row = par[FIRST_SEGMENT + _SIZE * i : FIRST_SEGMENT + _SIZE * (i + 1)]
        if row[_EA].real > 0.0 or row[_GA].real > 0.0 or row[_EI].real > 0.0 or row[_M].real > 0.0:
            stated = True
        elif row[_SHAPE].real > 0.0 or row[_R].real > 0.0 or row[_W].real > 0.0 or row[_E].real > 0.0:
            stated = False
        shape = int(row[_SHAPE].real) if row[_SHAPE].real > 0.0 else shape
        E, nu = (row[_E] if row[_E].real > 0.0 else E), (row[_NU] if row[_NU].real > 0.0 else nu)
        density = row[_DENSITY] if row[_DENSITY].real > 0.0 else density
        factor = row[_FACTOR] if row[_FACTOR].real > 0.0 else factor
        taper = row[_TAPER] if row[_TAPER].real > 0.0 else 1.0 + none
        R, r, W, H = _start(row, _R, R), _start(row, _INNER, r), _start(row, _W, W), _start(row, _H, H)
        EA, GA, EI, M = _start(row, _EA, EA), _start(row, _GA, GA), _start(row, _EI, EI), _start(row, _M, M)
        R1, r1, W1, H1 = _end(row, _R, R), _end(row, _INNER, r), _end(row, _W, W), _end(row, _H, H)
        EA1, GA1, EI1, M1 = _end(row, _EA, EA), _end(row, _GA, GA), _end(row, _EI, EI), _end(row, _M, M)
        length = row[_LENGTH]
        is_last = i == N_SEGMENTS - 1 or par[FIRST_SEGMENT + _SIZE * (i + 1) + _LENGTH].real == 0.0
        if is_last or s.real < (begin + length).real:
            t = (s - begin) / length
            c = 1.0 + (taper - 1.0) * t
            if stated:
                c2 = c * c
                return ((EA + t * (EA1 - EA)) * c2, (GA + t * (GA1 - GA)) * c2, (EI + t * (EI1 - EI)) * c2 * c2,
                        (M + t * (M1 - M)) * c2)  # fmt: skip
            R, r, W, H = c * (R + t * (R1 - R)), c * (r + t * (r1 - r)), c * (W + t * (W1 - W)), c * (H + t * (H1 - H))
            area, second, shear = _shape(shape, R, r, W, H, nu)
            shear = factor if factor.real > 0.0 else shear
            return E * area, shear * 0.5 * E / (1.0 + nu) * area, E * second, density * area
        begin += length
        taper2 = taper * taper
        R, r, W, H = taper * R1, taper * r1, taper * W1, taper * H1
        EA, GA, EI, M = taper2 * EA1, taper2 * GA1, taper2 * taper2 * EI1, taper2 * M1
    return EA, GA, EI, M


@kernel
def _shape(shape, R, r, W, H, nu):
    """Area, second moment and shear factor of a shape, [B2] of `reference.body`."""
    if shape == CIRCLE:
        return np.pi * R * R, 0.25 * np.pi * R * R * R * R, 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu)
    if shape == RING:
        R2, r2 = R * R, r * r
        m2 = r2 / R2
        square = (1.0 + m2) * (1.0 + m2)
        shear = 6.0 * (1.0 + nu) * square / ((7.0 + 6.0 * nu) * square + (20.0 + 12.0 * nu) * m2)
        return np.pi * (R2 - r2), 0.25 * np.pi * (R2 * R2 - r2 * r2), shear
    if shape == RECTANGLE:
        return W * H, W * H * H * H / 12.0, 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu)
    a2, b2 = 0.25 * H * H, 0.25 * W * W
    shear = (40.0 + 37.0 * nu) * a2 * a2 + (16.0 + 10.0 * nu) * a2 * b2 + nu * b2 * b2
    shear = 12.0 * (1.0 + nu) * a2 * (3.0 * a2 + b2) / shear
    return 0.25 * np.pi * W * H, np.pi * W * H * H * H / 64.0, shear
