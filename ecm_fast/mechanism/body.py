"""Parts of a robot: segments, named tendons and markers, every number with its unit and bounds.

A mechanism with any of these is a planar tendon robot: its segments stand for the beam, its named tendons for the pair
of `sections.Tendons`. Their numbers have fixed places in the parameter vector, `segment1.length` to `marker8.angle`;
0 means absent, and of a segment: as in the segment before.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import pairwise
from typing import Any, ClassVar

from ..errors import InputError, did_you_mean, shown
from .quantity import Quantity

__all__ = [
    "KINDS",
    "MARKER",
    "MOST",
    "N_POINTS",
    "PAIRS",
    "ROUTES",
    "SEGMENT",
    "SHAPES",
    "SLOTS",
    "STIFFNESSES",
    "TENDON",
    "Marker",
    "Segment",
    "Tendon",
    "check_body",
    "check_choice",
    "number_fields",
    "slot_quantities",
]

SHAPES = ("", "circle", "ring", "rectangle", "ellipse")
ROUTES = ("", "chord", "guided")
"""Names of section shapes and of routes; the place in the tuple is the number in the parameter vector."""

N_POINTS = 4  # of the offset of a guide; the vector has room for as many
MOST = {"segment": 4, "tendon": 8, "marker": 8}
"""Most of each that the parameter vector has room for."""

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,31}")
_LENGTH, _PLACE, _STIFFNESS = (0.0, 1e6), (-1e3, 1e3), (0.0, 1e15)  # refuse overflow, and no mechanism
_SIZES = {"circle": ("radius",), "ring": ("radius", "inner_radius"), "rectangle": ("width", "height"),
          "ellipse": ("width", "height")}  # fmt: skip
STIFFNESSES = ("EA", "GA", "EI", "mass_per_length")
"""Numbers of a segment in place of a shape of a material."""
PAIRS = ("radius", "inner_radius", "width", "height", *STIFFNESSES)
"""Numbers that a segment has at its start and at its end."""


def _number(unit: str, meaning: str, bounds: tuple[float, float], typical: float) -> Any:
    entry = Quantity("", unit, meaning, 0.0, *bounds, typical, "assumed", "absent unless given")
    return field(default=0.0, metadata={"quantity": entry})


def _choice(meaning: str, names: tuple[str, ...]) -> Any:
    words = ", ".join(f"{i} {name or 'absent'}" for i, name in enumerate(names))
    entry = Quantity("", "-", f"{meaning}: {words}", 0.0, 0.0, len(names) - 1.0, 1.0, "assumed", "absent unless given")
    return field(default="", metadata={"quantity": entry, "names": names})


class _Slot:
    """A part of which a mechanism has several; checks its numbers when it is made."""

    kind: ClassVar[str]

    def __post_init__(self) -> None:
        for item in fields(self):  # type: ignore[arg-type]  # every subclass is a dataclass
            if item.name == "name":
                continue
            value, entry = getattr(self, item.name), replace(item.metadata["quantity"], key=f"{self.kind}.{item.name}")
            if "names" in item.metadata:
                check_choice(entry.key, value, item.metadata["names"])
            else:
                object.__setattr__(self, item.name, entry.check(value))


def check_choice(key: str, value: object, names: tuple[str, ...]) -> None:
    """Refuse what is none of these names."""
    if not isinstance(value, str) or value not in names:
        allowed = [name for name in names if name]
        hint = did_you_mean(value, allowed) if isinstance(value, str) else ""
        raise InputError(f"{key} = {shown(value)}: allowed is {' or '.join(map(repr, allowed))}{hint}")


@dataclass(frozen=True)
class Segment(_Slot):
    """A part of the body, from the clamp on: by a shape of a material, or by stiffnesses.

    Sizes and stiffnesses are linear from `_start` to `_end`, an end of 0 is the start. A start of 0 goes on with what
    the segment before ends with.
    """

    kind: ClassVar[str] = "segment"
    length: float = _number("m", "length of the undeformed segment", _LENGTH, 1e-3)
    shape: str = _choice("shape of the section", SHAPES)
    E: float = _number("N/m^2", "Young's modulus", _STIFFNESS, 1e4)
    nu: float = _number("-", "Poisson's ratio", (0.0, 0.5), 0.02)
    density: float = _number("kg/m^3", "density", (0.0, 1e5), 30.0)
    shear_factor: float = _number("-", "share of the section that shears, 0: that of its shape", (0.0, 2.0), 0.05)
    radius_start: float = _number("m", "radius at the start", _LENGTH, 1e-4)
    radius_end: float = _number("m", "radius at the end", _LENGTH, 1e-4)
    inner_radius_start: float = _number("m", "inner radius at the start", _LENGTH, 1e-4)
    inner_radius_end: float = _number("m", "inner radius at the end", _LENGTH, 1e-4)
    width_start: float = _number("m", "width across the plane at the start", _LENGTH, 1e-4)
    width_end: float = _number("m", "width across the plane at the end", _LENGTH, 1e-4)
    height_start: float = _number("m", "height in the plane at the start", _LENGTH, 1e-4)
    height_end: float = _number("m", "height in the plane at the end", _LENGTH, 1e-4)
    EA_start: float = _number("N", "axial stiffness at the start", _STIFFNESS, 10.0)
    EA_end: float = _number("N", "axial stiffness at the end", _STIFFNESS, 10.0)
    GA_start: float = _number("N", "shear stiffness at the start", _STIFFNESS, 10.0)
    GA_end: float = _number("N", "shear stiffness at the end", _STIFFNESS, 10.0)
    EI_start: float = _number("N m^2", "bending stiffness at the start", _STIFFNESS, 1e-3)
    EI_end: float = _number("N m^2", "bending stiffness at the end", _STIFFNESS, 1e-3)
    mass_per_length_start: float = _number("kg/m", "mass per undeformed length at the start", (0.0, 1e6), 0.01)
    mass_per_length_end: float = _number("kg/m", "mass per undeformed length at the end", (0.0, 1e6), 0.01)
    taper: float = _number("-", "size at the end over size at the start, 0: 1", (0.0, 1e3), 0.01)

    @property
    def stated(self) -> bool:
        """Whether stiffnesses are given, not a shape."""
        return any(getattr(self, f"{name}_start") for name in STIFFNESSES)

    @property
    def shaped(self) -> bool:
        """Whether anything of a shape is given."""
        sizes = any(getattr(self, f"{name}_start") for name in PAIRS[:4])
        return bool(self.shape or self.E or self.nu or self.density or self.shear_factor or sizes)


@dataclass(frozen=True)
class Tendon(_Slot):
    """A tendon: a free chord from the head plate to a pulley, or guided along the body without friction."""

    kind: ClassVar[str] = "tendon"
    name: str = ""
    route: str = _choice("route", ROUTES)
    plate_x: float = _number("m", "x of its point on the head plate, from Q in the head's frame", _PLACE, 1e-3)
    plate_z: float = _number("m", "z of its point on the head plate, from Q in the head's frame", _PLACE, 1e-3)
    pulley_x: float = _number("m", "x of the pulley's center", _PLACE, 2e-3)
    pulley_z: float = _number("m", "z of the pulley's center", _PLACE, 2e-3)
    pulley_radius: float = _number("m", "radius of the pulley; the tendon runs on the outer side", (0.0, 1e3), 5e-3)
    points: float = _number("-", "number of points that give the offset of the guide", (0.0, float(N_POINTS)), 1.0)
    place_1: float = _number("m", "place of the first point along the body", _LENGTH, 1e-3)
    place_2: float = _number("m", "place of the second point along the body", _LENGTH, 1e-3)
    place_3: float = _number("m", "place of the third point along the body", _LENGTH, 1e-3)
    place_4: float = _number("m", "place of the fourth point along the body", _LENGTH, 1e-3)
    offset_1: float = _number("m", "offset z of the guide at the first point", _PLACE, 2e-4)
    offset_2: float = _number("m", "offset z of the guide at the second point", _PLACE, 2e-4)
    offset_3: float = _number("m", "offset z of the guide at the third point", _PLACE, 2e-4)
    offset_4: float = _number("m", "offset z of the guide at the fourth point", _PLACE, 2e-4)
    ends_at: float = _number("m", "place where the guided tendon ends, 0: the tip plate", _LENGTH, 1e-3)
    compliance: float = _number("m/N", "compliance of the tendon itself", (0.0, 1e3), 1e-5)
    gain: float = _number("-", "lam = r (1 + gain): its force cell reads too little", (-0.9, 10.0), 0.03)
    zero: float = _number("N", "lam = r + zero: force of which its cell shows nothing, as a preload", (-1e6, 1e6), 1.0)
    shift: float = _number("m", "by how much its guides are farther along z than drawn", _PLACE, 5e-4)

    @property
    def guide(self) -> list[tuple[float, float]]:
        """Places and offsets of the guide's points [m]."""
        return [(getattr(self, f"place_{i}"), getattr(self, f"offset_{i}")) for i in range(1, int(self.points) + 1)]


