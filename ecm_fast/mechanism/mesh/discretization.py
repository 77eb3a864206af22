"""Elements, nodes and Gauss points: how the centerline is divided, as shares of its length."""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import InputError, shown
from .families import FAMILIES, find_family, gauss_rule, integrals, lagrange, lobatto_nodes

__all__ = ["DEFAULT_ORDER", "Discretization", "lowest_order"]

# order 5 keeps 1e-6 on the presets; twice as many points as the highest order
DEFAULT_ORDER, MAX_GAUSS = 5, 12
LARGEST_ERRORS = {3: 2e-4, 4: 1e-5, 5: 5e-7, 6: 1e-8}
"""Errors of one element by its order, over the wrench box and the tendon forces of the paper, slender neck."""
MAX_ELEMENTS = 100_000  # a bound on memory: some 100 MB
SMALLEST_SHARE = 1e-9  # shorter elements differ from none by rounding alone
NO_ELEMENT = 1e-6  # places nearer to the end of an element than this are its end


@dataclass(frozen=True)
class Discretization:
    """Elements of one family and order, of any lengths.

    Attributes
    ----------
    shares : element lengths as shares of the beam's length, from the clamp; they add up to 1
    order : of the shape functions, 1 to 6
    gauss : Gauss points per element
    family : of the elements, see `families`
    """

    shares: tuple[float, ...]
    order: int
    gauss: int
    family: str = "lagrange"

    @classmethod
    def from_elements(
        cls, elements: int | ArrayLike = 1, order: int | None = None, gauss: int | None = None, family: str = "lagrange"
    ) -> "Discretization":
        """Divide a beam into `elements` equal elements, or into elements of the given relative lengths.

        The order is 5, or the family's highest, and the Gauss points are the family's, unless given.

        Raises
        ------
        InputError : names the number and what is allowed.
        """
        if isinstance(elements, (int, np.integer)) and not isinstance(elements, bool):
            if not 1 <= elements <= MAX_ELEMENTS:
                raise InputError(f"elements = {shown(elements)}: allowed is 1 to {MAX_ELEMENTS}")
            shares = (1.0 / int(elements),) * int(elements)
        else:
            shares = tuple(_shares(elements).tolist())
        kind = find_family(family)
        highest = kind.highest_order
        order = min(DEFAULT_ORDER, highest) if order is None else _count("order", order, 1, highest)
        gauss = kind.points(order) if gauss is None else _count("gauss", gauss, 1, MAX_GAUSS)
        if gauss < order:
            raise InputError(f"gauss = {gauss}: fewer points than the order, {order}, leave the element loose")
        return _kept(shares, order, gauss, kind.name)

    def __reduce__(self) -> tuple[Any, ...]:
        return _kept, (self.shares, self.order, self.gauss, self.family)  # its tables are made anew, or shared

    @property
    def n_elements(self) -> int:
        """Number of elements."""
        return len(self.shares)

    @cached_property
    def local_nodes(self) -> NDArray[np.float64]:
        """Gauss-Lobatto places of an element's nodes in [0, 1]: the interpolation that is best conditioned."""
        return lobatto_nodes(self.order)

    @cached_property
    def nodes(self) -> NDArray[np.float64]:
        """Places of all nodes, shape (n_elements * order + 1,) [share of the length].

        An inner node whose x and z are no place, see `families.Family`, has them zero in the straight beam: 0 here.
        """
        ends = np.concatenate([[0.0], np.cumsum(self.shares)])
        ends[-1] = 1.0
        inner = ends[:-1, None] + np.diff(ends)[:, None] * self.local_nodes[None, 1:]
        if not FAMILIES[self.family].inner_places:
            inner[:, :-1] = 0.0
        return np.concatenate([[0.0], inner.ravel()])

    @cached_property
    def basis(self) -> NDArray[np.float64]:
        """Lagrange polynomials on the nodes and their derivatives at the Gauss points, (2, gauss, order + 1)."""
        return lagrange(self.local_nodes, gauss_rule(self.gauss)[0])

    @cached_property
    def tables(self) -> Any:
        """Tables for the kernels at the Gauss points, in the form that the family gives them."""
        return FAMILIES[self.family].tables(self.order, self.gauss)

    @property
    def tip_order(self) -> int:
        """The power of the element length with which theory says the tip's error falls."""
        return FAMILIES[self.family].tip_order(self.order)

    @cached_property
    def mesh(self) -> NDArray[np.float64]:
        """Gauss points of the whole beam: place, weight, 1/element length, shape (n_elements * gauss, 3)."""
        points, weights = np.polynomial.legendre.leggauss(self.gauss)
        share = np.asarray(self.shares)
        start = np.concatenate([[0.0], np.cumsum(share)[:-1]])
        place = start[:, None] + share[:, None] * 0.5 * (1.0 + points)
        weight = share[:, None] * 0.5 * weights
        inverse = np.broadcast_to(1.0 / share[:, None], place.shape)
        return np.ascontiguousarray(np.stack([place, weight, inverse], axis=-1).reshape(-1, 3))

    @cached_property
    def turn(self) -> NDArray[np.float64]:
        """Integrals from 0 to each Gauss point of the polynomials that are 1 at one Gauss point, (gauss, gauss)."""
        return integrals(self.gauss, gauss_rule(self.gauss)[0])

    @cached_property
    def slopes(self) -> NDArray[np.float64]:
        """Derivative at each Gauss point by the values there of a polynomial that is 0 at 0, (gauss, gauss)."""
        return np.ascontiguousarray(np.linalg.inv(self.turn))

    @cached_property
    def halved(self) -> "Discretization":
        """The discretization whose elements are halves of these."""
        return _kept(tuple(0.5 * share for share in self.shares for _ in range(2)), self.order, self.gauss, self.family)

    def ending(self, places: tuple[float, ...]) -> "Discretization":
        """Return this discretization with more elements, such that elements end at places [shares of the length]."""
        ends = np.concatenate([[0.0], np.cumsum(self.shares)])
        new = [place for place in places if np.abs(ends - place).min() > NO_ELEMENT]
        if not new:
            return self
        return Discretization.from_elements(np.diff(np.sort([*ends, *new])), self.order, self.gauss, self.family)

    @cached_property
    def halves(self) -> NDArray[np.float64]:
        """Shares that an element of `halved` has of the Lagrange element that it is half of, (2, 2 p + 1, p + 1).

        For either half the element's shape functions at the nodes of the half, then the polynomials that are 1 at one
        Gauss point of the element, at the Gauss points of the half; these have a column less, the last is not used.
        """
        p, (points, _) = self.order, gauss_rule(self.gauss)
        table = np.zeros((2, p + 1 + self.gauss, p + 1))
        for half, begin in enumerate((0.0, 0.5)):
            table[half, : p + 1] = lagrange(self.local_nodes, begin + 0.5 * self.local_nodes)[0]
            table[half, p + 1 :, : self.gauss] = lagrange(points, begin + 0.5 * points)[0]
        return table


