"""Equilibria of the strong form: all rows integrated at once, shooting by Newton's method.

The unknowns of a row are the force at the tip and the couple at the clamp; see `strong_form` for the equations.

An equilibrium counts when it is stable and lies on the branch that grows from the unloaded beam. It is stable when
no section between clamp and tip is conjugate to the clamp (the beam does not buckle between two clamps) and the
stiffness that the head feels is positive definite.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data.measurements import Measurements
from ..errors import InputError
from ..mechanism.mechanism import Mechanism
from .history import Past, aged, needs_past, new, tendon_forces
from .laws import Loads, Parameters, chosen, length, named, plate, tip_wrench
from .strong_form import differentiated, integrate

__all__ = ["Equilibria", "Outcome", "equilibria"]

Array = NDArray[Any]

_CONVERGED = 1e-7  # Newton's step, in units of the beam; the next one would be its square
_ITERATIONS = 12  # Newton steps at most before the load step is cut
_FAR = (1.0, 1.0, 2.0)  # more than the tip moves in one step: x and z in lengths, theta [rad]
_SMALLEST_LOAD_STEP = 1.0 / 1024.0  # share of the load below which the branch has ended


class Outcome(IntEnum):
    """Outcome of a row."""

    STABLE = 0
    UNSTABLE = 1
    LOST = 2

    def explain(self, load_factor: float) -> str:
        """Say in words what happened at `load_factor` of the load."""
        return {
            Outcome.STABLE: "stable equilibrium",
            Outcome.UNSTABLE: f"buckles or snaps at {load_factor:.3g} of its load",
            Outcome.LOST: f"no equilibrium beyond {load_factor:.3g} of its load (it snaps, or a tendon is pulled up to "
            "its pulley)",
        }[self]


@dataclass(frozen=True, eq=False, repr=False)
class Equilibria:
    """One equilibrium a row.

    Attributes
    ----------
    pose : (n, 3) x, z, theta of Q [m, m, rad]; nan unless the outcome is stable
    outcome : (n,) values of `Outcome`
    load_factor : (n,) share of the load up to which a stable equilibrium was followed, 1 where it was found
    loads : the rows
    """

    pose: Array
    outcome: NDArray[np.int64]
    load_factor: Array
    loads: Measurements

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether each row has a pose, (n,)."""
        return np.equal(self.outcome, Outcome.STABLE)

    def raise_if_failed(self) -> "Equilibria":
        """Return itself, or raise `InputError` that names the first row without a stable equilibrium and why."""
        failed = np.flatnonzero(~self.stable)
        if failed.size:
            i = int(failed[0])
            rest = f", and {failed.size - 1} more rows fail" if failed.size > 1 else ""
            outcome = Outcome(int(self.outcome[i])).explain(float(self.load_factor[i]))
            raise InputError(f"{self.loads.where(i)}: {outcome}{rest}; lower the load or leave the row out")
        return self

    def __repr__(self) -> str:
        counts = ", ".join(f"{np.sum(self.outcome == kind)} {kind.name.lower()}" for kind in Outcome)
        return f"<Equilibria of {len(self.outcome)} rows: {counts}>"


def equilibria(
    mechanism: Mechanism, loads: Measurements, *, load_steps: int = 1, hidden: Mapping[str, float] | None = None
) -> Equilibria:
    """Return where the neck comes to rest under the loads of every row.

    Parameters
    ----------
    mechanism : what is built, effects included
    loads : forces as the cells read them without noise, wrenches and what was changed on the test bed, in the order
        of measurement; its poses are not read
    load_steps : how many equal steps the load is first tried in; a step that fails is halved
    hidden : sizes of effects of `OUTSIDE`, which no mechanism can have

    Raises
    ------
    InputError : an effect that the test bed has no law for.
    """
    p = named(mechanism, hidden)
    start = new(p) if needs_past(p) else p
    found, unknown = _followed(start, loads, tendon_forces(start, loads), load_steps, np.zeros((3, loads.n)))
    if start is p:
        return found
    past = Past.from_poses(start, loads, found.pose)
    return _followed(aged(p, past), loads, tendon_forces(p, loads, past), load_steps, unknown)[0]