@dataclass(frozen=True)
class Marker(_Slot):
    """A point fixed to a section of the body, or to the head plate."""

    kind: ClassVar[str] = "marker"
    name: str = ""
    place: float = _number("m", "place along the undeformed body", _LENGTH, 1e-3)
    on_head: float = _number("-", "1: fixed to the head plate, its place is the body's end", (0.0, 1.0), 1.0)
    offset_x: float = _number("m", "offset along the section's normal", _PLACE, 1e-3)
    offset_z: float = _number("m", "offset along the section", _PLACE, 1e-3)
    angle: float = _number("rad", "angle against the section", (-100.0, 100.0), 0.02)


KINDS: dict[str, type[Any]] = {"segment": Segment, "tendon": Tendon, "marker": Marker}
SLOTS: dict[str, tuple[str, int]] = {f"{kind}{i + 1}": (kind, i) for kind, most in MOST.items() for i in range(most)}
"""The parts by their name in the parameter vector: what kind, and which of it."""


def number_fields(kind: str) -> list[Any]:
    """Return the fields of a kind of part that are entries of the parameter vector: all but its name."""
    return [item for item in fields(KINDS[kind]) if item.name != "name"]


def slot_quantities() -> Iterator[Quantity]:
    """Yield the entries of the parameter vector for every part, in order."""
    for slot, (kind, _) in SLOTS.items():
        for item in number_fields(kind):
            yield replace(item.metadata["quantity"], key=f"{slot}.{item.name}")


