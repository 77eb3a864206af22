"""Time per solve: the model's ways in, its discretizations, and what they are measured against.

    python3 tools/run.py pytest bench --benchmark-enable

Every function is called once before it is timed, so that no compilation is counted. Compare within one run only.
"""

import numpy as np
import pytest
from scipy.linalg import solve_banded

import ecm_fast as ecm
from ecm_fast.models import reference

NECK = ecm.Mechanism.preset("slender")
LOADS = np.random.default_rng(2026).uniform(0.0, 160.0, (4096, 2))


def timed(benchmark, function, *args):
    function(*args)
    return benchmark(function, *args)


@pytest.mark.parametrize("order", [3, 4, 5, 6])
@pytest.mark.benchmark(group="batch of 4096, one core")
def bench_batch_fast(benchmark, order):
    result = timed(benchmark, ecm.FiniteElementModel(NECK, order=order).solve_batch, LOADS)
    assert result.stable.all()


@pytest.mark.parametrize(("elements", "order"), [(10, 1), (20, 1), (40, 1), (160, 1), (2, 2), (2, 5)])
@pytest.mark.benchmark(group="batch of 64, many elements")
def bench_batch_chain(benchmark, elements, order):
    result = timed(benchmark, ecm.FiniteElementModel(NECK, elements, order).solve_batch, LOADS[:64])
    assert result.stable.all()


@pytest.mark.parametrize("elements", [10, 160])
@pytest.mark.benchmark(group="batch of 64, many elements")
def bench_one_banded_solve(benchmark, elements):
    band = np.random.default_rng(0).uniform(0.0, 1.0, (11, 3 * elements))
    band[5] += 20.0
    assert np.isfinite(timed(benchmark, solve_banded, (5, 5), band, np.ones(3 * elements))).all()


@pytest.mark.parametrize(("elements", "order"), [(1, 4), (1, 5), (20, 1)])
@pytest.mark.benchmark(group="control step, 0.1 N apart")
def bench_step(benchmark, elements, order):
    step, count = ecm.FiniteElementModel(NECK, elements, order).stepper(), [0]

    def call():
        count[0] += 1
        return step(80.0 + 0.1 * (count[0] % 2), 40.0)

    assert timed(benchmark, call)[3] == ecm.Status.CONVERGED


@pytest.mark.parametrize(("elements", "order"), [(1, 5), (20, 1)])
@pytest.mark.benchmark(group="one cold solve")
def bench_solve(benchmark, elements, order):
    model = ecm.FiniteElementModel(NECK, elements, order)
    assert timed(benchmark, model.solve, (80.0, 40.0)).stable


@pytest.mark.benchmark(group="one cold solve")
def bench_solve_reference(benchmark):
    p, mesh = reference.named(ecm.pack(NECK)), ecm.Discretization.from_elements(20, 1)
    q, _ = timed(benchmark, reference.solve, p, mesh, [80.0, 40.0, 0.0, 0.0, 0.0, 1.0])
    assert np.isfinite(q).all()


@pytest.mark.benchmark(group="one cold solve")
def bench_one_banded_solve_of_the_same_size(benchmark):
    band = np.random.default_rng(0).uniform(0.0, 1.0, (11, 60))
    band[5] += 20.0
    assert np.isfinite(timed(benchmark, solve_banded, (5, 5), band, np.ones(60))).all()
