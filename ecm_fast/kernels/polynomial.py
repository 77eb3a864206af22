"""Three polynomials in two or three variables: common declarations of the kernels of each degree.

con (k + 3 m,) : the center, k numbers; then for each of the three outputs its m coefficients, in the order of
    `exponents`. The variables are taken from the center on, so that a narrow range far from zero costs no digits.

    one2, one3                  (con, u, v[, w]) -> three outputs, for control loops
    one_with_slopes2, ...3      (con, u, v[, w], slopes (3, k) overwritten) -> three outputs
    many2, many3                (con, points (k, n), out (3, n) overwritten)
    many_slopes2, ...3          (con, points (k, n), out (3, k, n) overwritten)

Slopes are the derivatives of the outputs by the variables. Batches lie in columns, one variable after the other: the
compiler then loads whole vectors, and evaluates as many points at once as a vector has places.

The files are written by `tools/write_polynomial.py`: nested Horner forms without loops, because only then do the
coefficients stay in place while the loop over the points is vectorized.
"""

from itertools import combinations_with_replacement

__all__ = ["DEGREES", "exponents"]

DEGREES = (1, 2, 3, 4, 5, 6)


def exponents(k: int, degree: int) -> list[tuple[int, ...]]:
    """Return the exponents of every monomial in `k` variables up to `degree`, in the order of (47), m tuples of k.

    >>> exponents(2, 2)  # 1, x, z, x^2, x z, z^2
    [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]
    """
    chosen = (c for d in range(degree + 1) for c in combinations_with_replacement(range(k), d))
    return [tuple(c.count(variable) for variable in range(k)) for c in chosen]
