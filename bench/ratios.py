"""Ratios between what this package takes and what something well known takes, all measured in turn in one run.

Each ratio has a target; a row says whether it is met. A ratio moves with the load of the machine much less than a time.
"""

import gc
import importlib.util
import json
import subprocess
import sys
import time
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numba
import numpy as np
from flops import flops_of_sweep, probe
from numba.core.runtime import _nrt_python, rtsys
from scipy.linalg import lapack, solve_banded

import ecm_fast as ecm
from ecm_fast.kernels.condensed.step import gauss_points, sweep
from ecm_fast.kernels.layout import LANES
from ecm_fast.models import reference
from ecm_fast.models.paths.condensed import columns
from ecm_fast.studies.timing import Timing, in_turn, nothing

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "bench"))
import bench_peers  # noqa: E402

NECK = ecm.Mechanism.preset("slender")
# a batch is timed in less than a millisecond; at 16384 the polynomial is faster by a seventh, the solves are slower
BATCH, MANY, SWEEPS = 4096, 1 << 20, 16
LOADS = np.random.default_rng(2026).uniform(0.0, 160.0, (MANY, 2))
NONE = np.zeros((1, 3))
# once around a circle of tendon forces, at 1 kHz in steps of 0.23 N: its end is its beginning
PHASE = np.arange(0.0, 2.0 * np.pi, 0.23 / 20.0)
PATH = np.stack([80.0 + 20.0 * np.sin(PHASE), 60.0 + 20.0 * np.cos(PHASE)], axis=1)
Way = Callable[[], object]


@dataclass(frozen=True)
class Row:
    """A ratio: what of what, the figure measured, the target, and whether it is met (None: not measured)."""

    what: str
    measured: str
    target: str
    met: bool | None


def at_most(what: str, ratio: float, limit: float, note: str = "") -> Row:
    """Return the row of a ratio that should be small; below one it is shown as a fraction."""
    return Row(what, f"{_fraction(ratio)}{note}", f"≤ {_fraction(limit)}", ratio <= limit)


def at_least(what: str, ratio: float, limit: float, note: str = "") -> Row:
    """Return the row of a ratio that should be large."""
    return Row(what, f"{ratio:.3g}{note}", f"≥ {limit:g}", ratio >= limit)


def _fraction(ratio: float) -> str:
    return f"{ratio:.3g}" if ratio >= 0.5 else f"1/{1.0 / ratio:.3g}"


def rows() -> list[Row]:
    """Measure them all."""
    best = in_turn(_calls() | _batches() | _kernels(), cases=_cases(), seconds=1.0)
    peers = in_turn(_peers(), cases={}, seconds=0.3)
    found = _call_rows(best) + _batch_rows(best) + _reference_rows(best) + [_two_cores(), *_latency(), _import()]
    return found + _peer_rows(peers)


def along(step: Callable[..., object], path: np.ndarray) -> Way:
    """Return a call that makes a step for every row of a path."""
    steps = [tuple(row) for row in path.tolist()]

    def way() -> None:
        for args in steps:
            step(*args)

    return way


def _models() -> dict[str, ecm.FiniteElementModel]:
    return {f"order {order}": ecm.FiniteElementModel(NECK, 1, order) for order in (4, 5)} | {
        f"{n} linear": ecm.FiniteElementModel(NECK, n, 1) for n in (10, 20, 160)
    }


MODELS = _models()
POSES = MODELS["order 5"].solve_batch(PATH).pose
BATCH_POSES = MODELS["order 5"].solve_batch(LOADS[:BATCH]).pose
TRAINING = ecm.training_poses(MODELS["order 5"], 1000, 0)
POLY = ecm.PolynomialModel.fit(TRAINING.poses, TRAINING.wrenches)


def _cases() -> dict[str, int]:
    path = dict.fromkeys(("step", "step with Jacobian", "polynomial"), len(PATH))
    many = dict.fromkeys([*_batches()], BATCH)
    return path | many | {"sweep": LANES * SWEEPS} | {f"chain {n} in batch": 64 for n in (10, 160)}


