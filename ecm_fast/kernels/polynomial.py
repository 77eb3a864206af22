"""Three polynomials in two or three variables: nested Horner forms, written out in memory for a degree.

con (k + 3 m,) : the center, k numbers; then for each of the three outputs its m coefficients, in the order of
    `exponents`. The variables are taken from the center on, so that a narrow range far from zero costs no digits.

Batches lie in columns, one variable after the other: the compiler then loads whole vectors, and evaluates as many
points at once as a vector has places. Without loops the coefficients stay in place while the loop over the points is
vectorized.
"""

import functools
from collections.abc import Callable
from itertools import combinations_with_replacement
from typing import Any, NamedTuple

from ._jit import by_first_type, call_kernel, kernel
from .unroll import derivative, function, horner

__all__ = ["DEGREES", "Kernels", "exponents", "kernels_of"]

DEGREES = (1, 2, 3, 4, 5, 6)  # the paper's is 3; each is compiled on its own
_VARIABLES = ("u", "v", "w")


def exponents(k: int, degree: int) -> list[tuple[int, ...]]:
    """Return the exponents of every monomial in `k` variables up to `degree`, in the order of (47), m tuples of k.

    >>> exponents(2, 2)  # 1, x, z, x^2, x z, z^2
    [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]
    """
    chosen = (c for d in range(degree + 1) for c in combinations_with_replacement(range(k), d))
    return [tuple(c.count(variable) for variable in range(k)) for c in chosen]


@functools.cache
def _written_out(k: int, degree: int) -> dict[str, Callable[..., Any]]:
    """Return the functions that differ for each number of variables and degree; their first argument is the shape."""
    monomials, variables = exponents(k, degree), _VARIABLES[:k]
    m = len(monomials)
    terms = [{powers: f"c[{k + m * j + i}]" for i, powers in enumerate(monomials)} for j in range(3)]
    pairs = [(j, v) for j in range(3) for v in range(k)]
    from_center = [f"{', '.join(variables)} = point", *(f"{v} = {v} - c[{i}]" for i, v in enumerate(variables))]
    values = [horner(terms[j], variables) for j in range(3)]
    slopes = [horner(derivative(terms[j], v), variables) for j, v in pairs]
    bodies = {
        # as locals: read inside a loop that writes an array, the constants would be read again for every point
        "hoist": ("con", [f"return {', '.join(f'con[{i}]' for i in range(k + 3 * m))}"]),
        "column": ("points, i", [f"return {', '.join(f'points[{v}, i]' for v in range(k))}"]),
        "values": ("c, point", [*from_center, f"return {', '.join(values)}"]),
        "slopes": ("c, point", [*from_center, f"return {', '.join(slopes)}"]),
        "put": ("slopes, out", [f"out[{j}, {v}] = slopes[{n}]" for n, (j, v) in enumerate(pairs)]),
        "put_column": ("slopes, out, i", [f"out[{j}, {v}, i] = slopes[{n}]" for n, (j, v) in enumerate(pairs)]),
    }
    return {name: function(name, ["shape", arguments], lines, {}) for name, (arguments, lines) in bodies.items()}


def _by_shape(name: str) -> Any:
    # the shape is one tuple a variable, with one entry a degree
    return by_first_type(lambda shape: _written_out(len(shape), len(shape[0]))[name], forceinline=True)


_hoist, _column, _values, _slopes = (_by_shape(name) for name in ("hoist", "column", "values", "slopes"))
_put, _put_column = _by_shape("put"), _by_shape("put_column")


class Kernels(NamedTuple):
    """The kernels for k variables and a degree; slopes are derivatives of the outputs by the variables.

    Attributes
    ----------
    one : (con, u, v[, w]) -> three outputs, for control loops
    one_with_slopes : (con, u, v[, w], slopes (3, k) overwritten) -> three outputs
    many : (con, points (k, n), out (3, n) overwritten)
    many_slopes : (con, points (k, n), out (3, k, n) overwritten)
    """

    one: Any
    one_with_slopes: Any
    many: Any
    many_slopes: Any


@functools.cache
def kernels_of(k: int, degree: int) -> Kernels:
    """Return the kernels for `k` = 2 or 3 variables; not a call's argument, the shape costs a call nothing."""
    shape = ((0,) * degree,) * k

    @kernel
    def many(con, points, out):
        c = _hoist(shape, con)
        for i in range(points.shape[1]):
            out[0, i], out[1, i], out[2, i] = _values(shape, c, _column(shape, points, i))

    @kernel
    def many_slopes(con, points, out):
        c = _hoist(shape, con)
        for i in range(points.shape[1]):
            _put_column(shape, _slopes(shape, c, _column(shape, points, i)), out, i)

    one, one_with_slopes = (_singles_of_two if k == 2 else _singles_of_three)(shape)
    return Kernels(one, one_with_slopes, many, many_slopes)


def _singles_of_two(shape: Any) -> tuple[Any, Any]:
    @call_kernel
    def one(con, u, v):
        return _values(shape, _hoist(shape, con), (u, v))

    @call_kernel
    def one_with_slopes(con, u, v, slopes):
        c = _hoist(shape, con)
        _put(shape, _slopes(shape, c, (u, v)), slopes)
        return _values(shape, c, (u, v))

    return one, one_with_slopes


def _singles_of_three(shape: Any) -> tuple[Any, Any]:
    @call_kernel
    def one(con, u, v, w):
        return _values(shape, _hoist(shape, con), (u, v, w))

    @call_kernel
    def one_with_slopes(con, u, v, w, slopes):
        c = _hoist(shape, con)
        _put(shape, _slopes(shape, c, (u, v, w)), slopes)
        return _values(shape, c, (u, v, w))

    return one, one_with_slopes
