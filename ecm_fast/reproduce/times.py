"""How long one answer takes, from the plain program to the polynomial: the paper's Fig. 7."""

from collections.abc import Callable, Mapping
from time import perf_counter_ns

import numpy as np
from numpy.typing import NDArray

from ..discretization import Discretization
from ..mechanism import PRESETS, Mechanism
from ..model import FiniteElementModel
from ..parameters import pack
from ..plots import COLORS, canvas, random_tendon_forces
from ..polynomial import PolynomialModel
from ..reference import named
from ..reference import solve as plain_solve
from ..report import Picture, Section, Table
from ..training import training_poses
from ._claim import Claim, Part, verdict

__all__ = ["measured_times", "times"]

Array = NDArray[np.float64]

_PLAIN, _PAPER, _STEP_20, _FAST, _POLYNOMIAL = (
    "20 linear elements, plain NumPy",
    "20 linear elements, compiled, from rest",
    "20 linear elements, control step",
    "one element of order 5, control step",
    "cubic polynomial",
)
_FACTOR = 200.0
_PLAIN_EVERY = 5
"""The plain program, a thousand times slower, is timed on every fifth pose alone."""


def times(seed: int = 0, n: int = 100, rounds: int = 5) -> Part:
    """Time every solver on `n` poses; of `rounds` rounds, in which the solvers take turns, the fastest counts."""
    found = {preset: measured_times(preset, seed, n, rounds) for preset in PRESETS}
    claims = tuple(claim for preset in PRESETS for claim in _claims(preset, found[preset]))
    numbers = {
        preset: {
            name: {"median_s": float(np.median(taken)), "smallest_s": taken.min(), "largest_s": taken.max()}
            for name, taken in entries.items()
        }
        for preset, entries in found.items()
    }
    rows = tuple(
        (preset, name, 1e6 * float(np.median(taken)), *(1e6 * np.quantile(taken, [0.05, 0.95])).tolist(),
         float(np.median(taken) / np.median(entries[_POLYNOMIAL])))
        for preset, entries in found.items()
        for name, taken in entries.items()
    )  # fmt: skip
    head = ("preset", "solver", "median [µs]", "5 % faster than [µs]", "5 % slower than [µs]", "over the polynomial")
    sentences = (
        "The paper times 100 random poses and finds its polynomial at least 200 times faster than its finite element "
        f"model. Here every solver is called from Python on {n} random poses in turn, {rounds} rounds, of which the "
        "fastest counts; the plain program is timed in one round, on every fifth pose. The first row is the paper's "
        "program as one writes it without a compiler, the last but one what this package takes in a control loop.",
        "Calling from Python costs a good part of a microsecond itself, most of the time of the polynomial.",
    )
    table = Table("Time of one answer on this machine", head, rows)
    section = Section("Computing time (Fig. 7)", sentences, (table,), (_picture(found),))
    return Part(claims, numbers, section)


def measured_times(preset: str, seed: int, n: int, rounds: int) -> dict[str, Array]:
    """Return the time of each of `n` answers (n,) [s] by solver, of the plain one fewer."""
    neck = Mechanism.preset(preset)
    model, paper = FiniteElementModel(neck), FiniteElementModel(neck, elements=20, order=1)
    lam = random_tendon_forces(n, seed)
    poses = model.solve_batch(lam).pose
    known = training_poses(model, 1000, seed)
    evaluate = PolynomialModel.fit(known.poses, known.wrenches).stepper()
    step, paper_step = model.stepper(), paper.stepper()
    p, mesh = named(pack(neck)), Discretization.of(20, 1)
    loads, places = [tuple(row) for row in lam.tolist()], [tuple(row) for row in poses.tolist()]
    full = [[*row, 0.0, 0.0, 0.0, 1.0] for row in loads]
    plain = {_PLAIN: lambda i: plain_solve(p, mesh, full[_PLAIN_EVERY * i])}
    few = len(loads[::_PLAIN_EVERY])
    compiled: dict[str, Callable[[int], object]] = {
        _PAPER: lambda i: paper.solve(loads[i]),
        _STEP_20: lambda i: paper_step(*loads[i]),
        _FAST: lambda i: step(*loads[i]),
        _POLYNOMIAL: lambda i: evaluate(*places[i]),
    }
    return {**_interleaved(plain, few, 1), **_interleaved(compiled, n, rounds)}


def _interleaved(solvers: Mapping[str, Callable[[int], object]], n: int, rounds: int) -> dict[str, Array]:
    """Return the shortest time of each of `n` calls; every solver has run once before the clock starts."""
    taken = {name: np.full(n, np.inf) for name in solvers}
    for solver in solvers.values():
        solver(0)
    for _ in range(rounds):
        for i in range(n):
            for name, solver in solvers.items():
                begin = perf_counter_ns()
                solver(i)
                taken[name][i] = min(taken[name][i], 1e-9 * (perf_counter_ns() - begin))
    return taken


def _claims(preset: str, found: Mapping[str, Array]) -> list[Claim]:
    polynomial = float(np.median(found[_POLYNOMIAL]))
    claims = []
    for name in (_PLAIN, _PAPER, _FAST):
        factor = float(np.median(found[name])) / polynomial
        claims.append(
            Claim(
                f"Fig. 7, preset {preset}: the polynomial is at least 200 times faster than the FEM, {name}",
                "at least 200 times",
                f"{factor:.3g} times, {1e6 * polynomial:.2g} against {1e6 * np.median(found[name]):.3g} µs",
                verdict(_FACTOR, factor, f"a factor of {factor:.3g}"),
            )
        )
    return claims


def _picture(found: Mapping[str, Mapping[str, Array]]) -> Picture:
    names = list(next(iter(found.values())))
    low = min(float(taken.min()) for entries in found.values() for taken in entries.values())
    high = max(float(taken.max()) for entries in found.values() for taken in entries.values())
    edges = np.geomspace(0.8e6 * low, 1.2e6 * high, 80)
    with canvas(7.2, 4.2) as figure:
        for axes, (preset, entries) in zip(figure.subplots(2, 1, sharex=True), found.items(), strict=True):
            for name, color in zip(names, COLORS, strict=False):
                axes.hist(1e6 * entries[name], bins=list(edges), color=color, label=name)
            axes.set_xscale("log")
            axes.set_title(f"preset {preset}")
            axes.set_ylabel("poses")
            axes.grid(True, axis="x")
        figure.axes[1].set_xlabel("time of one answer [µs]")
        figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    columns: dict[str, list[float | str]] = {"preset": [], **{f"{name.replace(', ', '_').replace(' ', '_')}_s": []
                                                               for name in names}}  # fmt: skip
    for preset, entries in found.items():
        n = max(len(taken) for taken in entries.values())
        columns["preset"] += [preset] * n
        for column, taken in zip(list(columns)[1:], entries.values(), strict=True):
            columns[column] += [*taken.tolist(), *[np.nan] * (n - len(taken))]
    caption = "Fig. 7: histograms of the time of one answer, called from Python, on a logarithmic scale."
    return Picture("times", caption, figure, columns)