def _calls() -> dict[str, Way]:
    """Return single calls from Python."""
    model, ways = MODELS["order 4"], {}
    ways["step"] = along(model.stepper(tolerance=1e-6), PATH)
    ways["step with Jacobian"] = along(model.stepper(tolerance=1e-6, derivatives=True), PATH)
    ways["polynomial"] = along(POLY.stepper(), POSES)
    ways["solve"] = lambda: MODELS["order 5"].solve((80.0, 40.0))
    for n in (10, 20, 160):
        band, right = np.random.default_rng(0).uniform(0.0, 1.0, (11, 3 * n)), np.ones(3 * n)
        band[5] += 20.0
        room = np.zeros((16, 3 * n), order="F")
        room[5:] = band
        ways[f"solve_banded {n}"] = lambda band=band, right=right: solve_banded((5, 5), band, right)
        ways[f"dgbsv {n}"] = lambda room=room, right=right: lapack.dgbsv(5, 5, room, right)
        fast = MODELS[f"{n} linear"]._single.fast
        one, many = (LOADS[:1], NONE, 1e-10, columns(1)), (LOADS[:64], NONE, 1e-10, columns(64))
        ways[f"chain {n}"] = lambda fast=fast, args=one: fast.solve(*args)
        ways[f"chain {n} in batch"] = lambda fast=fast, args=many: fast.solve(*args)
    p, mesh = reference.named(ecm.pack(NECK)), ecm.Discretization.from_elements(20, 1)
    ways["reference"] = lambda: reference.solve(p, mesh, [80.0, 40.0, 0.0, 0.0, 0.0, 1.0])
    return ways


def _batches() -> dict[str, Way]:
    """Return batches of `BATCH` cases, as kernels alone and as called from Python."""
    model, lam, zeros = MODELS["order 4"], LOADS[:BATCH], np.zeros((BATCH, 3))
    fast, out = model._single.fast, columns(BATCH)
    guess = fast.fit_guess(160.0, np.zeros(3))
    points, room = np.ascontiguousarray(BATCH_POSES.T), np.empty((3, BATCH))
    many = POLY.polynomial._kernels.many
    ways: dict[str, Way] = {
        "polynomials, kernel": lambda: many(POLY.polynomial._con, points, room),
        "polynomials, Python": lambda: POLY.wrench(BATCH_POSES),
    }
    for tolerance in (1e-6, 1e-9):
        # a wrench a case keeps the batch from starting from a polynomial
        ways[f"straight {tolerance:g}, kernel"] = lambda t=tolerance: fast.solve(lam, NONE, t / 10.0, out)
        ways[f"straight {tolerance:g}, Python"] = lambda t=tolerance: model.solve_batch(lam, zeros, tolerance=t)
        ways[f"guess {tolerance:g}, kernel"] = lambda t=tolerance: fast.solve(lam, NONE, t / 10.0, out, guess)
        ways[f"guess {tolerance:g}, Python"] = lambda t=tolerance: model.solve_batch(lam, tolerance=t)
    return ways


def _kernels() -> dict[str, Way]:
    """Return the step of the batches, and the arithmetic the processor can do at best."""
    fast = MODELS["order 4"]._single.fast
    state = fast.solve(LOADS[:LANES], NONE, 1e-10, columns(LANES))
    con, points = fast.con, gauss_points(4)

    @numba.njit(nogil=True)
    def sweeps(con, state):
        for _ in range(SWEEPS):
            sweep(points, con, state)

    return {"sweep": lambda: sweeps(con, state), "peak": probe()[0]}