class _Places:
    """Places of the numbers of a part, counted from its first; constants for kernels."""

    def __init__(self, kind: str) -> None:
        names = [item.name for item in number_fields(kind)]
        self.size = len(names)
        self.at = {name: i for i, name in enumerate(names)}

    def __getitem__(self, name: str) -> int:
        return self.at[name]


SEGMENT, TENDON, MARKER = _Places("segment"), _Places("tendon"), _Places("marker")


def check_body(
    segments: Sequence[Segment], tendons: Sequence[Tendon], markers: Sequence[Marker], beam_length: float
) -> None:
    """Refuse parts that cannot be built together; names the part, the value and what is allowed.

    beam_length : where there are no segments [m]
    """
    for kind, parts in (("segment", segments), ("tendon", tendons), ("marker", markers)):
        if len(parts) > MOST[kind]:
            raise InputError(f"{len(parts)} {kind}s: allowed are {MOST[kind]}")
    _Body(segments).check()
    length = sum(segment.length for segment in segments) or beam_length
    named_parts: dict[str, Sequence[Any]] = {"tendon": tendons, "marker": markers}
    for kind, named in named_parts.items():
        for i, part in enumerate(named):
            if not isinstance(part.name, str) or not _NAME.fullmatch(part.name):
                raise InputError(f"{kind} {i + 1}: name = {shown(part.name)}: allowed is a letter, then up to 31 "
                                 "letters, digits, _ or -")  # fmt: skip
            if part.name in [other.name for other in named[:i]]:
                raise InputError(f"{kind} {i + 1}: name = {part.name!r} is taken: give each {kind} its own")
    for tendon in tendons:
        _check_route(tendon, length)
    for marker in markers:
        if not marker.on_head and not 0.0 < marker.place <= length * (1.0 + 1e-9):
            raise InputError(f"marker {marker.name}: place = {marker.place:g} m: allowed is above 0 up to the body's "
                             f'length, {length:g} m, or "head"')  # fmt: skip


