"""Code written out in memory, run as plain Python against NumPy's linear algebra."""

import numpy as np
import pytest

from ecm_fast.kernels.unroll import BlockFactor, Code, cofactor, determinant, function, invariants


def named(stem, n):
    return [[f"{stem}{i}_{k}" for k in range(n)] for i in range(n)]


def evaluated(text, rows, matrix):
    return eval(text, {name: value for i, row in enumerate(rows) for name, value in zip(row, matrix[i], strict=True)})


@pytest.mark.parametrize("n", [1, 2, 3])
def test_small_inverses_are_those_of_numpy(n):
    """Other method: LAPACK, and the characteristic polynomial by NumPy, whose coefficients the invariants are."""
    matrix, rows = np.random.default_rng(n).normal(size=(n, n)), named("m", n)
    det = evaluated(determinant(rows), rows, matrix)
    inverse = [[evaluated(cofactor(rows, k, i), rows, matrix) / det for k in range(n)] for i in range(n)]
    np.testing.assert_allclose(inverse, np.linalg.inv(matrix), rtol=1e-12)
    found = [evaluated(text, rows, matrix) for text in invariants(rows)]
    signs = (-1.0) ** np.arange(1, n + 1)
    np.testing.assert_allclose([*found, det], np.poly(matrix)[1:] * signs, rtol=1e-10)


@pytest.mark.parametrize("size", [1, 2, 3])
@pytest.mark.parametrize("n", [1, 3, 6, 7])
@pytest.mark.parametrize("positive", [True, False])
def test_a_factorization_solves_and_certifies(n, size, positive):
    """Other method: LAPACK's solution, and the signs of its eigenvalues; pivots of one to three unknowns."""
    rng = np.random.default_rng(10 * n + size)
    vectors, _ = np.linalg.qr(rng.normal(size=(n, n)))
    eigenvalues = rng.uniform(0.5, 2.0, n)
    eigenvalues[0] *= 1.0 if positive else -1.0
    matrix, b, factor, code = (vectors * eigenvalues) @ vectors.T, rng.normal(size=n), BlockFactor(n, size), Code()
    for i, k in factor.lower_triangle():
        code.set(factor.entry(i, k), f"K[{i}, {k}]")
    for i in range(n):
        code.set(f"b{i}", f"b[{i}]")
    code.set("pivot", "float('inf')")
    factor.factorize(code)
    factor.solve(code, "b")
    code.lines.append(f"return pivot, [{', '.join(f'b{i}' for i in range(n))}]")
    pivot, solution = function("solved", ["K", "b"], code.lines, {})(matrix, b)
    np.testing.assert_allclose(solution, np.linalg.solve(matrix, b), rtol=1e-8)
    assert (pivot > 0.0) == positive