def _call_rows(best: dict[str, Timing]) -> list[Row]:
    truth = ecm.FiniteElementModel(NECK, 8, 6).solve_batch(PATH, tolerance=1e-13).pose
    step = MODELS["order 4"].stepper(tolerance=1e-6)
    error = np.abs([step(*row)[:3] for row in PATH.tolist()] - truth).max(axis=0)
    within = f" (error {max(error[:2].max() / NECK.beam.length, error[2]):.0e} L or rad)"
    what = "control step, order 4, 0.23 N apart"
    found = [
        at_most(f"{what} / one `solve_banded` of 30 unknowns", best["step"] / best["solve_banded 10"], 1 / 30, within),
        at_most(f"{what} / one call of the cubic polynomial", best["step"] / best["polynomial"], 2.2),
        at_most("control step with Jacobian / without", best["step with Jacobian"] / best["step"], 1.15),
        at_most(
            "cold `solve`, the default / one `solve_banded` of 60 unknowns",
            best["solve"] / best["solve_banded 20"],
            0.2,
        ),
    ]
    for n, limit in ((10, 1 / 14), (160, 1 / 6)):
        for way, how in ((f"chain {n}", "one a call"), (f"chain {n} in batch", "64 a call")):
            ratio, raw = best[way] / best[f"solve_banded {n}"], best[way] / best[f"dgbsv {n}"]
            note = f" ({_fraction(raw)} of LAPACK `dgbsv`)"
            what = f"{n} linear elements, cold solve, {how} / one `solve_banded` of {3 * n} unknowns"
            found.append(at_most(what, ratio, limit, note))
    return found


def _batch_rows(best: dict[str, Timing]) -> list[Row]:
    lam, found = LOADS[:BATCH], []
    truth = ecm.FiniteElementModel(NECK, 8, 6).solve_batch(lam, tolerance=1e-13).pose
    for start, text, limit in (("straight", "from the straight neck", 50), ("guess", "from a polynomial", 15)):
        for tolerance in (1e-6, 1e-9):
            wrench = np.zeros((BATCH, 3)) if start == "straight" else None
            pose = MODELS["order 4"].solve_batch(lam, wrench, tolerance=tolerance).pose
            note = f" (error {np.abs(pose - truth).max():.0e})"
            for how in ("kernel", "Python"):
                ratio = best[f"{start} {tolerance:g}, {how}"] / best[f"polynomials, {how}"]
                what = f"batch of {BATCH} {text}, order 4, tolerance {tolerance:g} / batched cubic polynomial"
                what += f", {how} to {how}"
                found.append(at_most(what, ratio, limit, note))
    count, (_, peak_count) = flops_of_sweep(), probe()
    rate, peak = count / best["sweep"].per_case / 1e9, peak_count / best["peak"].best / 1e9
    note = f" ({count} operations a lane, {rate:.3g} of {peak:.3g} GF/s)"
    return [*found, at_least("arithmetic of a Newton step, order 4 / peak of multiply-add", rate / peak, 0.65, note)]


def _reference_rows(best: dict[str, Timing]) -> list[Row]:
    # the oracle is dense and written to be read: a program in NumPy written for speed would be several times as fast
    plain = "the dense reference in NumPy, 20 linear elements"
    return [
        at_least(f"{plain} / control step, order 4", best["reference"] / best["step"], 1500),
        at_least(f"{plain} / batch, order 4", best["reference"] / best["guess 1e-09, Python"], 10000),
    ]


def _two_cores() -> Row:
    model = MODELS["order 5"]
    best = in_turn({str(n): lambda n=n: model.solve_batch(LOADS, threads=n) for n in (1, 2)}, seconds=0.0, shortest=0.0)
    return at_least(f"batch of {MANY} on one core / on two", best["1"] / best["2"], 1.8)


