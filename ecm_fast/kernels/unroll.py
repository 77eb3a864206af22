"""Kernels written out in memory: code without loops, for a number of Gauss points or a degree that a type carries.

LLVM vectorizes a loop over load cases only where nothing is left to unroll inside it, and unrolls less than these
kernels need: plain loops cost up to twice the time. A type is known while a kernel is compiled, so the number is the
length of a tuple, and `_jit.by_first_type` lets the tuple's type choose a function that is written here, compiled
with its caller and kept in the caller's cache.

Matrices are names, one for each entry: `K2_1`. What is here holds for any number of unknowns, directions, and unknowns
to a pivot; what is special to a formulation stands beside it, as in `condensed.equations`.
"""

import inspect
import linecache
import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from ._jit import by_first_type

__all__ = [
    "BlockFactor",
    "Code",
    "Terms",
    "at_each_point",
    "cofactor",
    "derivative",
    "determinant",
    "dot",
    "function",
    "horner",
    "invariants",
    "total",
]

Names = Sequence[str]
Terms = Mapping[tuple[int, ...], str]
"""The coefficients of a polynomial by the exponents of the variables."""


def function(name: str, arguments: Iterable[str], lines: Iterable[str], scope: Mapping[str, Any]) -> Callable[..., Any]:
    """Return the Python function with these lines as its body; `scope` holds the global names that they use."""
    text = "\n".join([f"def {name}({', '.join(arguments)}):", *(f"    {line}" for line in lines), ""])
    file = f"<{name}, written out, {zlib.crc32(text.encode()):08x}>"
    linecache.cache[file] = len(text), None, text.splitlines(keepends=True), file  # for tracebacks and debuggers
    space = {"__name__": __name__, **scope}
    exec(compile(text, file, "exec"), space)
    written: Callable[..., Any] = space[name]
    return written


def at_each_point(kernel: Any) -> Any:
    """Return a function of a tuple and of `kernel`'s arguments but the last: it calls `kernel` for each entry.

    `kernel` gets the number of the entry as its last argument. LLVM sees a constant; numba does not, which would
    compile `kernel` once for each number.
    """
    *names, _ = inspect.signature(getattr(kernel, "py_func", kernel)).parameters

    def write(points: Any) -> Callable[..., Any]:
        calls = [f"kernel({', '.join(names)}, number({g}))" for g in range(len(points))]
        return function("at_each_point", ["points", *names], calls, {"kernel": kernel, "number": np.int64})

    return by_first_type(write, forceinline=True)


def total(terms: Iterable[str]) -> str:
    """Return the sum of terms."""
    return " + ".join(terms)


def dot(left: Iterable[str], right: Iterable[str]) -> str:
    """Return the sum of products of two lists of names."""
    return total(f"{a} * {b}" for a, b in zip(left, right, strict=True))


def determinant(rows: Sequence[Names]) -> str:
    """Return the determinant of a small matrix, expanded along its first row."""
    if len(rows) == 1:
        return rows[0][0]
    text = ""
    for k, entry in enumerate(rows[0]):
        minor = _minor(rows, 0, k)
        part = determinant(minor)
        term = f"{entry} * {part if len(minor) == 1 else f'({part})'}"
        text += (" - " if k % 2 else " + " if k else "") + term
    return text


def cofactor(rows: Sequence[Names], i: int, k: int) -> str:
    """Return the cofactor of an entry; cofactor (k, i) over the determinant is entry (i, k) of the inverse."""
    if len(rows) == 1:
        return "1.0"
    return f"{'-' if (i + k) % 2 else ''}({determinant(_minor(rows, i, k))})"


def invariants(rows: Sequence[Names]) -> list[str]:
    """Return the sums of principal minors of each size but the largest: with the determinant, all that decides signs.

    The eigenvalues of a matrix, where all are real, are positive exactly where these are.
    """
    n = len(rows)
    return [
        total(
            f"({determinant([[rows[i][k] for k in chosen] for i in chosen])})" for chosen in combinations(range(n), m)
        )
        for m in range(1, n)
    ]


def _minor(rows: Sequence[Names], i: int, k: int) -> list[list[str]]:
    return [[entry for m, entry in enumerate(row) if m != k] for h, row in enumerate(rows) if h != i]


