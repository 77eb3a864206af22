"""Load cases, the converged solution, and the errors of a discretization."""

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...data.measurements import Measurements
from ...errors import InputError, shown
from ...mechanism.mechanism import Mechanism
from ...models.equilibrium import BatchResult
from ...models.finite_element import FiniteElementModel
from ...models.loads import numbers
from ...models.polynomial.training import WRENCH_BOX
from .candidates import Candidate, ending_at_jumps

__all__ = ["LARGEST_TENDON_FORCE", "ROUNDING", "Converged", "LoadSet", "converged", "error_maps", "errors", "short"]

Array = NDArray[np.float64]
LARGEST_TENDON_FORCE = 160.0  # [N], the paper's Section 3
# below these, Newton's last step and rounding hide what the discretization leaves
_TOLERANCE, ROUNDING = 1e-13, 1e-13
_FINEST_ORDER, _FINEST = 6, (4, 8, 16, 32, 64)


@dataclass(frozen=True, eq=False)
class LoadSet:
    """Load cases over which a discretization is judged.

    Attributes
    ----------
    name : "tendons", "box" or where they come from
    lam : (n, 2) tendon forces [N]
    wrench : (n, 3) dead wrenches at Q [N, N, N m]
    """

    name: str
    lam: Array = field(repr=False)
    wrench: Array = field(repr=False)

    @classmethod
    def drawn(cls, name: str, n: int, rng: int | np.random.Generator, *, corners: bool = True) -> Self:
        """Return `n` random loads: "tendons", 0 to 160 N each, or "box", the paper's dead wrenches (48).

        corners : put the corners of the range first, where errors are largest
        """
        ends = {"tendons": np.array([[0.0] * 2, [LARGEST_TENDON_FORCE] * 2]), "box": np.array(WRENCH_BOX)}
        if name not in ends:
            raise InputError(f"loads = {shown(name)}: allowed is 'tendons', 'box' or load cases")
        lower, upper = ends[name]
        loads = np.random.default_rng(rng).uniform(lower, upper, (n, lower.size))
        if corners:
            unit = np.stack(np.meshgrid(*[[0.0, 1.0]] * lower.size), axis=-1).reshape(-1, lower.size)
            loads[: len(unit)] = (lower + unit * (upper - lower))[:n]
        none = np.zeros((n, 5 - lower.size))
        return cls(name, *((loads, none) if name == "tendons" else (none, loads)))

    @classmethod
    def from_loads(cls, loads: "Measurements | LoadSet | ArrayLike") -> "LoadSet":
        """Return load cases as a set: of measurements, (n, 2) tendon forces, or (n, 5) with dead wrenches."""
        if isinstance(loads, LoadSet):
            return loads
        if isinstance(loads, Measurements):
            plain = (loads.extra_mass == 0.0) & (loads.tilt == 0.0)
            return cls(loads.source, loads.lam[plain], loads.wrench[plain])
        rows = np.atleast_2d(numbers("loads", loads))
        if rows.ndim != 2 or rows.shape[1] not in (2, 5):
            raise InputError(f"loads have shape {rows.shape}: allowed is (n, 2) tendon forces, or (n, 5) with wrenches")
        return cls("given", rows[:, :2].copy(), rows[:, 2:].copy() if rows.shape[1] == 5 else np.zeros((len(rows), 3)))

    def select(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> "LoadSet":
        """Return some of the cases."""
        return replace(self, lam=self.lam[which], wrench=self.wrench[which])

    def solve(self, model: FiniteElementModel) -> BatchResult:
        """Solve all cases as exactly as Newton's method can, on all cores; effects of the path are left out."""
        return model.solve_batch(
            self.lam, self.wrench, tolerance=_TOLERANCE, threads=os.cpu_count() or 1, path="ignore"
        )

    def __len__(self) -> int:
        return len(self.lam)


@dataclass(frozen=True, eq=False)
class Converged:
    """Converged solutions that errors are measured against.

    Attributes
    ----------
    loads : the cases that hold the neck in a stable pose
    pose : (n, 3) [m, m, rad]
    error : largest difference to half as many elements: more than the solution is off by
    elements : how many elements of order 6
    dropped : how many cases have no stable equilibrium
    """

    loads: LoadSet
    pose: Array = field(repr=False)
    error: float
    elements: int
    dropped: int


def converged(mechanism: Mechanism, loads: LoadSet) -> Converged:
    """Refine elements of order 6 until twice as many say the same to rounding; they end where the stiffness jumps."""
    if not len(loads):
        raise InputError(f"loads: {loads.name} has no case without extra mass and tilt")
    length, last, gap = np.array([mechanism.beam.length] * 2 + [1.0]), None, math.inf
    for count in _FINEST:
        result = loads.solve(FiniteElementModel(mechanism, ending_at_jumps(mechanism, count), _FINEST_ORDER))
        if last is not None:
            both = result.stable & last.stable
            before, gap = gap, float((np.abs(result.pose - last.pose) / length)[both].max(initial=0.0))
            if gap <= ROUNDING or gap > 0.25 * before:
                break
        last = result
    stable = result.stable
    if not stable.any():
        raise InputError(f"loads: none of {len(loads)} cases holds the neck in a stable pose; lower them")
    return Converged(loads.select(stable), result.pose[stable], gap, count, int(np.sum(~stable)))


def errors(model: FiniteElementModel, known: Converged) -> tuple[Array, Array]:
    """Return two errors of every case, (n,) each: the largest of x/L, z/L and theta, and the tip's distance/L.

    Both are inf where the model finds no stable equilibrium.
    """
    length, result = model.mechanism.beam.length, known.loads.solve(model)
    off = np.abs(result.pose - known.pose) / [length, length, 1.0]
    distance = np.hypot(off[:, 0], off[:, 1])
    return np.where(result.stable, off.max(axis=1), np.inf), np.where(result.stable, distance, np.inf)


def error_maps(mechanism: Mechanism, chosen: Sequence[Candidate], side: int = 33) -> tuple[Array, Array]:
    """Return tendon forces on a grid, (n, 2) [N], the left one slowest, and each candidate's errors there, (n, k)."""
    ends = np.linspace(0.0, LARGEST_TENDON_FORCE, side)
    known = converged(
        mechanism, LoadSet.from_loads(np.stack(np.meshgrid(ends, ends, indexing="ij"), axis=-1).reshape(-1, 2))
    )
    maps = [errors(candidate.model(mechanism), known)[0] for candidate in chosen]
    return known.loads.lam, np.stack(maps, axis=1)


def short(error: float) -> str:
    """Return an error with one digit: 2e-7."""
    digits, _, exponent = f"{error:.0e}".partition("e")
    return f"{digits}e{int(exponent)}" if exponent else digits
