"""Write the polynomials of each degree without loops, `ecm_fast/kernels/polynomial1.py` to `polynomial6.py`.

    python tools/write_polynomial.py [--check]

What the functions take and return is stated in `ecm_fast/kernels/polynomial.py`.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path

from ecm_fast.kernels.polynomial import DEGREES, exponents

FOLDER = Path(__file__).resolve().parent.parent / "ecm_fast" / "kernels"
VARIABLES = ("u", "v", "w")
NAMES = ("hoist", "many", "many_slopes", "one", "one_with_slopes", "slopes", "values")

HEADER = '''\
"""Three polynomials of degree {degree} in two or three variables, written out. Do not edit.

Written by `tools/write_polynomial.py`; what each function takes is explained in `polynomial`.
"""

from ._jit import call_kernel, kernel, step_kernel

__all__ = [{names}]
'''

FUNCTIONS = '''

@step_kernel
def hoist{k}(con):
    """Constants as locals: read inside a loop that writes an array, they would be read again for every point."""
    return {constants}


@step_kernel
def values{k}(c, {args}):
    """Three outputs at one point."""
{shift}
{values}
    return f0, f1, f2


@step_kernel
def slopes{k}(c, {args}):
    """Derivatives of the three outputs by the variables at one point, row by row."""
{shift}
{slopes}
    return {slope_names}


@call_kernel
def one{k}(con, {args}):
    """Three outputs at one point."""
    return values{k}(hoist{k}(con), {args})


@call_kernel
def one_with_slopes{k}(con, {args}, slopes):
    """Three outputs at one point, and their derivatives into `slopes`."""
    c = hoist{k}(con)
    {slope_places} = slopes{k}(c, {args})
    return values{k}(c, {args})


@kernel
def many{k}(con, points, out):
    """Three outputs at every point; the compiler turns this loop into vector instructions."""
    c = hoist{k}(con)
    for i in range(points.shape[1]):
        out[0, i], out[1, i], out[2, i] = values{k}(c, {columns})


@kernel
def many_slopes{k}(con, points, out):
    """Derivatives of the three outputs at every point; the compiler turns this loop into vector instructions."""
    c = hoist{k}(con)
    for i in range(points.shape[1]):
        {slope_columns} = slopes{k}(c, {columns})
'''


def horner(terms: Mapping[tuple[int, ...], str], variables: tuple[str, ...]) -> str:
    """Return a polynomial in Horner form in the first variable, whose coefficients are such forms in the others."""
    if not variables:
        return terms[()]
    highest = max(powers[0] for powers in terms)
    text = ""
    for power in range(highest, -1, -1):
        part = horner({powers[1:]: term for powers, term in terms.items() if powers[0] == power}, variables[1:])
        text = f"{part} + {variables[0]} * ({text})" if text else part
    return text


def derivative(terms: Mapping[tuple[int, ...], str], variable: int) -> dict[tuple[int, ...], str]:
    """Return the terms of the derivative by a variable."""
    derived = {}
    for powers, term in terms.items():
        power = powers[variable]
        if power:
            lower = tuple(p - (i == variable) for i, p in enumerate(powers))
            derived[lower] = term if power == 1 else f"{power}.0 * {term}"
    return derived


def functions(k: int, degree: int) -> str:
    """Return the functions for `k` variables."""
    monomials, variables = exponents(k, degree), VARIABLES[:k]
    m = len(monomials)
    terms = [{powers: f"c[{k + m * j + i}]" for i, powers in enumerate(monomials)} for j in range(3)]
    pairs = [(j, v) for j in range(3) for v in range(k)]
    slopes = {f"f{j}_{variables[v]}": horner(derivative(terms[j], v), variables) for j, v in pairs}
    return FUNCTIONS.format(
        k=k,
        args=", ".join(variables),
        constants=", ".join(f"con[{i}]" for i in range(k + 3 * m)),
        shift="    " + ", ".join(variables) + " = " + ", ".join(f"{v} - c[{i}]" for i, v in enumerate(variables)),
        values="\n".join(f"    f{j} = {horner(terms[j], variables)}" for j in range(3)),
        slopes="\n".join(f"    {name} = {text}" for name, text in slopes.items()),
        slope_names=", ".join(slopes),
        slope_places=", ".join(f"slopes[{j}, {v}]" for j, v in pairs),
        columns=", ".join(f"points[{v}, i]" for v in range(k)),
        slope_columns=", ".join(f"out[{j}, {v}, i]" for j, v in pairs),
    )


def module(degree: int) -> str:
    """Return the text of one module."""
    names = ", ".join(f'"{name}{k}"' for name in NAMES for k in (2, 3))
    return HEADER.format(degree=degree, names=names) + functions(2, degree) + functions(3, degree)


def main() -> int:
    """Write the modules, or with --check say whether they are up to date."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="only compare; exit 1 when a module is out of date")
    check = parser.parse_args().check
    stale = 0
    for degree in DEGREES:
        path, text = FOLDER / f"polynomial{degree}.py", module(degree)
        if check:
            stale += not path.exists() or path.read_text() != text
        else:
            path.write_text(text)
    return int(stale > 0)


if __name__ == "__main__":
    raise SystemExit(main())
