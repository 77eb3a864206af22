"""The mechanism: beam, head, tendons, gravity, effects; SI units and radians, validated, immutable."""

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Self

from ..errors import InputError, did_you_mean, shown
from .body import SLOTS, Marker, Segment, Tendon, check_body
from .catalogue import CATALOGUE
from .derived import check_derived
from .parameters import find
from .sections import EFFECT_QUANTITIES, PRESETS, SECTIONS, Beam, Gravity, Head, Tendons
from .toml_file import ROBOTS, read_values, robot_file, write_values

__all__ = ["PARTS", "Effects", "Mechanism"]

PARTS = {"segment": "segments", "tendon": "named_tendons", "marker": "markers"}
"""Attributes of a mechanism that hold the parts of a body, by what is in them."""


class Effects(Mapping[str, float]):
    """The effects that are present: an immutable mapping from a parameter's name to its value."""

    __slots__ = ("_values",)

    def __init__(self, values: Mapping[str, float] | None = None) -> None:
        given = dict(values or {})
        for name in given:
            if name not in EFFECT_QUANTITIES:
                raise InputError(f"effects.{name}: no such effect{did_you_mean(name, EFFECT_QUANTITIES)}")
        checked = {name: entry.check(given[name]) for name, entry in EFFECT_QUANTITIES.items() if name in given}
        self._values = {name: value for name, value in checked.items() if value != EFFECT_QUANTITIES[name].default}

    def __getitem__(self, name: str) -> float:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __hash__(self) -> int:
        return hash(tuple(self._values.items()))

    def __repr__(self) -> str:
        return f"Effects({self._values})"

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored_effects, (self._values,)


def _restored_effects(values: Mapping[str, float]) -> Effects:
    """Return effects that come from a pickle, perhaps of a process that had added some of its own."""
    unknown = [name for name in values if name not in EFFECT_QUANTITIES]
    if unknown:
        raise InputError(f"effects.{unknown[0]}: no such effect in this process: where it is one of your own, run what "
                         "adds it (ecm_fast.effect) before you load what has it")  # fmt: skip
    return Effects(values)


