"""Training and test data of polynomial models: poses with the wrench that holds the tip there, (48), Fig. 5.

A wrench here is what tendons and external loads together do at Q, in world axes. The weights of beam and head are
not part of it, since they act always: the polynomial stands for the neck with its weight. Under a dead wrench the
two are the same thing; under tendons it is P(q) lambda (40) plus the dead wrench of the row, if any.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...data.measurements import Measurements
from ...errors import InputError, NotConverged
from ...kernels.general.tip import tip_wrench
from ...kernels.layout import L_FX, L_GRAVITY, L_PRESTRAIN, N_LOADS, T_JOINT
from ..finite_element import FiniteElementModel
from ..instruments.rest_pose import absolute
from ..path_state import PathChoice
from .model import PolynomialModel

__all__ = [
    "WRENCH_BOX",
    "TrainingSet",
    "WrenchErrors",
    "measured_wrenches",
    "relative_errors",
    "tip_wrenches",
    "training_poses",
    "training_rows",
]

Array = NDArray[np.float64]

WRENCH_BOX = ((-330.0, -80.0, -11.0), (20.0, 80.0, 11.0))
"""Least and largest fx, fz, tau of (48) [N, N, N m]."""

_DRAWS_PER_POSE = 100
"""A box in which fewer than one wrench in so many holds the neck is not worth searching."""


@dataclass(frozen=True, eq=False)
class TrainingSet:
    """Poses and the wrenches that hold the tip there; sets add up.

    Attributes
    ----------
    poses : (n, 3) x, z, theta [m, m, rad]
    wrenches : (n, 3) fx, fz, tau [N, N, N m], without the weights of beam and head
    dropped : how many candidates were left out
    """

    poses: Array
    wrenches: Array
    dropped: int

    @classmethod
    def empty(cls) -> Self:
        """Return a set of no poses, to add to."""
        return cls(np.empty((0, 3)), np.empty((0, 3)), 0)

    def __add__(self, other: Self) -> Self:
        poses, wrenches = np.concatenate([self.poses, other.poses]), np.concatenate([self.wrenches, other.wrenches])
        return type(self)(poses, wrenches, self.dropped + other.dropped)

    def __len__(self) -> int:
        return len(self.poses)

    def __repr__(self) -> str:
        return f"<TrainingSet: {len(self)} poses, {self.dropped} dropped>"


def training_poses(
    model: FiniteElementModel,
    n: int,
    seed: int | np.random.Generator,
    box: tuple[ArrayLike, ArrayLike] | None = None,
    *,
    path: PathChoice = None,
) -> TrainingSet:
    """Return `n` poses of a model under random dead wrenches; what is not a stable equilibrium is dropped and redrawn.

    Parameters
    ----------
    seed : for the wrenches, or their generator
    box : (3,) least and (3,) largest wrench [N, N, N m], between which they are evenly spread; default the paper's
    path : see `FiniteElementModel.solve`

    Raises
    ------
    NotConverged : hardly any wrench of the box holds the neck in a stable pose.
    """
    if n < 1:
        raise InputError(f"n = {n}: allowed is a whole number >= 1")
    lower, upper = _box(WRENCH_BOX if box is None else box)
    model = model.at_state(path, "training_poses")
    rng, kept = np.random.default_rng(seed), TrainingSet.empty()
    while len(kept) < n:
        wrenches = rng.uniform(lower, upper, (n - len(kept), 3))
        result = model.solve_batch(np.zeros((len(wrenches), 2)), wrenches, path="ignore")
        stable = result.stable
        kept += TrainingSet(result.pose[stable], wrenches[stable], int(np.sum(~stable)))
        if kept.dropped > _DRAWS_PER_POSE * n:
            raise NotConverged(f"only {len(kept)} of {len(kept) + kept.dropped} random wrenches hold the neck in a "
                               "stable pose; choose a smaller box")  # fmt: skip
    return kept


def training_rows(model: FiniteElementModel, data: Measurements, *, path: PathChoice = None) -> TrainingSet:
    """Return the measured poses of `data` with the wrench of tendons and dead loads there, see `measured_wrenches`.

    Raises
    ------
    InputError : no row is left, or the tendons' forces depend on the path and `path` is not given.
    """
    data = absolute(model.mechanism, data)
    wrenches = measured_wrenches(model, data, path=path)
    known = np.isfinite(wrenches).all(axis=1)
    if not known.any():
        raise InputError(f"{data.source}: none of {data.n} rows has a whole pose, without extra mass and tilt")
    return TrainingSet(data.pose[known], wrenches[known], int(np.sum(~known)))


def measured_wrenches(model: FiniteElementModel, data: Measurements, *, path: PathChoice = None) -> Array:
    """Return the wrench of tendons and dead loads at the measured poses of `data`, (n, 3) [N, N, N m].

    It is nan in rows without a whole pose, where a pulling tendon has no direction, and in rows with an extra mass or
    a tilt: these change what acts always. path : see `FiniteElementModel.solve`
    """
    data = absolute(model.mechanism, data)
    wrenches = tip_wrenches(model, data.pose, data.lam, data.wrench, path=path)
    unknown = ~data.measured.all(axis=1) | (data.extra_mass != 0.0) | (data.tilt != 0.0)
    wrenches[unknown | ~np.isfinite(wrenches).all(axis=1)] = np.nan
    return wrenches


def tip_wrenches(
    model: FiniteElementModel,
    poses: ArrayLike,
    lam: ArrayLike,
    wrenches: ArrayLike | None = None,
    *,
    path: PathChoice = None,
) -> Array:
    """Return what tendons and dead wrenches together do at Q at the poses, P(q) lambda (40) + wrench.

    Parameters
    ----------
    model : whose tendons pull
    poses : (n, 3) x, z, theta [m, m, rad]
    lam : (n, 2) tendon forces [N]
    wrenches : (n, 3) dead wrenches [N, N, N m]; default none
    path : see `FiniteElementModel.solve`

    Returns
    -------
    (n, 3) fx, fz, tau [N, N, N m]; nan where a pulling tendon's attachment lies inside its pulley.
    """
    tip, K = model.at_state(path, "tip_wrenches").tip, np.empty(6)
    tip[T_JOINT] = 0.0  # the poses are the head's
    places, tensions = np.atleast_2d(np.asarray(poses, dtype=np.float64)), np.atleast_2d(lam)
    loads, acting = np.zeros((len(places), N_LOADS)), np.empty((len(places), 3))
    loads[:, :L_FX], loads[:, L_PRESTRAIN] = tensions, 1.0
    if wrenches is not None:
        loads[:, L_FX:L_GRAVITY] = wrenches
    for load, (x, z, theta), row in zip(loads, places, acting, strict=True):
        tip_wrench(tip, load, x, z, theta, row, K)  # no share of gravity: the head's weight is left out
    return acting


@dataclass(frozen=True, eq=False)
class WrenchErrors:
    """Errors of predicted wrenches, component by component: the paper's Fig. 5.

    Attributes
    ----------
    observed : (n, 3) fx, fz, tau [N, N, N m]; nan where not known
    predicted : (n, 3)
    """

    observed: Array
    predicted: Array

    @property
    def relative(self) -> Array:
        """(predicted - observed) / observed, (n, 3)."""
        return (self.predicted - self.observed) / self.observed

    @property
    def rms(self) -> Array:
        """Root mean square of predicted less observed, (3,) [N, N, N m]; nan where nothing is known."""
        squares = (self.predicted - self.observed) ** 2
        known = np.isfinite(squares)
        with np.errstate(invalid="ignore"):
            rms: Array = np.sqrt(np.sum(np.where(known, squares, 0.0), axis=0) / np.sum(known, axis=0))
        return rms

    def share(self, limit: float = 0.02) -> Array:
        """Return which share of the points lies within +- limit, (3,)."""
        within: Array = np.mean(np.abs(self.relative) <= limit, axis=0)
        return within

    def largest_outlier(self, limit: float = 0.02) -> Array:
        """Return the largest size of an observed component that is missed by more than the limit, (3,) [N, N, N m]."""
        missed = ~(np.abs(self.relative) <= limit)
        largest: Array = np.where(missed, np.abs(self.observed), 0.0).max(axis=0)
        return largest

    def __repr__(self) -> str:
        shares = ", ".join(f"{name} {share:.1%}" for name, share in zip(("fx", "fz", "tau"), self.share(), strict=True))
        return f"<WrenchErrors of {len(self.observed)} poses: within 2 %: {shares}>"


def relative_errors(poly: PolynomialModel, test: TrainingSet) -> WrenchErrors:
    """Return how far a polynomial model is off at poses it was not trained on; no warning beyond its range."""
    return WrenchErrors(test.wrenches, poly.polynomial(test.poses))


def _box(box: tuple[ArrayLike, ArrayLike]) -> tuple[Array, Array]:
    try:
        lower, upper = (np.asarray(corner, dtype=np.float64) for corner in box)
    except (TypeError, ValueError):
        raise InputError(f"box = {box!r}: allowed are the least and the largest fx, fz, tau") from None
    if lower.shape != (3,) or upper.shape != (3,) or not (np.isfinite([lower, upper]).all() and (lower <= upper).all()):
        raise InputError(f"box = {box!r}: allowed are the least and the largest fx, fz, tau, finite and in this order")
    return lower, upper
