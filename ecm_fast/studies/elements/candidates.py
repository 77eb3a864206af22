"""Candidate discretizations: families, orders, Gauss points, uniform, graded or matched meshes.

To let the study compare a further family, give it a line in `_KINDS` and a word in `Candidate.kind`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import InputError, shown
from ...mechanism.mechanism import Mechanism
from ...mechanism.mesh.families import FAMILIES, find_family
from ...models.finite_element import FiniteElementModel

__all__ = ["Candidate", "candidates", "ending_at_jumps", "graded", "stiffness_jumps"]

_ORDERS = ("constant", "linear", "quadratic", "cubic", "quartic", "quintic", "sextic")
_NUMBERS = ("no", "one", "two", "three", "four")
# numbers of equal elements for low orders: about doubled, with the paper's 20
_MANY = (1, 2, 5, 10, 20, 40, 80, 160, 320)
_FEW = (1, 2, 3, 4, 6, 10)  # the same for high orders, which need few
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
    ("se2", 1, 1, _MANY[:-1]),
    ("strain", 2, 3, _FEW),
    ("strain", 3, 4, _FEW),
    ("strain", 4, 5, _FEW[:4]),
    ("strain", 5, 6, _FEW[:2]),
)
_GRADED_KINDS, _GRADED = (("lagrange", 1), ("lagrange", 3), ("se2", 1)), (4, 10)
_ALIGNED_KINDS = (*(("lagrange", order) for order in range(1, 6)), ("se2", 1), ("strain", 2), ("strain", 3))
_ALIGNED = (1, 4, 8, 16)  # numbers of elements whose borders lie on jumps of the stiffness


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
        """Return equal elements, with the family's own number of Gauss points unless told."""
        return cls((1.0,) * elements, order, _points(order, family) if gauss is None else gauss, family=family)

    @property
    def elements(self) -> int:
        """Number of elements."""
        return len(self.shares)

    @property
    def kind(self) -> str:
        """Name that candidates share which differ in the mesh alone."""
        points = "" if self.gauss == _points(self.order, self.family) else f", {self.gauss} Gauss points"
        words = {"lagrange": _ORDERS[self.order], "se2": "SE(2)", "strain": f"{_ORDERS[self.order - 1]}-strain"}
        return f"{words[self.family]}{points}"

    @property
    def name(self) -> str:
        """In words, as in "one quartic element"."""
        count = _NUMBERS[self.elements] if self.elements < len(_NUMBERS) else str(self.elements)
        what, _, points = self.kind.partition(",")
        mesh = "" if self.mesh == "even" else f" {self.mesh}"
        return f"{count} {what} element{'s' * (self.elements > 1)}{mesh}{',' * bool(points)}{points}"

    def model(self, mechanism: Mechanism) -> FiniteElementModel:
        """Return the finite element model of a mechanism that is divided so."""
        elements = self.elements if self.mesh == "even" else self.shares
        return FiniteElementModel(mechanism, elements, self.order, self.gauss, family=self.family)


def _points(order: int, family: str) -> int:
    return FAMILIES[family].points(order)


def candidates(mechanism: Mechanism, family: str | None = None) -> tuple[Candidate, ...]:
    """Return what is worth comparing for a mechanism: even meshes of every kind, and meshes that suit it.

    family : the only one to compare; default all
    """
    mechanism.check_pair("the study of elements")
    only = None if family is None else find_family(family).name
    found = [Candidate.even(count, order, gauss, name) for name, order, gauss, counts in _KINDS for count in counts]
    jumps = stiffness_jumps(mechanism)
    place = float(np.mean(jumps)) if jumps else 0.0
    to = "graded to the soft spot" if jumps else "graded to the clamp"
    found += [
        Candidate(graded(n, place), order, _points(order, name), to, name)
        for name, order in _GRADED_KINDS
        for n in _GRADED
    ]
    if jumps:
        meshes = dict.fromkeys(ending_at_jumps(mechanism, n) for n in _ALIGNED)
        found += [
            Candidate(mesh, order, _points(order, name), "ending at jumps", name)
            for name, order in _ALIGNED_KINDS
            for mesh in meshes
        ]
    return tuple(candidate for candidate in found if only in (None, candidate.family))


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
    return (length * lengths / lengths.sum() if count else lengths).tolist()  # type: ignore[no-any-return]  # a list
