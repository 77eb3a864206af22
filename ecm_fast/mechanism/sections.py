"""Sections of a mechanism: every number with its unit, default, bounds and source."""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal

from ..errors import InputError, did_you_mean, shown
from .body import ROUTES, SHAPES, SLOTS
from .catalogue import CATALOGUE
from .quantity import Quantity, Status

__all__ = [
    "AXIAL_LAWS",
    "CHOICES",
    "EFFECT_QUANTITIES",
    "PRESETS",
    "SECTIONS",
    "STIFFNESSES",
    "Beam",
    "Gravity",
    "Head",
    "Tendons",
    "quantities",
]

AXIAL_LAWS = ("neo-hookean", "hooke")
"""Names of the axial laws; the place in this tuple is the law's number in the parameter vector."""
CHOICES = {
    "beam.axial_law": AXIAL_LAWS,
    **{f"{slot}.shape": SHAPES for slot, (kind, _) in SLOTS.items() if kind == "segment"},
    **{f"{slot}.route": ROUTES for slot, (kind, _) in SLOTS.items() if kind == "tendon"},
}
"""Entries of the vector that are words, and the words by their number."""


def _quantity(
    key: str,
    unit: str,
    meaning: str,
    default: float,
    status: Status,
    source: str,
    *,
    bounds: tuple[float, float],
    typical: float,
) -> Any:
    """Declare a dataclass field that is an entry of the parameter vector."""
    entry = Quantity(key, unit, meaning, default, *bounds, typical, status, source)
    return field(default=default, metadata={"quantity": entry})


class _Section:
    """A group of quantities; checks every one when it is made."""

    def __post_init__(self) -> None:
        for entry in quantities(type(self)):
            object.__setattr__(self, entry.name, entry.check(getattr(self, entry.name)))


STIFFNESSES = ("EA", "GA", "EI")
"""Stiffnesses that material tests identify."""

_STIFFNESS = (1e-12, 1e15)  # [N, N m^2] bounds that refuse zero and overflow, and no mechanism
_PLACE = (-1e3, 1e3)  # [m] bounds that refuse overflow, and no mechanism


@dataclass(frozen=True)
class Beam(_Section):
    """The silicone block: a planar Timoshenko beam, clamped at its foot, straight along e_x when unloaded."""

    length: float = _quantity(
        "beam.length", "m", "length of the undeformed centerline, L", 0.109, "found",
        "the group's later open hardware", bounds=(1e-6, 1e6), typical=1e-3,
    )  # fmt: skip
    EA: float = _quantity(
        "beam.EA", "N", "axial stiffness", 7500.0, "stated",
        "Section 2.4: 7500 N; Table 1: 7448.94 N at 28 mm, 7591.09 N at 40 mm", bounds=_STIFFNESS, typical=75.0,
    )  # fmt: skip
    GA: float = _quantity(
        "beam.GA", "N", "shear stiffness", 2420.0, "stated",
        "Table 1: 2405 N and 2422 N", bounds=_STIFFNESS, typical=17.0,
    )  # fmt: skip
    EI: float = _quantity(
        "beam.EI", "N m^2", "bending stiffness", 3.0, "stated",
        "Table 1: 2.993 N m^2 and 3.003 N m^2", bounds=_STIFFNESS, typical=0.01,
    )  # fmt: skip
    mass_per_length: float = _quantity(
        "beam.mass_per_length", "kg/m", "mass per undeformed length, rho A", 9.47, "assumed",
        "1100 kg/m^3 times A = 8.610e-3 m^2, which 7500/871080 gives", bounds=(0.0, 1e6), typical=1.0,
    )  # fmt: skip
    axial_law: Literal["neo-hookean", "hooke"] = field(
        default="neo-hookean",
        metadata={
            "quantity": Quantity(
                "beam.axial_law", "-", "axial law (19): 0 neo-Hookean, 1 Hooke", 0.0, 0.0, 1.0, 1.0, "stated",
                "(19)",
            )
        },
    )  # fmt: skip

    def __post_init__(self) -> None:
        if self.axial_law not in AXIAL_LAWS:
            allowed = " or ".join(repr(law) for law in AXIAL_LAWS)
            hint = did_you_mean(self.axial_law, AXIAL_LAWS) if isinstance(self.axial_law, str) else ""
            raise InputError(f"beam.axial_law = {shown(self.axial_law)}: allowed is {allowed}{hint}")
        super().__post_init__()


