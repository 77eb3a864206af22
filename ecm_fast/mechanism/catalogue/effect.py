"""The record of one effect of the catalogue."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

from ..quantity import Quantity

__all__ = ["Effect", "Enters", "Mirror", "also", "effect"]

Enters = Literal["section", "clamp", "plate", "geometry", "force", "environment", "camera", "path"]
Mirror = Literal["even", "odd", "mixed", "path"]


@dataclass(frozen=True, slots=True)
class Effect:
    """One named physical effect: its parameters and what one must know to tell it from others.

    Attributes
    ----------
    name : canonical name, as in files, reports and code
    quantities : the size first (0 = absent), then what else it needs (place, angle, time), with a default
    law : the law in one line, in the symbols of the paper; ``a`` is the size
    enters : the part of the model it changes
    group : look-alikes share a group
    mirror : even or odd under exchange of left and right, mixed, or path if it depends on the order of loads
    needs : columns that the measurements must have for it to show
    """

    name: str
    quantities: tuple[Quantity, ...]
    law: str
    enters: Enters
    group: str
    mirror: Mirror
    needs: tuple[str, ...] = ()

    @property
    def size(self) -> Quantity:
        """The parameter whose zero means that the effect is absent."""
        return self.quantities[0]

    def __iter__(self) -> Iterator[Quantity]:
        return iter(self.quantities)


def also(name: str, unit: str, meaning: str, default: float, bounds: tuple[float, float], typical: float) -> Quantity:
    """Declare a further parameter of an effect; its full key is given by `effect`."""
    return Quantity(name, unit, meaning, default, *bounds, typical, "assumed", "not given")


def effect(
    name: str,
    law: str,
    unit: str,
    meaning: str,
    *more: Quantity,
    typical: float,
    bounds: tuple[float, float],
    enters: Enters,
    group: str,
    mirror: Mirror,
    size: str = "",
    needs: tuple[str, ...] = (),
    tolerance: float = 0.0,
) -> Effect:
    """Declare an effect that is absent unless asked for.

    more : further parameters, see `also`; with them `size` names the first one
    typical : the size one expects, the scale of its prior
    bounds : what a mechanism may have, in the same unit
    tolerance : how much of it is in a build that is as drawn, one standard deviation
    """
    key = f"effects.{name}"
    key_of_size = f"{key}.{size}" if more else key
    first = Quantity(key_of_size, unit, meaning, 0.0, *bounds, typical, "zero", tolerance=tolerance)
    rest = (replace(entry, key=f"{key}.{entry.key}") for entry in more)
    return Effect(name, (first, *rest), law, enters, group, mirror, needs)
