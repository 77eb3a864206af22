"""Tendon forces for a wanted pose: two of tip position, tip angle and co-contraction."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, OutOfReach, real, shown
from .stepper import Stepper

__all__ = ["WISHES", "Inverse", "force_grid"]

Array = NDArray[np.float64]
Pair = tuple[float, float]
Residual = tuple[Pair, tuple[Pair, Pair]]
WISHES = ("x", "z", "theta", "co_contraction")
CO_CONTRACTION = 3  # the row of a wish behind x, z and theta
UNITS = ("m", "m", "rad", "N")
# a wish is met to this share of its scale: length, 1 rad, the largest force
MET = 1e-9
MAX_STEPS = 40  # of Gauss-Newton, with shorter ones at the bounds; what needs more is out of reach
SIDE = 9  # forces on a side of the grid of starts


def force_grid(lam_max: float) -> Array:
    """Return tendon forces (n, 2) [N] all over the allowed ones, from which to start.

    Raises
    ------
    InputError : the largest force is not positive.
    """
    if not 0.0 < real("lam_max", lam_max) < np.inf:
        raise InputError(f"lam_max = {shown(lam_max)}: allowed is a positive number")
    side = np.linspace(0.0, lam_max, SIDE)
    return np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)


class Inverse:
    """The inverse of a model under one dead wrench, over tendon forces from 0 to `lam_max`.

    Parameters
    ----------
    step : control step of the model with derivatives, see `FiniteElementModel.stepper`
    poses : tip poses (n, 3) at `grid` (n, 2), from which to start
    length : of the beam [m], the scale of positions
    """

    def __init__(self, step: Stepper, grid: Array, poses: Array, length: float, lam_max: float) -> None:
        self._step, self._jacobian = step, step.jacobian
        self._grid, self._lam_max = grid, lam_max
        self._scale = length, length, 1.0, lam_max
        self._starts: Array = np.column_stack([poses, grid.mean(axis=1)]) / self._scale

    def __call__(self, **wishes: float | None) -> Array:
        """Return tendon forces (2,) [N] that meet both wishes; see `FiniteElementModel.inverse`."""
        rows, wished = self._wished(wishes)
        goal = wished[0] / self._scale[rows[0]], wished[1] / self._scale[rows[1]]
        distance = np.square(self._starts[:, rows] - goal).sum(axis=1)
        order = np.argsort(distance)  # a start without a pose is nan, and comes last
        found = []
        for start in order[[0, 1, 4]]:
            lam, miss = self._descend((self._grid[start, 0].item(), self._grid[start, 1].item()), rows, goal)
            if _largest(miss) <= MET:
                return np.array(lam)
            found.append((_square(miss), lam, miss))
        _, lam, miss = min(found)
        reached = [(wish + missed) * self._scale[row] for wish, missed, row in zip(goal, miss, rows, strict=True)]
        raise OutOfReach(self._explain(rows, wished, reached, lam))

    def _wished(self, wishes: dict[str, float | None]) -> tuple[list[int], Pair]:
        given = {name: value for name, value in wishes.items() if value is not None}
        if len(given) != 2:
            raise InputError(f"{len(given)} wishes given: allowed are two of {', '.join(WISHES)}")
        for name, value in given.items():
            if not np.isfinite(real(name, value)):
                raise InputError(f"{name} = {shown(value)}: allowed is a finite number")
        first, second = (float(value) for value in given.values())
        return [WISHES.index(name) for name in given], (first, second)

    def _residual(self, lam: Pair, rows: list[int], goal: Pair) -> Residual:
        """Return how far both wishes are missed, scaled, and the derivatives of that by both forces."""
        pose = self._step(*lam)
        misses, slopes = [], []
        for row, wished in zip(rows, goal, strict=True):
            scale = self._scale[row]
            value = 0.5 * (lam[0] + lam[1]) if row == CO_CONTRACTION else pose[row]
            by = (0.5, 0.5) if row == CO_CONTRACTION else self._jacobian[row].tolist()
            misses.append(value / scale - wished if pose[3] == 0 else float("inf"))
            slopes.append((by[0] / scale, by[1] / scale))
        return (misses[0], misses[1]), (slopes[0], slopes[1])

    def _descend(self, lam: Pair, rows: list[int], goal: Pair) -> tuple[Pair, Pair]:
        """Minimize the distance to the goal over the box: Gauss-Newton, forces that would leave it held at its side.

        Returns the forces and how far both wishes are missed, scaled.
        """
        highest = self._lam_max
        miss, slopes = self._residual(lam, rows, goal)
        for _ in range(MAX_STEPS):
            change = _change(lam, highest, miss, slopes)
            share = 1.0
            while share > 1e-3:
                left, right = lam[0] + share * change[0], lam[1] + share * change[1]
                trial = min(max(left, 0.0), highest), min(max(right, 0.0), highest)
                new_miss, new_slopes = self._residual(trial, rows, goal)
                if _square(new_miss) < _square(miss) or _largest(new_miss) <= MET:
                    break
                share *= 0.5
            else:
                break
            moved = abs(trial[0] - lam[0]) + abs(trial[1] - lam[1])
            lam, miss, slopes = trial, new_miss, new_slopes
            if _largest(miss) <= 1e-3 * MET or moved <= 1e-12 * highest:
                break
        return lam, miss

    def _explain(self, rows: list[int], wished: Pair, reached: Sequence[float], lam: Pair) -> str:
        wish = ", ".join(f"{WISHES[row]} = {value:.6g} {UNITS[row]}" for row, value in zip(rows, wished, strict=True))
        near = ", ".join(f"{WISHES[row]} = {value:.6g} {UNITS[row]}" for row, value in zip(rows, reached, strict=True))
        return (
            f"{wish} is out of reach with tendon forces from 0 to {self._lam_max:g} N: "
            f"the nearest is {near} at ({lam[0]:.6g}, {lam[1]:.6g}) N"
        )


def _square(miss: Pair) -> float:
    return miss[0] * miss[0] + miss[1] * miss[1]


def _largest(miss: Pair) -> float:
    return max(abs(miss[0]), abs(miss[1]))


def _change(lam: Pair, highest: float, miss: Pair, slopes: tuple[Pair, Pair]) -> Pair:
    """Return the Gauss-Newton change of the forces; a force at a side of the box that would leave it is held."""
    (a, b), (c, d) = slopes
    gradient = a * miss[0] + c * miss[1], b * miss[0] + d * miss[1]
    free = [not (force <= 0.0 < g or (force >= highest and g < 0.0)) for force, g in zip(lam, gradient, strict=True)]
    det = a * d - b * c
    if all(free) and abs(det) > 1e-12 * (abs(a * d) + abs(b * c)):
        return (b * miss[1] - d * miss[0]) / det, (c * miss[0] - a * miss[1]) / det
    squares = a * a + c * c, b * b + d * d
    left = -gradient[0] / squares[0] if free[0] and squares[0] > 0.0 else 0.0
    right = -gradient[1] / squares[1] if free[1] and squares[1] > 0.0 else 0.0
    return left, right
