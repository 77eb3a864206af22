"""What the catalogue knows of one effect."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from ..quantity import Quantity

__all__ = ["Effect", "Enters", "Mirror", "effect"]

Enters = Literal["section", "clamp", "plate", "geometry", "force", "environment", "camera", "path"]
Mirror = Literal["even", "odd", "path"]


@dataclass(frozen=True, slots=True)
class Effect:
    """One named physical effect: its parameters and what one must know to tell it from others.

    Attributes
    ----------
    name : canonical name, as in files, reports and code
    quantities : the size first (0 = absent), then what else it needs (place, angle, time), with a default
    law : the law in one line, in the symbols of the paper
    enters : the part of the model it changes
    family : look-alikes share a family
    mirror : even or odd under exchange of left and right, or path if it depends on the order of loads
    needs : what data must hold to see it beyond tendon forces and poses
    """

    name: str
    quantities: tuple[Quantity, ...]
    law: str
    enters: Enters
    family: str
    mirror: Mirror
    needs: tuple[str, ...] = ()

    @property
    def size(self) -> Quantity:
        """The parameter whose zero means that the effect is absent."""
        return self.quantities[0]

    def __iter__(self) -> Iterator[Quantity]:
        return iter(self.quantities)


def effect(
    name: str,
    law: str,
    unit: str,
    meaning: str,
    *,
    typical: float,
    bound: float,
    enters: Enters,
    family: str,
    mirror: Mirror,
    needs: tuple[str, ...] = (),
) -> Effect:
    """Declare an effect of one parameter with symmetric bounds and default 0."""
    size = Quantity(f"effects.{name}", unit, meaning, 0.0, -bound, bound, typical, "zero")
    return Effect(name, (size,), law, enters, family, mirror, needs)
