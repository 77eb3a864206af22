"""Measure accuracy and time, and write the table of `bench/RESULTS.md`.

    python3 tools/run.py python bench/write_results.py

Times are minima of short repetitions, all ways taken in turn within one run, after warm-up; read them as ratios. Errors
are the largest over random tendon forces up to 160 N, against eight elements of order 6. The ratios below the table are
those of `ratios`; with PyElastica installed (group `peers`) it is timed too.
"""

from collections.abc import Callable

import numpy as np
import ratios
from scipy.linalg import solve_banded

import ecm_fast as ecm
from bench import results_page
from ecm_fast.models import reference
from ecm_fast.studies.timing import in_turn, machine

NECK = ecm.Mechanism.preset("slender")
LOADS = np.random.default_rng(2026).uniform(0.0, 160.0, (2048, 2))
GENERAL = NECK.replace(neutral_axis_offset=1e-3)  # one of the effects that the condensed path does not take
MODELS = {
    "one element of order 4": (NECK, 1, 4),
    "**one element of order 5 (default)**": (NECK, 1, 5),
    "one element of order 6": (NECK, 1, 6),
    "one element of order 5, with an effect that needs the general path": (GENERAL, 1, 5),
    "20 linear elements (the paper)": (NECK, 20, 1),
}


def stepping(model: ecm.FiniteElementModel) -> Callable[[], object]:
    """Return a call that takes 20 control steps 0.1 N apart."""
    step = model.stepper()

    def way() -> object:
        for i in range(20):
            step(80.0 + 0.1 * (i % 2), 40.0)
        return None

    return way


def rows() -> list[str]:
    """Measure, and return the table's lines."""
    models = {name: ecm.FiniteElementModel(*how) for name, how in MODELS.items()}
    error = {}
    for name, model in models.items():
        truth = ecm.FiniteElementModel(model.mechanism, 8, 6).solve_batch(LOADS)
        error[name] = np.abs(model.solve_batch(LOADS).pose - truth.pose).max()
    ways: dict[str, Callable[[], object]] = {}
    for name, model in models.items():
        ways[f"batch {name}"] = lambda model=model: model.solve_batch(LOADS[:512])
        ways[f"step {name}"] = stepping(model)
        ways[f"solve {name}"] = lambda model=model: model.solve((80.0, 40.0))
    band = np.random.default_rng(0).uniform(0.0, 1.0, (11, 60))
    band[5] += 20.0
    ways["banded"] = lambda: solve_banded((5, 5), band, np.ones(60))
    p, mesh = reference.named(ecm.pack(NECK)), ecm.Discretization.from_elements(20, 1)
    ways["reference"] = lambda: reference.solve(p, mesh, [80.0, 40.0, 0.0, 0.0, 0.0, 1.0])
    many = {name: 512 for name in ways if name.startswith("batch")} | {name: 20 for name in ways if "step" in name}
    best = {name: found.per_case for name, found in in_turn(ways, cases=many).items()}
    lines = ["| | largest error (m, rad) | control step | one solve | in a batch, one core |", "|---|---|---|---|---|"]
    for name in models:
        step, solve = best[f"step {name}"], best[f"solve {name}"]
        batch = best[f"batch {name}"]
        lines.append(f"| {name} | {error[name]:.0e} | {micro(step)} | {micro(solve)} | {micro(batch)} |")
    lines.append(f"| the same 20 elements in plain NumPy | | | {micro(best['reference'])} | |")
    lines.append(f"| for scale: one `scipy.linalg.solve_banded` of their size | | | {micro(best['banded'])} | |")
    used = machine()
    lines += ["", f"Measured with Python {used['python']} and numba {used['numba']} on {used['processor']}, load "
              f"{used['load']} on {used['cores']} cores; a control step follows a change of 0.1 N, the other solves "
              "start from the unloaded neck, a batch on one core. Other work on the machine slows what takes "
              "milliseconds (plain NumPy, PyElastica, two cores), not the minima of what takes "
              "microseconds."]  # fmt: skip
    return [*lines, "", *ratios.table()]


def micro(seconds: float) -> str:
    """Return a time in microseconds with three digits."""
    return f"{float(f'{seconds * 1e6:.3g}'):g} µs"


def main() -> None:
    """Measure, and write the page of results."""
    results_page.put("times", rows())


if __name__ == "__main__":
    main()
