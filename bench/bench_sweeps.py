"""A sweep against what it is made of: the bare batch kernel, and bare writing of the same columns.

The three rates of one run make the ratio: a sweep's cases per second over the smaller of the other two.
"""

from concurrent.futures import ThreadPoolExecutor
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ecm_fast as ecm
from ecm_fast.files import write_whole
from ecm_fast.mechanism.parameters import index
from ecm_fast.mechanism.vector import pack
from ecm_fast.studies.sweeps.chunk import solve
from ecm_fast.studies.sweeps.rows_file import encode

pytest.importorskip("pyarrow")

THREADS, CHUNKS = 2, 8
LAM = {"lam_l": [0.0, 160.0], "lam_r": [0.0, 160.0]}
INPUTS = {
    "tendons": LAM,
    "tendons and wrench": {**LAM, "fx": [-5.0, 5.0], "fz": [-5.0, 5.0]},
    "mechanisms": {**LAM, "EI": {"mean": 3.0, "std": 0.1}},
}


@pytest.fixture(params=INPUTS)
def spec(request: pytest.FixtureRequest) -> dict[str, Any]:
    chunk = 1 << 17 if request.param != "mechanisms" else 1 << 15
    return {"sweep": {"cases": CHUNKS * chunk, "chunk": chunk}, "inputs": INPUTS[request.param]}


def bench_kernel(benchmark, spec: dict[str, Any]) -> None:
    plan = ecm.read_spec(spec)
    inputs = solve(plan, 0).inputs
    lam, wrench, parameters = _loads(plan, inputs)
    model = ecm.FiniteElementModel()

    def run() -> None:
        with ThreadPoolExecutor(THREADS) as pool:
            list(pool.map(lambda _: model.solve_batch(lam, wrench, parameters=parameters), range(CHUNKS)))

    run()
    benchmark(run)
    benchmark.extra_info["cases"] = plan.cases


def bench_writing(benchmark, spec: dict[str, Any], tmp_path: Path) -> None:
    plan = ecm.read_spec(spec)
    solved, names = solve(plan, 0), count()

    def write(_: int) -> None:
        write_whole(tmp_path / f"{next(names)}", encode(plan, 0, solved)[1])

    def run() -> None:
        with ThreadPoolExecutor(THREADS) as pool:
            list(pool.map(write, range(CHUNKS)))

    benchmark(run)
    benchmark.extra_info["cases"] = plan.cases


@pytest.mark.parametrize("keep", ["rows", "statistics"])
def bench_sweep(benchmark, spec: dict[str, Any], keep: str, tmp_path: Path) -> None:
    plan, names = ecm.read_spec({**spec, "sweep": {**spec["sweep"], "keep": keep}}), count()
    benchmark(lambda: ecm.sweep(plan, tmp_path / f"{next(names)}", threads=THREADS))
    benchmark.extra_info["cases"] = plan.cases


def _loads(plan: ecm.SweepSpec, inputs: dict[str, Any]) -> tuple[Any, Any, Any]:
    rows = plan.chunk
    lam = np.column_stack([inputs["lam_l"], inputs["lam_r"]])
    wrench = np.column_stack([inputs["fx"], inputs["fz"], np.zeros(rows)]) if "fx" in inputs else None
    if "beam.EI" not in inputs:
        return lam, wrench, None
    parameters = np.tile(pack(plan.mechanism), (rows, 1))
    parameters[:, index("EI")] = inputs["beam.EI"]
    return lam, wrench, parameters