def _latency(runs: int = 5, n: int = 100_000) -> list[Row]:
    """Return how far single calls are from the middle one, beside a call that does nothing, and what they allocate."""
    step = MODELS["order 4"].stepper()
    lam = np.resize(PATH, (n, 2)).tolist()
    spread = {True: np.inf, False: np.inf}
    gc.disable()
    for _ in range(runs):
        for way in (nothing, step):
            took = np.empty(n)
            for i, (left, right) in enumerate(lam):
                start = time.perf_counter_ns()
                way(left, right)
                took[i] = time.perf_counter_ns() - start
            middle, late = np.percentile(took, [50.0, 99.9])
            spread[way is step] = min(spread[way is step], late / middle)
    gc.enable()
    _nrt_python.memsys_enable_stats()
    before, walk = rtsys.get_allocation_stats().alloc, along(step, PATH)
    walk()
    arrays = rtsys.get_allocation_stats().alloc - before
    kept = _bytes_kept(walk) - _bytes_kept(along(nothing, PATH))
    what = "p99.9 / p50 of 100000 control steps, over the same of empty calls"
    note = f" ({spread[True]:.3g} over {spread[False]:.3g})"
    what_kept = f"arrays allocated, bytes kept by {len(PATH)} control steps"
    return [
        at_most(what, spread[True] / spread[False], 3.0, note),
        Row(what_kept, f"{arrays}, {kept}", "0, 0", arrays == 0 and kept <= 0),
    ]


def _bytes_kept(walk: Way) -> int:
    """Return by how much the interpreter's memory grows over a call that was made before."""
    tracemalloc.start()
    walk()
    before = tracemalloc.get_traced_memory()[0]
    walk()
    after = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    return after - before


def _import(runs: int = 7) -> Row:
    """Compare the processor's time of a fresh process up to its first answer with that of one that imports NumPy."""
    ours = "import ecm_fast; ecm_fast.FiniteElementModel().stepper()(40.0, 10.0)"
    codes = {"ours": ours, "numpy": "import numpy"}
    best = dict.fromkeys(codes, np.inf)
    for _ in range(runs):
        for name, code in codes.items():
            command = [sys.executable, "-c", f"{code}\nimport json, time\nprint(json.dumps(time.process_time()))"]
            took = json.loads(subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT).stdout)
            best[name] = min(best[name], took)
    note = f" ({best['ours']:.2g} s of {best['numpy']:.2g} s)"
    what = "import to first control step, cached / `import numpy`, processor time"
    return at_most(what, best["ours"] / best["numpy"], 6.0, note)


def _peers() -> dict[str, Way]:
    ways: dict[str, Way] = {}
    for name, how in {"order 5": (1, 5), "20 linear": (20, 1)}.items():
        model = ecm.FiniteElementModel(bench_peers.NECK, *how)
        ways[name] = lambda model=model: model.solve((0.0, 0.0), bench_peers.WRENCH)
    if importlib.util.find_spec("elastica"):
        ways["PyElastica"] = bench_peers.relaxed
    return ways


def _peer_rows(best: dict[str, Timing]) -> list[Row]:
    found, off = [], 0.0
    if "PyElastica" in best:
        off = abs(bench_peers.relaxed()[1] / bench_peers.TIP[1] - 1.0)
    for name, text in (("order 5", "one element of order 5"), ("20 linear", "20 linear elements")):
        own, what = best[name].best, f"cold `solve` of the shared problem, {text}"
        found.append(at_most(f"{what} / 83 µs, the fastest peer's on another machine", own / 83e-6, 1.0))
        if "PyElastica" in best:
            note = f" ({own * 1e6:.3g} µs of {best['PyElastica'].best * 1e3:.3g} ms, whose deflection is {off:.0%} off)"
            found.append(
                at_most(f"{what} / PyElastica, 20 elements relaxed", best[name] / best["PyElastica"], 1.0, note)
            )
        else:
            found.append(Row(f"{what} / PyElastica, 20 elements relaxed", "not installed", "≤ 1", None))
    return found


def table() -> list[str]:
    """Return the rows as lines of Markdown."""
    verdicts = {True: "met", False: "**missed**", None: ""}
    lines = ["| ratio | measured | target | |", "|---|---|---|---|"]
    return lines + [f"| {row.what} | {row.measured} | {row.target} | {verdicts[row.met]} |" for row in rows()]


if __name__ == "__main__":
    sys.stdout.write("\n".join(table()) + "\n")