def _check_route(tendon: Tendon, length: float) -> None:
    what, most = f"tendon {tendon.name}", length * (1.0 + 1e-9)
    if not tendon.route:
        raise InputError(f"{what}: route is missing: allowed is 'chord' or 'guided'")
    if tendon.route == "chord":
        return
    if tendon.points not in range(1, N_POINTS + 1):
        raise InputError(f"{what}: points = {tendon.points:g}: allowed are 1 to {N_POINTS}")
    places = [place for place, _ in tendon.guide]
    if any(after <= before for before, after in pairwise(places)) or places[-1] > most:
        raise InputError(f"{what}: offset has the places {', '.join(f'{place:g}' for place in places)} m: allowed are "
                         f"growing places up to the body's length, {length:g} m")  # fmt: skip
    if tendon.ends_at > most:
        raise InputError(f"{what}: ends_at = {tendon.ends_at:g} m: allowed is up to the body's length, {length:g} m")


class _Body:
    """Values of each segment, with those it takes over from the segments before."""

    def __init__(self, segments: Sequence[Segment]) -> None:
        self.segments = segments

    def check(self) -> None:
        """Refuse a segment whose stiffness is not known."""
        known: dict[str, float | str] = {}
        varies: set[str] = set()
        stated = False
        for i, segment in enumerate(self.segments):
            try:
                stated = self._take_over(segment, known, varies, stated)
            except InputError as error:
                raise InputError(f"segment {i + 1}: {error}") from None

    def _take_over(self, segment: Segment, known: dict[str, Any], varies: set[str], stated: bool) -> bool:
        if segment.length <= 0.0:
            raise InputError(f"length = {segment.length:g} m: allowed is a number above 0")
        if segment.stated and segment.shaped:
            raise InputError("has stiffnesses and a shape: allowed is one of them")
        stated = segment.stated or (stated and not segment.shaped)
        for name in ("shape", "E", "nu", "density"):
            known[name] = getattr(segment, name) or known.get(name, 0.0)
        for name in PAIRS:
            start, end = getattr(segment, f"{name}_start"), getattr(segment, f"{name}_end")
            if start:
                known[name] = start
                varies.discard(name)
            if (start and end not in (0.0, start)) or (known.get(name) and segment.taper not in (0.0, 1.0)):
                if not start:
                    raise InputError(f"{name} is not given beside taper: say what it starts with")
                varies.add(name)
            elif not start and name in varies and name in self._needed(known, stated):
                raise InputError(f"{name} is missing: it changes along the segment before, so say what it is here")
        needed: tuple[str, ...] = STIFFNESSES[:3]
        if not stated:
            if not known["shape"]:
                raise InputError("shape is missing (with E, nu and sizes), or EA, GA and EI")
            needed = ("E", "nu", *_SIZES[known["shape"]])
        for name in needed:
            if not known.get(name):
                raise InputError(f"{name} is missing or 0: allowed is a number above 0")
        if known["shape"] == "ring" and not stated:
            self._check_ring(segment)
        return stated

    @staticmethod
    def _needed(known: Mapping[str, Any], stated: bool) -> Sequence[str]:
        return STIFFNESSES if stated else _SIZES.get(known["shape"], ())

    @staticmethod
    def _check_ring(segment: Segment) -> None:
        for end in ("start", "end"):
            outer, inner = getattr(segment, f"radius_{end}"), getattr(segment, f"inner_radius_{end}")
            if outer and inner >= outer:
                raise InputError(f"inner_radius = {inner:g} m: allowed is less than the radius, {outer:g} m")
