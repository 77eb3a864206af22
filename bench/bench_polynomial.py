"""Time per evaluation of the polynomial models, beside a call that does nothing.

    python3 tools/run.py pytest bench/bench_polynomial.py --benchmark-enable

Every function is called once before it is timed, so that no compilation is counted. Compare within one run only.
"""

import numpy as np
import pytest

from ecm_fast.kernels._jit import call_kernel
from ecm_fast.kernels.polynomial import exponents
from ecm_fast.models.polynomial.multivariate import Polynomial

N = 4096


def polynomial(k, degree):
    rng = np.random.default_rng(degree)
    return Polynomial(rng.normal(size=k), rng.normal(size=(3, len(exponents(k, degree)))))


@call_kernel
def nothing(con, x, z, theta):
    return x, z, theta


def timed(benchmark, function, *args):
    function(*args)
    return benchmark(function, *args)


@pytest.mark.parametrize(("k", "degree"), [(2, 3), *((3, degree) for degree in range(1, 7))])
@pytest.mark.parametrize("name", ["many", "many_slopes"])
@pytest.mark.benchmark(group=f"batch of {N} poses in columns, one core")
def bench_batch(benchmark, name, k, degree):
    poly, points = polynomial(k, degree), np.random.default_rng(0).normal(size=(k, N))
    out = np.empty((3, N) if name == "many" else (3, k, N))
    timed(benchmark, getattr(poly._kernels, name), poly._con, points, out)
    assert np.isfinite(out).all()


@pytest.mark.benchmark(group=f"batch of {N} poses in rows, one core")
def bench_batch_of_rows(benchmark):
    assert timed(benchmark, polynomial(3, 3), np.random.default_rng(0).normal(size=(N, 3))).shape == (N, 3)


@pytest.mark.parametrize("degree", [3, 6])
@pytest.mark.benchmark(group="one call")
def bench_call(benchmark, degree):
    assert len(timed(benchmark, polynomial(3, degree).stepper(), 0.1, 0.2, 0.3)) == 3


@pytest.mark.parametrize("degree", [3, 6])
@pytest.mark.benchmark(group="one call")
def bench_call_with_slopes(benchmark, degree):
    step = polynomial(3, degree).stepper(slopes=True)
    assert len(timed(benchmark, step, 0.1, 0.2, 0.3, np.empty((3, 3)))) == 3


@pytest.mark.benchmark(group="one call")
def bench_call_of_nothing(benchmark):
    assert timed(benchmark, nothing, polynomial(3, 3)._con, 0.1, 0.2, 0.3) == (0.1, 0.2, 0.3)
