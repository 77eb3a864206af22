"""Time of an identification: EA, GA and EI from 300 poses, beside one that takes finite differences.

    python3 tools/run.py pytest bench/bench_identify.py --benchmark-enable

Every function is called once before it is timed, so that no compilation is counted. The column of extra numbers gives
how many equilibria each solved. Compare within one run only.
"""

import numpy as np
import pytest

from ecm_fast import FiniteElementModel, identify
from ecm_fast.data import datasets

NAMES = ["EA", "GA", "EI"]
NECK, DATA = datasets.load("simulated_slender_tendon")
START = NECK.replace(EA=7000.0, GA=2800.0, EI=2.7)
SIGMA = np.array([1e-4, 1e-4, 1e-3])


def timed(benchmark, function):
    function()
    return benchmark(function)


@pytest.mark.parametrize(
    "options",
    [{"force_sigma": 0.0}, {}, {"loss": "huber"}],
    ids=["noise of the camera", "and of the forces", "and a robust loss"],
)
@pytest.mark.benchmark(group="EA, GA, EI from 300 poses")
def bench_identify(benchmark, options):
    fit = timed(benchmark, lambda: identify(START, DATA, NAMES, **options))
    benchmark.extra_info["solves"] = fit.solves
    assert fit.settled


@pytest.mark.benchmark(group="EA, GA, EI from 300 poses")
def bench_finite_differences(benchmark):
    """SciPy's least squares on the batch solver, which differentiates nothing."""
    from scipy.optimize import least_squares

    scale, solves = np.array([7500.0, 2420.0, 3.0]), 0

    def residual(u):
        nonlocal solves
        solves += DATA.n
        neck = NECK.replace(**dict(zip(NAMES, (u * scale).tolist(), strict=True)))
        return ((FiniteElementModel(neck).solve_batch(DATA.lam, DATA.wrench).pose - DATA.pose) / SIGMA).ravel()

    def fit():
        nonlocal solves
        solves = 0
        return least_squares(residual, np.array([7000.0, 2800.0, 2.7]) / scale, xtol=1e-9, ftol=1e-9, gtol=1e-9)

    assert timed(benchmark, fit).success
    benchmark.extra_info["solves"] = solves


@pytest.mark.benchmark(group="poses and derivatives of 300 rows")
def bench_sensitivities(benchmark):
    model = FiniteElementModel(NECK)
    found = timed(benchmark, lambda: model.sensitivities(NAMES, DATA.lam, DATA.wrench))
    assert found.stable.all()


@pytest.mark.benchmark(group="a profile")
def bench_profile(benchmark):
    fit = identify(START, DATA, NAMES)
    assert timed(benchmark, lambda: fit.profile("GA")).lower < fit["GA"].value