def lowest_order(accuracy: float) -> int:
    """Return the lowest order whose single element keeps an accuracy, see `FiniteElementModel`.

    Raises
    ------
    InputError : none does.
    """
    for order, error in LARGEST_ERRORS.items():
        if error <= accuracy:
            return order
    least = min(LARGEST_ERRORS.values())
    raise InputError(f"accuracy = {shown(accuracy)}: allowed is a number from {least:g} up; below, give more elements")


@lru_cache(maxsize=64)
def _kept(shares: tuple[float, ...], order: int, gauss: int, family: str) -> Discretization:
    """Return the discretization, whose tables cost more than a model: models of many mechanisms share them."""
    return Discretization(shares, order, gauss, family)


def _count(name: str, value: object, lowest: int, highest: int) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not lowest <= value <= highest:
        raise InputError(f"{name} = {shown(value)}: allowed is a whole number from {lowest} to {highest}")
    return int(value)


def _shares(lengths: ArrayLike) -> NDArray[np.float64]:
    """Return element lengths as shares of their sum."""
    try:
        given = np.asarray(lengths, dtype=np.float64)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.ndim == 1 and 0 < given.size <= MAX_ELEMENTS and np.all(np.isfinite(given)) and np.all(given > 0.0):
        shares: NDArray[np.float64] = given / given.max()
        shares /= shares.sum()
        if shares.min() >= SMALLEST_SHARE:
            return shares
    raise InputError(f"elements = {shown(lengths)}: allowed is a count, or positive relative lengths of which none is "
                     f"below {SMALLEST_SHARE:g} of the whole")  # fmt: skip
