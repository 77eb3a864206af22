"""Random mechanisms and loads, and what every way of solving says of them against finer meshes.

    python3 tools/run.py python bench/robustness/random_worlds.py --count 20000 [--seed 0] [--first 0]

A world is a mechanism of any length from 1 mm to 10 m, its stiffnesses spread over six decades, with no effect, one or
two at 0.1 to 10 times their typical size, and one load that bends it anywhere from hardly to many times round.
World i of a seed is always the same, so a run can be cut into chunks.
"""

import argparse
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ecm_fast import FiniteElementModel, Status
from ecm_fast.errors import InputError
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.mechanism.mechanism import Mechanism
from ecm_fast.mechanism.parameters import find
from ecm_fast.mechanism.quantity import Quantity
from ecm_fast.mechanism.vector import pack

Array = NDArray[np.float64]

# log10 of the ranges: length [m], EI [N m^2], EA and GA in EI/L^2, forces in EI/L^2
LENGTH, BENDING, STIFFNESS, FORCE = (-3.0, 1.0), (-3.0, 3.0), (0.0, 6.0), (-3.0, 2.0)
# errors below this are rounding [rad, shares of the length]
FLOOR = 1e-9
# effects that the statics of one load know: neither the camera's nor those of what came before
STATIC = [effect for effect in CATALOGUE.values() if effect.enters not in ("camera", "path")]
UNITS = {
    "-": (0, 0), "rad": (0, 0), "m": (1, 0), "1/m": (-1, 0), "m^2": (2, 0), "1/m^2": (-2, 0), "N": (0, 1),
    "N/m": (-1, 1), "N m/rad": (1, 1), "rad/(N m)": (-1, -1), "m/N": (1, -1), "kg": (0, 1), "kg/m": (-1, 1),
}  # fmt: skip


@dataclass(frozen=True)
class World:
    """One random mechanism under one random load."""

    mechanism: Mechanism
    lam: Array
    wrench: Array


def world(seed: int, i: int) -> World:
    """Return world `i` of a seed: the first one drawn whose effects leave the mechanism possible."""
    rng = np.random.default_rng([seed, i])
    while True:
        with suppress(InputError):
            return _drawn_world(rng)


def _drawn_world(rng: np.random.Generator) -> World:
    length, EI = 10.0 ** rng.uniform(*LENGTH), 10.0 ** rng.uniform(*BENDING)
    unit = EI / length**2
    size = unit * 10.0 ** rng.uniform(*FORCE)
    weight, beam_weight = unit * 10.0 ** rng.uniform(-3.0, 1.0, 2) * rng.integers(0, 2, 2) / 9.81
    half = length * 10.0 ** rng.uniform(-1.0, 0.0)
    drawn = {
        "beam.length": length, "beam.EI": EI, "beam.EA": unit * 10.0 ** rng.uniform(*STIFFNESS),
        "beam.GA": unit * 10.0 ** rng.uniform(*STIFFNESS), "beam.mass_per_length": beam_weight / length,
        "head.mass": weight, "head.h": length * rng.uniform(0.0, 0.5), "head.b": length * rng.uniform(-0.1, 0.1),
        "tendons.plate_half_width": half, "tendons.pulley_x": length * rng.uniform(-0.5, 0.3),
        "tendons.pulley_z": half * 10.0 ** rng.uniform(-0.3, 0.3),
        "tendons.pulley_radius": 0.2 * half * rng.uniform(0.0, 1.0) * rng.integers(0, 2),
    }  # fmt: skip
    neck = Mechanism()
    drawn = {key: float(np.clip(value, find(key).lower, find(key).upper)) for key, value in drawn.items()}
    law = ("neo-hookean", "hooke")[rng.integers(0, 2)]
    effects: dict[str, float] = {}
    for k in rng.choice(len(STATIC), rng.integers(0, 3), replace=False):
        for n, entry in enumerate(STATIC[k]):
            effects[entry.key] = _drawn(entry, n == 0, length / neck.beam.length, unit, rng)
    kind = rng.integers(0, 3)  # tendons, a wrench, or both
    lam = size * rng.uniform(0.0, 1.0, 2) if kind != 1 else np.zeros(2)
    wrench = size * rng.uniform(-1.0, 1.0, 3) * [1.0, 1.0, length] if kind != 0 else np.zeros(3)
    return World(neck.replace(axial_law=law, **drawn, **effects), lam, wrench)


def _drawn(entry: Quantity, is_size: bool, scale: float, unit: float, rng: np.random.Generator) -> float:
    """Return a value of an effect's parameter, in units of the world's own length and force."""
    by_length, by_force = UNITS[entry.unit]
    factor = scale**by_length * (unit / (3.0 / 0.109**2)) ** by_force
    sign = 1.0 if entry.lower >= 0.0 else float(rng.choice([-1.0, 1.0]))
    value = sign * entry.typical * 10.0 ** rng.uniform(-1.0, 1.0) if is_size else entry.default
    return float(np.clip(value * factor, entry.lower, entry.upper))


