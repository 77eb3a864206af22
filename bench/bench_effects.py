"""Cost of the effects that leave the fast path, and of a diagnosis.

    python3 tools/run.py pytest bench/bench_effects.py --benchmark-enable

The yardstick of the first group is the general path without an effect to speak of: it may cost twice that.
"""

import numpy as np
import pytest

import ecm_fast as ecm

NECK = ecm.Mechanism.preset("slender")
LOADS = np.random.default_rng(2026).uniform(0.0, 160.0, (256, 2))
LEAVES = [
    effect
    for effect in ecm.CATALOGUE.values()
    if ecm.FiniteElementModel(NECK.replace(**{effect.size.key: effect.size.typical})).path == "general"
]


def timed(benchmark, function, *args):
    function(*args)
    return benchmark(function, *args)


@pytest.mark.benchmark(group="batch of 256 on the general path")
def bench_without_effect(benchmark):
    model = ecm.FiniteElementModel(NECK.replace(neutral_axis_offset=1e-12))
    assert timed(benchmark, model.solve_batch, LOADS).stable.all()


@pytest.mark.parametrize("effect", [pytest.param(effect, id=effect.name) for effect in LEAVES])
@pytest.mark.benchmark(group="batch of 256 on the general path")
def bench_effect(benchmark, effect):
    model = ecm.FiniteElementModel(NECK.replace(**{effect.size.key: effect.size.typical}))
    assert timed(benchmark, model.solve_batch, LOADS).stable.all()


@pytest.mark.parametrize("design", ["T", "grid17"])
@pytest.mark.benchmark(group="diagnosis of 81 and 289 poses, whole catalogue and all pairs")
def bench_diagnose(benchmark, design):
    data, _ = ecm.hide(effects={"bending_cubic": 0.004}, design=design, seed=1, noise="force")
    assert timed(benchmark, ecm.diagnose, NECK, data).verdict in ("named", "family")
