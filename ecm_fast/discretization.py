"""Elements, nodes and Gauss points: how the centerline is divided, as shares of its length."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InputError, shown

__all__ = ["MAX_ORDER", "Discretization"]

MAX_ORDER = 6
MAX_ELEMENTS = 100_000
SMALLEST_SHARE = 1e-9


@dataclass(frozen=True)
class Discretization:
    """Lagrange elements of one order, of any lengths.

    Attributes
    ----------
    shares : element lengths as shares of the beam's length, from the clamp; they add up to 1
    order : of the shape functions, 1 to 6
    gauss : Gauss points per element; as many as the order neither locks nor wastes
    """

    shares: tuple[float, ...]
    order: int
    gauss: int

    @classmethod
    def of(cls, elements: int | ArrayLike = 1, order: int = 5, gauss: int | None = None) -> "Discretization":
        """Divide a beam into `elements` equal elements, or into elements of the given relative lengths.

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
        order = _count("order", order, 1, MAX_ORDER)
        gauss = order if gauss is None else _count("gauss", gauss, 1, 2 * MAX_ORDER)
        if gauss < order:
            raise InputError(f"gauss = {gauss}: fewer points than the order, {order}, leave the element loose")
        return _kept(shares, order, gauss)

    @property
    def n_elements(self) -> int:
        """How many elements there are."""
        return len(self.shares)

    @cached_property
    def local_nodes(self) -> NDArray[np.float64]:
        """Gauss-Lobatto places of an element's nodes in [0, 1]: the interpolation that is best conditioned."""
        inner = np.polynomial.legendre.Legendre.basis(self.order).deriv().roots().real
        return 0.5 * (1.0 + np.concatenate([[-1.0], inner, [1.0]]))

    @cached_property
    def nodes(self) -> NDArray[np.float64]:
        """Places of all nodes, shape (n_elements * order + 1,) [share of the length]."""
        ends = np.concatenate([[0.0], np.cumsum(self.shares)])
        ends[-1] = 1.0
        inner = ends[:-1, None] + np.diff(ends)[:, None] * self.local_nodes[None, 1:]
        return np.concatenate([[0.0], inner.ravel()])

    @cached_property
    def basis(self) -> NDArray[np.float64]:
        """Shape functions and their derivatives at the Gauss points, shape (2, gauss, order + 1)."""
        points = 0.5 * (1.0 + np.polynomial.legendre.leggauss(self.gauss)[0])
        return lagrange(self.local_nodes, points)

    @cached_property
    def tables(self) -> NDArray[np.float64]:
        """What the kernels need at the Gauss points: `basis` and `_lift`, shape (3, gauss, order + 1)."""
        return np.concatenate([self.basis, self._lift[None]])

    @cached_property
    def _lift(self) -> NDArray[np.float64]:
        """Integrals from 0 to each node of the polynomials that are 1 at one Gauss point, (gauss, order + 1).

        They rebuild an element's positions from the slopes at its Gauss points, exactly. With more points than the
        order no positions have arbitrary slopes there: then all zero.
        """
        if self.gauss != self.order:
            return np.zeros((self.gauss, self.order + 1))
        return self._integrals(self.local_nodes).T

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
        return self._integrals(0.5 * (1.0 + np.polynomial.legendre.leggauss(self.gauss)[0]))

    @cached_property
    def slopes(self) -> NDArray[np.float64]:
        """Derivative at each Gauss point by the values there of a polynomial that is 0 at 0, (gauss, gauss)."""
        return np.ascontiguousarray(np.linalg.inv(self.turn))

    def _integrals(self, upper: NDArray[np.float64]) -> NDArray[np.float64]:
        """Integrals from 0 to `upper` of the polynomials that are 1 at one Gauss point, (len(upper), gauss)."""
        points = 0.5 * (1.0 + np.polynomial.legendre.leggauss(self.gauss)[0])
        degree = np.arange(1, self.gauss + 1)
        return (upper[:, None] ** degree / degree) @ np.linalg.inv(np.vander(points, increasing=True))


@lru_cache(maxsize=16)
def _kept(shares: tuple[float, ...], order: int, gauss: int) -> Discretization:
    """Return the discretization, whose tables cost more than a model: models of many mechanisms share them."""
    return Discretization(shares, order, gauss)


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


def lagrange(nodes: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lagrange polynomials on `nodes` and their derivatives, (29) for two nodes, at `places`.

    Returns shape (2, n_places, n_nodes): values, derivatives.
    """
    out = np.empty((2, len(places), len(nodes)))
    for a, own in enumerate(nodes):
        others = np.delete(nodes, a)
        out[0, :, a] = np.prod((places[:, None] - others) / (own - others), axis=1)
        slopes = [
            np.prod((places[:, None] - np.delete(others, k)) / (own - np.delete(others, k)), axis=1) / (own - other)
            for k, other in enumerate(others)
        ]
        out[1, :, a] = np.sum(slopes, axis=0)
    return out