def horner(terms: Terms, variables: Names) -> str:
    """Return a polynomial in Horner form in the first variable, whose coefficients are such forms in the others."""
    if not variables:
        return terms[()]
    highest = max(powers[0] for powers in terms)
    text = ""
    for power in range(highest, -1, -1):
        part = horner({powers[1:]: term for powers, term in terms.items() if powers[0] == power}, variables[1:])
        text = f"{part} + {variables[0]} * ({text})" if text else part
    return text


def derivative(terms: Terms, variable: int) -> Terms:
    """Return the terms of the derivative by a variable."""
    derived = {}
    for powers, term in terms.items():
        power = powers[variable]
        if power:
            lower = tuple(p - (i == variable) for i, p in enumerate(powers))
            derived[lower] = term if power == 1 else f"{power}.0 * {term}"
    return derived


class Code:
    """Collects the lines of a function."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def set(self, name: str, value: str) -> None:
        """Write an assignment."""
        self.lines.append(f"{name} = {value}")

    def lower(self, name: str, value: str) -> None:
        """Write that `name` becomes `value` where that is smaller; what is not a number changes nothing."""
        self.set("candidate", value)
        self.set(name, f"candidate if candidate < {name} else {name}")


class BlockFactor:
    """The factorization L D L^T of a symmetric matrix K, with pivots D of several unknowns each.

    A pivot is inverted by cofactors: one division for `size` unknowns. The matrix is positive definite exactly where
    the leading minors of all pivots are positive.

    Attributes
    ----------
    n : number of unknowns
    blocks : the unknowns of each pivot
    """

    def __init__(self, n: int, size: int) -> None:
        self.n = n
        self.blocks = [list(range(first, min(first + size, n))) for first in range(0, n, size)]

    @staticmethod
    def entry(i: int, k: int) -> str:
        """Return the name of an entry of the matrix, of which the lower triangle alone is kept."""
        return f"K{max(i, k)}_{min(i, k)}"

    def lower_triangle(self) -> list[tuple[int, int]]:
        """Return all entries that are kept."""
        return [(i, k) for i in range(self.n) for k in range(i + 1)]

    def factor(self, i: int, k: int) -> str:
        """Return the name of an entry of the factor: of L, or within a pivot of its inverse."""
        i, k = max(i, k), min(i, k)
        within = any(i in block and k in block for block in self.blocks)
        return f"I{i}_{k}" if within else f"L{i}_{k}"

    def factorize(self, code: Code) -> None:
        """Write the factorization; lowers `pivot` to the smallest leading minor of a pivot."""
        for block in self.blocks:
            self._invert(code, block)
            later = range(block[-1] + 1, self.n)
            for m in later:
                for i in block:
                    code.set(self.factor(m, i), dot([self.entry(m, k) for k in block], self._row(i, block)))
            for m in later:
                for k in range(block[-1] + 1, m + 1):
                    taken = "".join(f" - {self.factor(m, i)} * {self.entry(k, i)}" for i in block)
                    code.set(self.entry(m, k), self.entry(m, k) + taken)

    def solve(self, code: Code, b: str) -> None:
        """Write the solution for a right-hand side; the names b0, b1, ... hold first the one, then the other."""
        for block in self.blocks:
            for m in range(block[-1] + 1, self.n):
                code.set(f"{b}{m}", f"{b}{m}" + "".join(f" - {self.factor(m, i)} * {b}{i}" for i in block))
        for block in reversed(self.blocks):
            values = []
            for i in block:
                taken = "".join(f" - {self.factor(m, i)} * {b}{m}" for m in range(block[-1] + 1, self.n))
                values.append(dot(self._row(i, block), [f"{b}{k}" for k in block]) + taken)
            code.set(", ".join(f"{b}{i}" for i in block), ", ".join(values))

    def _row(self, i: int, block: list[int]) -> list[str]:
        return [self.factor(i, k) for k in block]

    def _invert(self, code: Code, block: list[int]) -> None:
        rows = [[self.entry(i, k) for k in block] for i in block]
        for m in range(1, len(block) + 1):
            code.lower("pivot", determinant([row[:m] for row in rows[:m]]))
        code.set("inv", "1.0 / candidate")
        for m, i in enumerate(block):
            for h, k in enumerate(block[: m + 1]):
                code.set(self.factor(i, k), f"{cofactor(rows, h, m)} * inv")