def arrays(worlds: list[World]) -> tuple[Array, Array, Array]:
    """Return parameter vectors (n, n_parameters), tendon forces (n, 2) and wrenches (n, 3)."""
    par = np.stack([pack(each.mechanism) for each in worlds])
    return par, np.stack([each.lam for each in worlds]), np.stack([each.wrench for each in worlds])


@dataclass
class Comparison:
    """Disagreements of the ways of solving many worlds, counted.

    Attributes
    ----------
    worlds, solved : how many, and how many of them `solve` calls converged
    verdicts : worlds that `solve` and twice as many elements judge differently
    inaccurate, silent : poses off by more than the accuracy, and those of them whose `error` does not say so
    batch, step : worlds where a batch, or a control step, is off or judges differently without a word
    covered, tight : share of the estimates above the error, and below 30 times the error, either counted from a floor
    """

    worlds: int = 0
    solved: int = 0
    verdicts: list[int] = field(default_factory=list)
    inaccurate: list[int] = field(default_factory=list)
    silent: list[int] = field(default_factory=list)
    batch: list[int] = field(default_factory=list)
    step: list[int] = field(default_factory=list)
    off: list[float] = field(default_factory=list)
    estimates: list[float] = field(default_factory=list)
    coarse_off: list[float] = field(default_factory=list)
    coarse_estimates: list[float] = field(default_factory=list)

    def quality(self, *, coarse: bool = False) -> tuple[float, float]:
        """Return `covered` and `tight`: of the results, or of one element of order 5 before any refinement."""
        off = np.maximum(self.coarse_off if coarse else self.off, FLOOR)
        estimate = np.maximum(self.coarse_estimates if coarse else self.estimates, FLOOR)
        return float(np.mean(off <= estimate)), float(np.mean(estimate <= 30.0 * off))


def compare(seed: int, numbers: Iterable[int], accuracy: float = 1e-6) -> Comparison:
    """Solve worlds in every way, and compare with twice as many elements."""
    tally, chosen = Comparison(), list(numbers)
    worlds = [world(seed, i) for i in chosen]
    par, lam, wrench = arrays(worlds)
    many = FiniteElementModel(accuracy=accuracy).solve_batch(lam, wrench, parameters=par)
    for row, (i, each) in enumerate(zip(chosen, worlds, strict=True)):
        tally.worlds += 1
        model = FiniteElementModel(each.mechanism, accuracy=accuracy)
        length = each.mechanism.beam.length + each.mechanism.effects.get("beam_length", 0.0)
        unit = np.array([length, length, 1.0])
        loads = tuple(each.lam.tolist()), tuple(each.wrench.tolist())
        eq = model.solve(*loads)
        half = eq.discretization.halved
        fine = FiniteElementModel(each.mechanism, half.shares, half.order).solve(*loads)
        if eq.status != fine.status:
            tally.verdicts.append(i)
        if many.status[row] != eq.status or (eq.converged and _off(many.pose[row], eq.pose, unit) > accuracy):
            tally.batch.append(i)
        step = model.stepper(each.wrench)
        *pose, status = step(*loads[0])
        says_so = step.followed or status == Status.NOT_CONVERGED  # another branch, or not finished
        if status != eq.status and not says_so and not step.error > accuracy:
            tally.step.append(i)
        if not (eq.converged and fine.converged):
            continue
        tally.solved += 1
        off = _off(eq.pose, fine.pose, unit)
        tally.off.append(off)
        tally.estimates.append(eq.error)
        coarse = FiniteElementModel(each.mechanism, 1, 5).solve(*loads)
        if coarse.converged:
            tally.coarse_off.append(_off(coarse.pose, fine.pose, unit))
            tally.coarse_estimates.append(coarse.error)
        if off > accuracy:
            (tally.inaccurate if eq.error > accuracy else tally.silent).append(i)
        says_so = says_so or step.error > accuracy
        if status == eq.status and not says_so and _off(np.array(pose), fine.pose, unit) > 2.0 * accuracy:
            tally.step.append(i)
    return tally


def _off(pose: Array, other: Array, unit: Array) -> float:
    return float(np.abs((pose - other) / unit).max())


def main() -> None:
    """Compare worlds, and print the tally."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=1000)
    args = parser.parse_args()
    tally = compare(args.seed, range(args.first, args.first + args.count))
    print(f"{tally.worlds} worlds of seed {args.seed} from {args.first}, {tally.solved} solved")
    for name in ("verdicts", "inaccurate", "silent", "batch", "step"):
        print(f"{name}: {len(getattr(tally, name))} {getattr(tally, name)[:20]}")
    print("estimate above the error, below 30 times it: {:.4f}, {:.4f}".format(*tally.quality()))
    print("one element of order 5: {:.4f}, {:.4f}".format(*tally.quality(coarse=True)))


if __name__ == "__main__":
    main()
