"""Bodies of segments, and tendons guided along them."""

from itertools import pairwise
from typing import Any

import numpy as np

from ...mechanism.body import MOST, ROUTES, SHAPES
from .parameters import Parameters, length

__all__ = ["at_place", "body_at", "element_ends", "guide_energy", "guided", "segment_section"]


def _segments(p: Parameters) -> list[dict[str, Any]]:
    """Return what each segment has, with what it takes over from the one before."""
    segments, known = [], dict[str, Any]()
    for i in range(1, MOST["segment"] + 1):
        given = {key.split(".")[1]: value for key, value in p.items() if key.startswith(f"segment{i}.")}
        if given["length"] == 0.0:
            break
        of_shape = any(given[name] != 0.0 for name in ("shape", "E", "radius_start", "width_start"))
        known["stated"] = given["EA_start"] != 0.0 or (known.get("stated", False) and not of_shape)
        for name in ("shape", "E", "nu", "density", "shear_factor"):
            known[name] = given[name] if given[name] != 0.0 else known.get(name, 0.0)
        segment = {**known, "length": given["length"], "taper": given["taper"] if given["taper"] != 0.0 else 1.0}
        for name in ("radius", "inner_radius", "width", "height", "EA", "GA", "EI", "mass_per_length"):
            start = given[f"{name}_start"] if given[f"{name}_start"] != 0.0 else known.get(name, 0.0)
            end = given[f"{name}_end"] if given[f"{name}_end"] != 0.0 else start
            segment[name] = start, end
            known[name] = end * segment["taper"] ** _POWER.get(name, 1)
        segments.append(segment)
    return segments


_POWER = {"EA": 2, "GA": 2, "EI": 4, "mass_per_length": 2}
"""With which power of the size a stiffness tapers."""


def segment_section(p: Parameters, s: Any) -> tuple[Any, Any, Any, Any]:
    """[B1] EA [N], GA [N], EI [N m^2] and mass per length [kg/m] at a place along the body [m].

    Given stiffnesses are linear along the segment, times c^2 (EI: c^4) with c = 1 + (taper - 1) t, t from 0 to 1; sizes
    are linear times c, and E A, k G A, E I and density A follow from the shape, with G = E/(2 (1 + nu)).
    """
    begin, segments = 0.0, _segments(p)
    for segment in segments:
        t, last = (s - begin) / segment["length"], segment is segments[-1]
        if not last and np.real(t) >= 1.0:
            begin = begin + segment["length"]
            continue
        c = 1.0 + (segment["taper"] - 1.0) * t
        at = {name: pair[0] + t * (pair[1] - pair[0]) for name, pair in segment.items() if isinstance(pair, tuple)}
        if segment["stated"]:
            EA, GA, EI, mass = (at[name] * c ** _POWER[name] for name in _POWER)
            return EA, GA, EI, mass
        sizes = {name: c * at[name] for name in ("radius", "inner_radius", "width", "height")}
        area, second, shear = _shape(SHAPES[int(np.real(segment["shape"]))], segment["nu"], **sizes)
        shear = segment["shear_factor"] if segment["shear_factor"] != 0.0 else shear
        G = segment["E"] / (2.0 * (1.0 + segment["nu"]))
        return segment["E"] * area, shear * G * area, segment["E"] * second, segment["density"] * area
    raise ValueError("no segments")


def _shape(shape: str, nu: Any, radius: Any, inner_radius: Any, width: Any, height: Any) -> tuple[Any, Any, Any]:
    """[B2] Area, second moment about the axis across the plane, and shear factor k of a shape.

    Shear factors: G. R. Cowper, The shear coefficient in Timoshenko's beam theory, J. Appl. Mech. 33 (1966), 335-340;
    of the ellipse a is the semi-axis in the plane, b the other.
    """
    if shape == "circle":
        return np.pi * radius**2, np.pi / 4.0 * radius**4, 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu)
    if shape == "ring":
        m = inner_radius / radius
        k = 6.0 * (1.0 + nu) * (1.0 + m**2) ** 2
        k = k / ((7.0 + 6.0 * nu) * (1.0 + m**2) ** 2 + (20.0 + 12.0 * nu) * m**2)
        return np.pi * (radius**2 - inner_radius**2), np.pi / 4.0 * (radius**4 - inner_radius**4), k
    if shape == "rectangle":
        return width * height, width * height**3 / 12.0, 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu)
    a, b = height / 2.0, width / 2.0
    k = 12.0 * (1.0 + nu) * a**2 * (3.0 * a**2 + b**2)
    k = k / ((40.0 + 37.0 * nu) * a**4 + (16.0 + 10.0 * nu) * a**2 * b**2 + nu * b**4)
    return np.pi * a * b, np.pi / 4.0 * b * a**3, k