@dataclass(frozen=True)
class Mechanism:
    """A neck, or a planar tendon robot. Every number is one entry of the flat parameter vector (see `parameters`).

    Attributes
    ----------
    beam, head, tendons, gravity, effects : the sections
    segments : of the body, from the clamp on; empty: the body is `beam`
    named_tendons : instead of the pair `tendons`; empty with segments: there are none
    markers : points whose places are measured
    assumed : names of values that a mechanism file does not give though an answer can depend on them, so that they are
        the preset's; empty where the file names its preset. The command line lists them in one line

    Examples
    --------
    >>> neck = Mechanism.preset("slender").replace(EI=2.9, precurvature=0.2)
    >>> neck.beam.EI, neck.effects["precurvature"]
    (2.9, 0.2)
    """

    beam: Beam = field(default_factory=Beam)
    head: Head = field(default_factory=Head)
    tendons: Tendons = field(default_factory=Tendons)
    gravity: Gravity = field(default_factory=Gravity)
    effects: Effects = field(default_factory=Effects)
    segments: tuple[Segment, ...] = ()
    named_tendons: tuple[Tendon, ...] = ()
    markers: tuple[Marker, ...] = ()
    assumed: tuple[str, ...] = field(default=(), compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.effects:
            check_derived(self.values())
        if self.segments or self.named_tendons or self.markers:
            check_body(self.segments, self.named_tendons, self.markers, self.beam.length)
            self._check_effects()

    def _check_effects(self) -> None:
        """Refuse effects of the pair of tendons on a mechanism that has none."""
        if self.has_pair:
            return
        for name in self.effects:
            effect = CATALOGUE[name.split(".")[0]]
            if effect.enters in ("geometry", "force") and effect.name != "beam_length":
                raise InputError(f"effects.{name}: it acts on the pair of [tendons], which this mechanism has not; a "
                                 "[[tendon]] has numbers of its own: gain, zero, shift, pulley")  # fmt: skip

    @property
    def has_pair(self) -> bool:
        """Whether the two tendons are the pair of the section `tendons`."""
        return not (self.segments or self.named_tendons)

    def check_pair(self, what: str) -> None:
        """Refuse a robot where `what` knows a neck alone."""
        if not self.has_pair:
            raise InputError(f"{what}: allowed for a neck with the pair of [tendons]; this mechanism is a robot with "
                             "[[tendon]]s or [[segment]]s of its own")  # fmt: skip

    @property
    def tendon_names(self) -> tuple[str, ...]:
        """Names of the tendons, in the order of tendon forces."""
        return ("l", "r") if self.has_pair else tuple(tendon.name for tendon in self.named_tendons)

    @property
    def length(self) -> float:
        """Length of the undeformed body [m]."""
        body = sum(segment.length for segment in self.segments) or self.beam.length
        return body + self.effects.get("beam_length", 0.0)

    @classmethod
    def preset(cls, name: str = "slender") -> Self:
        """Return a preset: ``slender`` (L 0.109 m) or ``paper`` (L 0.040 m)."""
        if name not in PRESETS:
            allowed = " or ".join(repr(preset) for preset in PRESETS)
            raise InputError(f"preset = {shown(name)}: allowed is {allowed}{did_you_mean(str(name), PRESETS)}")
        return cls().replace(**{key: entry.default for key, entry in PRESETS[name].items()})

    @classmethod
    def robot(cls, name: str) -> Self:
        """Return a robot to start from: ``tentacle``, ``segments`` or ``finger``; ``init --robot`` writes its file."""
        robot_file(name)  # complains about the name
        return cls.from_toml(ROBOTS[name])

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> Self:
        """Read a mechanism file; every key is optional.

        Raises
        ------
        InputError : the file cannot be read, is not TOML, or holds a key or value that cannot be; one line with
            file, key, value and what is allowed.
        """
        preset, changes, parts = read_values(path)
        try:
            found = cls.preset(preset or "slender")
            if parts.get("segment"):  # a body of its own: no head, unless one is given
                found = found.replace(mass=0.0, h=0.0)
            given: dict[str, Any] = {PARTS[kind]: of_kind for kind, of_kind in parts.items()}
            found = replace(found, **given).replace(**changes)
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
        return found if preset else replace(found, assumed=found._missing(changes))

    def _missing(self, given: Mapping[str, Any]) -> tuple[str, ...]:
        """Return the names of values that are not given and that some answer depends on."""
        without = {"head.h", "head.b"} if self.head.mass == 0.0 else set[str]()
        if self.gravity.g == 0.0 and "gravity.g" in given:
            without |= {"beam.mass_per_length", "head.mass", "head.h", "head.b", "gravity.tilt"}
        without |= {"gravity.tilt"} | ({"head.mass"} if self.segments else set())
        names = (name for name in self.values() if name.split(".")[0] in SECTIONS)
        return tuple(name for name in names if name not in given and name not in without)

    def to_toml(self, path: str | os.PathLike[str], remarks: Iterable[str] = ()) -> None:
        """Write a mechanism file that reads back to exactly this mechanism, with `remarks` as comments at its top."""
        write_values(self.values(), path, remarks, {kind: getattr(self, parts) for kind, parts in PARTS.items()})

    def values(self) -> dict[str, float | str]:
        """Return every value of the sections and every effect that is present, by its full name: ``beam.EI``."""
        parts = {section: getattr(self, section) for section in SECTIONS}
        if not self.has_pair:
            del parts["tendons"]
        parts |= {slot: part for slot in SLOTS if (part := self._part(slot)) is not None}
        values = {
            f"{name}.{item.name}": getattr(part, item.name)
            for name, part in parts.items()
            for item in fields(part)
            if "quantity" in item.metadata and not (name == "beam" and self.segments and item.name != "axial_law")
        }
        return values | {f"effects.{name}": value for name, value in self.effects.items()}

    def _part(self, slot: str) -> Any:
        """Return a part of the body by its name in the vector; None where there is none."""
        kind, number = SLOTS[slot]
        parts = getattr(self, PARTS[kind])
        return parts[number] if number < len(parts) else None

    def key_of(self, name: str) -> str:
        """Return the full name of a value that is named by a tendon or marker: ``front.zero`` -> ``tendon1.zero``."""
        owner, _, entry = name.partition(".")
        for kind in ("tendon", "marker"):
            for i, part in enumerate(getattr(self, PARTS[kind])):
                if part.name == owner:
                    return f"{kind}{i + 1}.{entry}"
        return name

    def replace(self, **changes: float | str) -> Self:
        """Return a mechanism with some values changed, named as in `parameters` (short or dotted).

        Raises
        ------
        InputError : no such name, a value out of its bounds, or a sum of several that is impossible, see `derived`;
            names it and says what is allowed.
        """
        grouped: dict[str, dict[str, Any]] = {}
        for name, value in changes.items():
            section, _, entry = find(self.key_of(name)).key.partition(".")
            grouped.setdefault(section, {})[entry] = value
        effects = grouped.pop("effects", {})
        changed: dict[str, Any] = {}
        for section, new in grouped.items():
            if section not in SLOTS:
                changed[section] = replace(getattr(self, section), **new)
                continue
            kind, number = SLOTS[section]
            parts = list(changed.get(PARTS[kind], getattr(self, PARTS[kind])))
            if number >= len(parts):
                raise InputError(f"{section}.{next(iter(new))}: this mechanism has {len(parts)} {kind}s")
            parts[number] = replace(parts[number], **new)
            changed[PARTS[kind]] = tuple(parts)
        if effects:
            changed["effects"] = Effects({**self.effects, **effects})
        return replace(self, **changed)