def _followed(
    p: Parameters, loads: Measurements, lam: Array, load_steps: int, slope: Array
) -> tuple[Equilibria, Array]:
    """Follow every row's branch from the unloaded beam; returns the unknowns (3, n) too.

    lam : (2, n) forces that the tendons exert
    slope : (3, n) how the unknowns are expected to grow with the load
    """
    n, slope = loads.n, slope.copy()
    rows = Loads(lam, loads.wrench.T, loads.extra_mass, loads.tilt, np.ones(n))
    unknown, pose = np.zeros((3, n)), np.full((3, n), np.nan)
    factor, step = np.zeros(n), np.full(n, 1.0 / load_steps)
    outcome = np.full(n, Outcome.LOST, dtype=np.int64)
    while (which := np.flatnonzero((factor < 1.0) & (step >= _SMALLEST_LOAD_STEP))).size:
        aim = np.minimum(factor[which] + step[which], 1.0)
        guess = unknown[:, which] + slope[:, which] * (aim - factor[which])
        found, reached, verdict = _newton(chosen(p, which), rows.select(which).grown_to(aim), guess)
        good = verdict == Outcome.STABLE
        outcome[which] = verdict
        done = which[good]
        slope[:, done] = (found - unknown[:, which])[:, good] / (aim - factor[which])[good]
        unknown[:, done], pose[:, done], factor[done] = found[:, good], reached[:, good], aim[good]
        step[which] *= np.where(good, 2.0, 0.5)
    pose[:, outcome != Outcome.STABLE] = np.nan
    return Equilibria(pose.T.copy(), outcome, factor, loads), unknown


def _newton(p: Parameters, rows: Loads, unknown: Array) -> tuple[Array, Array, NDArray[np.int64]]:
    """Return unknowns (3, n), poses (3, n) and outcomes (n,) from a guess of the unknowns (3, n).

    A row is given up when an iterate is unstable, a step is more than half the one before, or a step moves the tip
    far: on such a walk Newton's method may cross to another branch.
    """
    n = unknown.shape[1]
    unknown, pose, last = unknown.copy(), np.full((3, n), np.nan), np.full(n, np.inf)
    outcome, active = np.full(n, Outcome.LOST, dtype=np.int64), np.arange(n)
    L, EI = length(p), float(np.mean(p["beam.EI"]))
    unit = np.array([[EI / L**2], [EI / L**2], [EI / L]])
    far = np.array(_FAR)[:, None] * [[L], [L], [1.0]]
    for _ in range(_ITERATIONS):
        step, miss, by_unknown, stable = _shoot(chosen(p, active), rows.select(active), unknown[:, active])
        size = np.abs(step / unit).max(axis=0)
        outcome[active[~stable]] = Outcome.UNSTABLE
        unknown[:, active] += step
        move = np.einsum("ijn,jn->in", by_unknown, step)
        pose[:, active] = miss + move
        done = stable & (size < _CONVERGED)
        outcome[active[done]] = Outcome.STABLE
        go_on = stable & ~done & (size < 0.5 * last[active]) & (np.abs(move) < far).all(axis=0)
        last[active] = size
        active = active[go_on]
        if not active.size:
            break
    return unknown, pose, outcome


def _shoot(p: Parameters, rows: Loads, unknown: Array) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Newton's step (3, n), pose of Q (3, n), its derivative by the unknowns (3, 3, n), and whether it is stable."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):  # a row that leaves the laws' domain is nan
        path, sound = integrate(p, rows, unknown)
        head = plate(p, path[..., -1])
        pose, by_unknown = head[:, 0], head[:, 1:]
        wrench, load_stiffness = differentiated(lambda at: tip_wrench(p, rows, at), pose)
        residual = np.stack([unknown[0], unknown[1], path[3, 0, :, -1]]) - wrench
        internal = np.stack([_ones(0, unknown), _ones(1, unknown), path[3, 1:, :, -1]])
        jacobian = internal - np.einsum("ijn,jkn->ikn", load_stiffness, by_unknown)
        sound &= np.isfinite(jacobian).all(axis=(0, 1)) & np.isfinite(residual).all(axis=0)
        jacobian[:, :, ~sound] = np.eye(3)[:, :, None]
        step = -np.linalg.solve(np.moveaxis(jacobian, 2, 0), residual.T[..., None])[..., 0].T
        stable = sound & _is_stable(path, jacobian, by_unknown, length(p))
    return step, pose, by_unknown, stable


def _ones(place: int, unknown: Array) -> Array:
    rows = np.zeros_like(unknown)
    rows[place] = 1.0
    return rows


def _is_stable(path: Array, jacobian: Array, by_unknown: Array, length: float) -> NDArray[np.bool_]:
    """No conjugate point on the way, and a positive definite stiffness at the head, (n,)."""
    conjugate = np.linalg.det(np.moveaxis(path[:3, 1:, :, 1:], (0, 1), (2, 3))) <= 0.0
    regular = ~conjugate.any(axis=1)
    stiffness = np.zeros((regular.size, 3, 3))
    pose_by = np.moveaxis(by_unknown, 2, 0)[regular]
    stiffness[regular] = np.moveaxis(jacobian, 2, 0)[regular] @ np.linalg.inv(pose_by)
    scale = np.array([1.0, 1.0, 1.0 / length])  # a congruence: it changes no sign of an eigenvalue
    stiffness = 0.5 * (stiffness + stiffness.swapaxes(1, 2)) * scale[:, None] * scale
    whole = np.isfinite(stiffness).all(axis=(1, 2))
    stiffness[~whole] = 0.0
    positive: NDArray[np.bool_] = regular & whole & (np.linalg.eigvalsh(stiffness)[:, 0] > 0.0)
    return positive
