"""Three polynomials in two or three variables: evaluation, derivatives, and their regression, conservative or not."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, shown
from ...kernels.polynomial import DEGREES, Kernels, exponents, kernels_of

__all__ = ["Polynomial", "energy_regression", "monomials", "regression"]

Array = NDArray[np.float64]

RESOLVED = 1e-12
"""A combination of terms that the rows show this much less than the best shown one is rounding, not data."""


@dataclass(frozen=True, eq=False)
class Polynomial:
    """Three outputs, each a polynomial in the distances of k variables from a center.

    Attributes
    ----------
    center : (k,) k is 2 or 3
    coefficients : (3, m) in the order of `kernels.polynomial.exponents`
    """

    center: Array
    coefficients: Array

    @classmethod
    def gradient(cls, center: Array, energy: Array) -> Self:
        """Return the gradient of a polynomial in three variables: its coefficients (m,), one degree higher."""
        exponent_rows = exponents(3, degree_of(3, energy.size))
        below = {powers: i for i, powers in enumerate(exponents(3, degree_of(3, energy.size) - 1))}
        coefficients = np.zeros((3, len(below)))
        for powers, term in zip(exponent_rows, energy, strict=True):
            for v in range(3):
                if powers[v]:
                    lower = tuple(p - (i == v) for i, p in enumerate(powers))
                    coefficients[v, below[lower]] = powers[v] * term
        return cls(center, coefficients)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.center, self.coefficients)  # without the kernels that it has found

    @cached_property
    def degree(self) -> int:
        """The highest sum of exponents."""
        return degree_of(self.center.size, self.coefficients.shape[1])

    def __call__(self, points: Array) -> Array:
        """Return the outputs at points (n, k), (n, 3)."""
        out = np.empty((3, len(points)))
        self._kernels.many(self._con, _columns(points), out)
        return out.T

    def slopes(self, points: Array) -> Array:
        """Return the derivatives of the outputs by the variables at points (n, k), (n, 3, k)."""
        out = np.empty((3, self.center.size, len(points)))
        self._kernels.many_slopes(self._con, _columns(points), out)
        return np.moveaxis(out, 2, 0)

    def stepper(self, *, slopes: bool = False) -> Callable[..., tuple[float, float, float]]:
        """Return the compiled function of k floats; with slopes also of an array (3, k) that it overwrites."""
        return partial(self._kernels.one_with_slopes if slopes else self._kernels.one, self._con)

    @cached_property
    def _con(self) -> Array:
        return np.concatenate([self.center, self.coefficients.ravel()])

    @property
    def _kernels(self) -> Kernels:
        return kernels_of(self.center.size, self.degree)


def degree_of(k: int, m: int) -> int:
    """Return the degree at which polynomials in `k` variables have `m` coefficients."""
    return next(degree for degree in range(DEGREES[-1] + 2) if len(exponents(k, degree)) == m)


def monomials(points: Array, degree: int) -> Array:
    """Return every monomial up to `degree` at points (n, k), (n, m)."""
    values: Array = np.prod(points[:, None, :] ** np.array(exponents(points.shape[1], degree)), axis=2)
    return values


def regression(
    points: Array, values: Array, degree: int, weights: Array, names: Sequence[str]
) -> tuple[Polynomial, float]:
    """Return the three polynomials nearest to values, in the sense of least squares, and the condition number.

    Parameters
    ----------
    points : (n, k), values : (n, 3)
    weights : (n,) factors of the rows' residuals
    names : of the variables, for messages

    Raises
    ------
    InputError : the points do not determine the coefficients; says how many are needed, or what they do not show.
    """
    center, half = _box(points, names)
    exponent_rows = exponents(len(half), degree)
    _check_count(len(points), len(exponent_rows), degree)
    A = monomials((points - center) / half, degree)
    solution, condition = _least_squares(A * weights[:, None], values * weights[:, None], exponent_rows, names)
    return Polynomial(center, solution.T / np.prod(half ** np.array(exponent_rows), axis=1)), condition


def energy_regression(
    points: Array, values: Array, degree: int, weights: Array, names: Sequence[str]
) -> tuple[Array, Array, float]:
    """Return center (3,) and coefficients of the energy whose gradient, of `degree`, is nearest to values.

    The three outputs have units of their own, so each counts by its standard deviation. The energy is zero at the
    center. Otherwise as `regression`.
    """
    center, half = _box(points, names)
    exponent_rows = exponents(3, degree + 1)[1:]
    _check_count(len(points), -(-len(exponent_rows) // 3), degree)
    powers, scaled = np.array(exponent_rows), (points - center) / half
    spread = np.std(values, axis=0)
    spread[spread == 0.0] = 1.0
    rows = []
    for v in range(3):
        lower = np.maximum(powers - np.eye(3, dtype=np.int64)[v], 0)
        slope = powers[:, v] * np.prod(scaled[:, None, :] ** lower, axis=2)
        rows.append(slope * (weights[:, None] / (half[v] * spread[v])))
    right = (values / spread * weights[:, None]).T.reshape(-1, 1)
    solution, condition = _least_squares(np.concatenate(rows), right, exponent_rows, names)
    return center, np.concatenate([[0.0], solution[:, 0] / np.prod(half**powers, axis=1)]), condition


def _columns(points: Array) -> Array:
    """Return points as the kernels take them, (k, n): contiguous, and writable, or they would be compiled again."""
    columns = np.ascontiguousarray(points.T)
    return columns if columns.flags.writeable else columns.copy()


def _box(points: Array, names: Sequence[str]) -> tuple[Array, Array]:
    """Return center and half widths (k,) of the box around points."""
    if len(points) == 0:
        raise InputError("no rows to fit to")
    lower, upper = points.min(axis=0), points.max(axis=0)
    half = 0.5 * (upper - lower)
    if not half.all():
        v = int(np.argmin(half))
        raise InputError(f"{names[v]} is {points[0, v]:.6g} in all of {len(points)} rows: rows that vary it are needed")
    return 0.5 * (lower + upper), half


def _check_count(rows: int, needed: int, degree: int) -> None:
    if rows < needed:
        raise InputError(f"{rows} rows do not determine a polynomial of degree {degree}: at least {needed} are needed")


def _least_squares(
    A: Array, right: Array, powers: Sequence[tuple[int, ...]], names: Sequence[str]
) -> tuple[Array, float]:
    """Return the solution (m, q) for right sides (n, q), and the condition number of A's columns at equal length."""
    size = np.linalg.norm(A, axis=0)
    left, s, back = np.linalg.svd(A / np.where(size > 0.0, size, 1.0), full_matrices=False)
    if not s[-1] > RESOLVED * s[0]:
        largest = np.argsort(-np.abs(back[-1]))[:3]
        seen = [_term(powers[i], names) for i in sorted(largest) if abs(back[-1, i]) > 0.1]
        raise InputError(f"the rows do not determine {int(np.sum(s <= RESOLVED * s[0]))} of {len(powers)} "
                         f"coefficients: what they show of the terms {', '.join(seen)} is not independent; rows that "
                         "vary them, or a lower degree, are needed")  # fmt: skip
    solution: Array = back.T @ ((left.T @ right) / s[:, None]) / size[:, None]
    return solution, float(s[0] / s[-1])


def _term(powers: tuple[int, ...], names: Sequence[str]) -> str:
    """Return a monomial as a reader writes it: ``x^2 theta``."""
    parts = [name if power == 1 else f"{name}^{power}" for name, power in zip(names, powers, strict=True) if power]
    return " ".join(parts) or "1"


def check_degree(degree: object) -> int:
    """Return the degree of a polynomial, or raise."""
    if isinstance(degree, bool) or not isinstance(degree, (int, np.integer)) or degree not in DEGREES:
        raise InputError(f"degree = {shown(degree)}: allowed is a whole number from {DEGREES[0]} to {DEGREES[-1]}")
    return int(degree)
