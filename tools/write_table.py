"""Measure accuracy and time, and rewrite the table in README.md.

    python3 tools/run.py python tools/write_table.py

Times are minima of short repetitions, all ways taken in turn within one run, after warm-up; read them as ratios.
Errors are the largest over random tendon forces up to 160 N, against eight elements of order 6.
"""

import platform
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.linalg import solve_banded

import ecm_fast as ecm
from ecm_fast import reference

README = Path(__file__).resolve().parent.parent / "README.md"
START, END = "<!-- table: written by tools/write_table.py -->", "<!-- end of table -->"
NECK = ecm.Mechanism.preset("slender")
LOADS = np.random.default_rng(2026).uniform(0.0, 160.0, (2048, 2))
MODELS = {
    "one element of order 4": (1, 4),
    "**one element of order 5 (default)**": (1, 5),
    "one element of order 6": (1, 6),
    "20 linear elements (the paper)": (20, 1),
}


def in_turn(ways: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Return the shortest time of each way [s]; every round takes each way once."""
    best = dict.fromkeys(ways, np.inf)
    for _ in range(rounds):
        for name, way in ways.items():
            start = time.perf_counter()
            way()
            best[name] = min(best[name], time.perf_counter() - start)
    return best


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
    truth = ecm.FiniteElementModel(NECK, 8, 6).solve_batch(LOADS).pose
    models = {name: ecm.FiniteElementModel(NECK, *how) for name, how in MODELS.items()}
    error = {name: np.abs(model.solve_batch(LOADS).pose - truth).max() for name, model in models.items()}
    ways: dict[str, Callable[[], object]] = {}
    for name, model in models.items():
        ways[f"batch {name}"] = lambda model=model: model.solve_batch(LOADS[:512])
        ways[f"step {name}"] = stepping(model)
        ways[f"solve {name}"] = lambda model=model: model.solve((80.0, 40.0))
    band = np.random.default_rng(0).uniform(0.0, 1.0, (11, 60))
    band[5] += 20.0
    ways["banded"] = lambda: solve_banded((5, 5), band, np.ones(60))
    p, mesh = reference.named(ecm.pack(NECK)), ecm.Discretization.of(20, 1)
    for way in ways.values():
        way()
    best = in_turn(ways, 200)
    best |= in_turn({"reference": lambda: reference.solve(p, mesh, [80.0, 40.0, 0.0, 0.0, 0.0, 1.0])}, 5)
    lines = ["| | largest error (m, rad) | control step | one solve | in a batch, one core |", "|---|---|---|---|---|"]
    for name in models:
        step, solve = best[f"step {name}"] / 20, best[f"solve {name}"]
        batch = best[f"batch {name}"] / 512
        lines.append(f"| {name} | {error[name]:.0e} | {micro(step)} | {micro(solve)} | {micro(batch)} |")
    lines.append(f"| the same 20 elements in plain NumPy | | | {micro(best['reference'])} | |")
    lines.append(f"| for scale: one `scipy.linalg.solve_banded` of their size | | | {micro(best['banded'])} | |")
    lines += ["", f"Measured with Python {platform.python_version()} on one core of {processor()}; "
              "a control step follows a change of 0.1 N, the other solves start from the unloaded neck."]  # fmt: skip
    return lines


def micro(seconds: float) -> str:
    """Return a time in microseconds with three digits."""
    return f"{float(f'{seconds * 1e6:.3g}'):g} µs"


def processor() -> str:
    """Return the processor's name, where the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())


def main() -> None:
    """Rewrite the table between its marks."""
    before, rest = README.read_text().split(START)
    after = rest.split(END)[1]
    README.write_text("\n".join([before + START, *rows(), END]) + after)


if __name__ == "__main__":
    main()