def guided(p: Parameters, s: Any) -> list[tuple[int, Any, Any]]:
    """[B3] Guided tendons at a place: number of the tendon, offset o of its guide along z [m], slope o' [-].

    The offset is linear between its points and constant before the first and behind the last.
    """
    found = []
    for i in range(1, MOST["tendon"] + 1):
        tendon = {key.split(".")[1]: value for key, value in p.items() if key.startswith(f"tendon{i}.")}
        last = tendon["ends_at"] if tendon["ends_at"] != 0.0 else length(p)
        if ROUTES[int(np.real(tendon["route"]))] != "guided" or np.real(s) > np.real(last):
            continue
        points = [(tendon[f"place_{k}"], tendon[f"offset_{k}"]) for k in range(1, int(np.real(tendon["points"])) + 1)]
        offset, slope = points[0][1], 0.0
        for (s0, o0), (s1, o1) in pairwise(points):
            if np.real(s0) <= np.real(s):
                slope = (o1 - o0) / (s1 - s0) if np.real(s) < np.real(s1) else 0.0
                offset = o0 + slope * (s - s0) if np.real(s) < np.real(s1) else o1
        found.append((i - 1, offset + tendon["shift"], slope))
    return found


def guide_energy(strains: Any, offset: Any, slope: Any) -> Any:
    """[B4] Energy per length of the undeformed body by unit tension: the stretch of the tendon's path [-].

        t = (gamma_x + o kappa, gamma_z + o'),   |t|

    The path is r + o e_z^C, its rate in the section's axes t; a frictionless guide leaves the tension constant along
    the tendon, so the energy of a tendon is its tension times the length of its path.
    """
    gamma_x, gamma_z, kappa = strains
    return np.sqrt((gamma_x + offset * kappa) ** 2 + (gamma_z + slope) ** 2)


def _breaks(p: Parameters) -> list[Any]:
    """Return where the section's law jumps or bends, and where markers are, from the clamp to the tip [m]."""
    end, found = 0.0, [length(p)]
    for i in range(1, MOST["segment"] + 1):
        end = end + p[f"segment{i}.length"]
        found.append(end)
    for i in range(1, MOST["tendon"] + 1):
        if ROUTES[int(np.real(p[f"tendon{i}.route"]))] == "guided":
            last = p[f"tendon{i}.ends_at"] if p[f"tendon{i}.ends_at"] != 0.0 else length(p)
            places = [p[f"tendon{i}.place_{k}"] for k in range(1, int(np.real(p[f"tendon{i}.points"])) + 1)]
            found += [last, *(place for place in places if np.real(place) < np.real(last))]
    found += [p[f"marker{i}.place"] for i in range(1, MOST["marker"] + 1)]
    ends: list[Any] = [0.0]
    for place in sorted(found, key=np.real):
        gap = 1e-9 * np.real(length(p))
        if np.real(ends[-1]) + gap < np.real(place) < np.real(length(p)) - gap:
            ends.append(place)
    return [*ends, length(p)]


def element_ends(p: Parameters, shares: Any) -> Any:
    """Return where elements of these shares of the mesh end, from 0 [m]: each piece has an equal share of the mesh."""
    ends, places = _breaks(p), np.concatenate([[0.0], np.cumsum(shares)])
    k = len(ends) - 1
    piece = np.clip(np.ceil(places * k - 1e-9).astype(int) - 1, 0, k - 1)
    return np.array(
        [ends[i] + (place * k - i) * (ends[i + 1] - ends[i]) for i, place in zip(piece, places, strict=True)]
    )


def body_at(p: Parameters, s: Any) -> Parameters:
    """Return the parameters with the stiffnesses and the mass of a segment at a place along the body [m]."""
    if p["segment1.length"] == 0.0:
        return p
    names = "beam.EA", "beam.GA", "beam.EI", "beam.mass_per_length"
    return {**p, **dict(zip(names, segment_section(p, s), strict=True))}


def at_place(p: Parameters, place: Any, loads: Any) -> Parameters:
    """Return a station's parameters with the guided tendons there: tension [N], offset [m] and slope of each."""
    if loads is None or p["tendon1.route"] == 0.0:
        return p
    guides = []
    for i, offset, slope in guided(p, place * length(p)):
        reading = loads[i if i < 2 else 5 + i]
        tension = reading * (1.0 + p[f"tendon{i + 1}.gain"]) + loads[5] * p[f"tendon{i + 1}.zero"]
        guides.append((tension, offset, slope))
    return {**p, "guides": guides}
