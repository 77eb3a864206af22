"""Ways to divide a beam into elements: families, orders, Gauss points, meshes even, graded or ending at jumps.

To let the study compare a further family, give it a line in `_KINDS`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .errors import InputError, shown
from .mechanism import Mechanism
from .model import FiniteElementModel

__all__ = ["Candidate", "candidates", "ending_at_jumps", "graded", "stiffness_jumps"]

_ORDERS = ("", "linear", "quadratic", "cubic", "quartic", "quintic", "sextic")
_NUMBERS = ("no", "one", "two", "three", "four")
_MANY = (1, 2, 5, 10, 20, 40, 80, 160, 320)
_FEW = (1, 2, 3, 4, 6, 10)
# family, order, Gauss points, how many elements
_KINDS: tuple[tuple[str, int, int, tuple[int, ...]], ...] = (
    ("lagrange", 1, 1, _MANY),
    ("lagrange", 1, 2, _MANY),
    ("lagrange", 2, 2, _FEW),
    ("lagrange", 2, 3, _FEW),
    ("lagrange", 3, 3, _FEW),
    ("lagrange", 4, 4, _FEW),
    ("lagrange", 5, 5, _FEW),
    ("lagrange", 6, 6, _FEW),
)
_GRADED_ORDERS, _GRADED = (1, 3), (4, 10)
_ALIGNED_ORDERS, _ALIGNED = (1, 2, 3, 4, 5), (1, 4, 8, 16)


@dataclass(frozen=True)
class Candidate:
    """One discretization that is compared with others.

    Attributes
    ----------
    shares : element lengths from the clamp, in any unit
    order, gauss : of the shape functions, and Gauss points per element
    mesh : "even", "graded to the clamp", "graded to the soft spot" or "ending at jumps"
    family : of the elements, as `FiniteElementModel` calls it
    """

    shares: tuple[float, ...]
    order: int
    gauss: int
    mesh: str = "even"
    family: str = "lagrange"

    @classmethod
    def even(cls, elements: int, order: int, gauss: int | None = None, family: str = "lagrange") -> "Candidate":
        """Return equal elements."""
        return cls((1.0,) * elements, order, order if gauss is None else gauss, family=family)

    @property
    def elements(self) -> int:
        """How many elements there are."""
        return len(self.shares)

    @property
    def kind(self) -> str:
        """What candidates share that differ in the mesh alone."""
        of_family = "" if self.family == "lagrange" else f"{self.family} "
        points = "" if self.gauss == self.order else f", {self.gauss} Gauss points"
        return f"{of_family}{_ORDERS[self.order]}{points}"

    @property
    def name(self) -> str:
        """In words, as in "one quartic element"."""
        count = _NUMBERS[self.elements] if self.elements < len(_NUMBERS) else str(self.elements)
        what, _, points = self.kind.partition(",")
        mesh = "" if self.mesh == "even" else f" {self.mesh}"
        return f"{count} {what} element{'s' * (self.elements > 1)}{mesh}{',' * bool(points)}{points}"

    def model(self, mechanism: Mechanism) -> FiniteElementModel:
        """Return the finite element model of a mechanism that is divided so."""
        family: dict[str, Any] = {} if self.family == "lagrange" else {"family": self.family}
        even = self.mesh == "even"
        return FiniteElementModel(mechanism, self.elements if even else self.shares, self.order, self.gauss, **family)


def candidates(mechanism: Mechanism) -> tuple[Candidate, ...]:
    """Return what is worth comparing for a mechanism: even meshes of every kind, and meshes that suit it."""
    found = [Candidate.even(count, order, gauss, family) for family, order, gauss, counts in _KINDS for count in counts]
    jumps = stiffness_jumps(mechanism)
    place = float(np.mean(jumps)) if jumps else 0.0
    to = "graded to the soft spot" if jumps else "graded to the clamp"
    found += [Candidate(graded(n, place), order, order, to) for order in _GRADED_ORDERS for n in _GRADED]
    if jumps:
        meshes = dict.fromkeys(ending_at_jumps(mechanism, n) for n in _ALIGNED)
        found += [Candidate(mesh, p, p, "ending at jumps") for p in _ALIGNED_ORDERS for mesh in meshes]
    return tuple(found)


def stiffness_jumps(mechanism: Mechanism) -> tuple[float, ...]:
    """Return where the stiffness jumps between clamp and tip [shares of the length]."""
    spot = {name: mechanism.effects.get(f"soft_spot.{name}") for name in ("size", "place", "width")}
    if spot["size"] is None:
        return ()
    middle = 1.0 / 3.0 if spot["place"] is None else spot["place"]
    half = 0.5 * (0.015 if spot["width"] is None else spot["width"]) / mechanism.beam.length
    return tuple(end for end in (middle - half, middle + half) if 0.0 < end < 1.0 and half > 0.0)


def ending_at_jumps(mechanism: Mechanism, elements: int) -> tuple[float, ...]:
    """Return element lengths near 1/`elements` of the beam, with an element's end at every jump of the stiffness."""
    ends = (0.0, *stiffness_jumps(mechanism), 1.0)
    pieces = [(length, max(1, round(length * elements))) for length in np.diff(ends).tolist()]
    return tuple(length / count for length, count in pieces for _ in range(count))


def graded(elements: int, place: float, growth: float = 1.3) -> tuple[float, ...]:
    """Return element lengths that grow by a factor from element to element, away from a place.

    elements : how many, two at least
    place : share of the length, from 0 at the clamp to 1 at the tip
    """
    if elements < 2 or not 0.0 <= place <= 1.0:
        raise InputError(f"elements = {shown(elements)}, place = {shown(place)}: allowed are 2 or more and 0 to 1")
    before = round(elements * place) if place in (0.0, 1.0) else min(max(1, round(elements * place)), elements - 1)
    sides = _growing(before, place, growth)[::-1], _growing(elements - before, 1.0 - place, growth)
    return tuple(length for side in sides for length in side)


def _growing(count: int, length: float, growth: float) -> Sequence[float]:
    lengths = growth ** np.arange(count)
    return (length * lengths / lengths.sum() if count else lengths).tolist()  # type: ignore[no-any-return]