@dataclass(frozen=True)
class Head(_Section):
    """The head, rigid, with its center of mass S at Q + h e_x^H + b e_z^H."""

    mass: float = _quantity(
        "head.mass", "kg", "mass of the head, m_H", 1.0, "assumed", "not given",
        bounds=(0.0, 1e6), typical=0.1,
    )  # fmt: skip
    h: float = _quantity(
        "head.h", "m", "height of the center of mass above Q, along e_x^H", 0.05, "assumed", "not given",
        bounds=_PLACE, typical=0.01,
    )  # fmt: skip
    b: float = _quantity(
        "head.b", "m", "sideways place of the center of mass, along e_z^H", 0.0, "assumed", "not given",
        bounds=_PLACE, typical=0.005,
    )  # fmt: skip


@dataclass(frozen=True)
class Tendons(_Section):
    """Two tendons from P = Q + d e_z^H (left) and R = Q - d e_z^H (right) to their pulleys."""

    plate_half_width: float = _quantity(
        "tendons.plate_half_width", "m", "half the width of the head plate, d", 0.070, "derived",
        "11 N m / 160 N, rounded", bounds=(0.0, 1e3), typical=1e-3,
    )  # fmt: skip
    pulley_x: float = _quantity(
        "tendons.pulley_x", "m", "x of both pulley centers", 0.0, "assumed", "level with the clamp",
        bounds=_PLACE, typical=2e-3,
    )  # fmt: skip
    pulley_z: float = _quantity(
        "tendons.pulley_z", "m", "z of the left pulley's center; the right one has -z", 0.070, "assumed",
        "tendons parallel to the beam at rest", bounds=_PLACE, typical=2e-3,
    )  # fmt: skip
    pulley_radius: float = _quantity(
        "tendons.pulley_radius", "m", "radius of the pulleys; the tendon runs on the outer side", 0.0, "assumed",
        "0 is a point; 0.0055 m was found on a sister machine", bounds=(0.0, 1e3), typical=5e-3,
    )  # fmt: skip


@dataclass(frozen=True)
class Gravity(_Section):
    """Gravity acts along -(cos tilt, sin tilt) in (x, z)."""

    g: float = _quantity(
        "gravity.g", "m/s^2", "acceleration of gravity", 9.81, "assumed", "not given",
        bounds=(-1e4, 1e4), typical=0.01,
    )  # fmt: skip
    tilt: float = _quantity(
        "gravity.tilt", "rad", "angle by which gravity is turned in the plane: pi where the body hangs", 0.0, "assumed",
        "the paper's neck stands upright", bounds=(-100.0, 100.0), typical=0.02,
    )  # fmt: skip


SECTIONS: dict[str, type[Any]] = {"beam": Beam, "head": Head, "tendons": Tendons, "gravity": Gravity}
EFFECT_QUANTITIES: dict[str, Quantity] = {entry.name: entry for effect in CATALOGUE.values() for entry in effect}


def quantities(section: type[Any]) -> Iterator[Quantity]:
    """Yield the numeric quantities a section declares, in order."""
    for item in fields(section):
        if item.type in (float, "float"):
            yield item.metadata["quantity"]


def _length(default: float, status: Status, source: str) -> Quantity:
    entry: Quantity = next(quantities(Beam))
    return replace(entry, default=default, status=status, source=source)


PRESETS: dict[str, dict[str, Quantity]] = {
    "slender": {"beam.length": next(quantities(Beam))},
    "paper": {
        "beam.length": _length(
            0.040,
            "derived",
            "Section 3 finds errors above 2 % only within +-2 N: here within 2.9 N, 1.9 N at 37 mm, 327 N at 109 mm",
        )
    },
}
"""Values of each preset, and why; everything else is the default of its quantity."""
