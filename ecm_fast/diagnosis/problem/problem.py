"""The problem of a diagnosis: rows, calibration parameters, hold-out rows and weights."""

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...data.measurements import Measurements
from ...errors import InputError
from ...identification.noise import ReadingNoise
from ...identification.rows import FitRows, FitSet, State, common_mesh, prior_std
from ...mechanism.catalogue import CATALOGUE
from ...mechanism.mechanism import Mechanism
from ...mechanism.parameters import find, index
from ...mechanism.vector import pack
from ...models.instruments.rest_pose import ADDED_BY_SESSION
from ..statistics.priors import ROUGHLY, Priors
from ..statistics.robust_noise import RowOrder
from .candidates import EffectCandidate
from .holdout import lock
from .progress import Progress
from .stiffness_scale import STIFFNESS_KEYS

__all__ = ["DRIFT", "Problem", "Weights"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_FEWEST = 3  # rows: three readings for each stiffness
_NEAR_ZERO = 2.0  # standard deviations of a force cell within which its reading is that of a slack tendon
_ZERO_SHIFT = 0.5  # the mean by which such a reading is off, in the same unit
DRIFT = 0.25
"""Drift of an instrument from the first to the last row of a file and nobody know, as a share of its noise."""
_SHORT, _FEW = 20, 4  # rows from which on a file drifts, and how many files may do so each in its own way


@dataclass(frozen=True, eq=False)
class Weights:
    """Weights of readings around one state.

    Attributes
    ----------
    whitening : (n, 3, 3), see `identification_rows.Noise`
    sigma : (n, 3) noise of the camera that it rests on
    shift : (n, 3, s) whitened change of the pose by what instruments hide, one standard deviation of it
    build : (n, 3, b) the same by dimensions of which the drawing tells one thing and the build another
    """

    whitening: Array
    sigma: Array
    shift: Array = field(repr=False)
    build: Array = field(repr=False)


class Problem:
    """Measurements on a mechanism, what is uncertain about it, and the effects it may lack."""

    def __init__(
        self,
        mechanism: Mechanism,
        data: Sequence[Measurements],
        candidates: Sequence[EffectCandidate],
        uncertain: Mapping[str, float],
        priors: Mapping[str, tuple[float, float]],
        *,
        force_sigma: float | None,
        seed: int,
        progress: Progress | None = None,
    ) -> None:
        mechanism.check_pair("a diagnosis")
        self.mechanism, self.data, self.candidates = mechanism, tuple(data), tuple(candidates)
        self.force_sigma, self.drift = force_sigma, DRIFT
        self.progress = progress or Progress()
        self.keys = (*STIFFNESS_KEYS, *(key for key in uncertain if key not in STIFFNESS_KEYS))
        self.prior = self._priors(uncertain, priors)
        sizes = (effect.size for effect in CATALOGUE.values())
        self.tolerances = {size.key: size.tolerance for size in sizes if size.tolerance and size.key not in self.keys}
        self.sets = [FitSet(mechanism, part) for part in data]
        self.mesh, self.unresolved = common_mesh(self.sets)
        self.par = pack(mechanism)
        self.rows = self.solver(())
        self.wanted = self.rows.wanted
        if int(self.wanted.any(axis=1).sum()) < _FEWEST:
            raise InputError(f"{data[0].source}: {int(self.wanted.any(axis=1).sum())} rows with a measured pose; "
                             f"a diagnosis takes at least {_FEWEST}")  # fmt: skip
        self.locked = lock(data, seed)
        self.open = np.flatnonzero(~self.locked & self.wanted.any(axis=1))
        session = np.concatenate([part.session for part in data])
        self.run = np.unique(np.rec.fromarrays([self.rows.member, session]), return_inverse=True)[1]

    def _priors(self, uncertain: Mapping[str, float], priors: Mapping[str, tuple[float, float]]) -> Priors:
        """Return what is known of everything that calibration may move."""
        known = {find(name).key: entry for name, entry in priors.items()}
        par, table = pack(self.mechanism), []
        for key in self.keys:
            rough = key in STIFFNESS_KEYS and key not in known
            center, std = known.pop(key, (float(par[index(key)]), ROUGHLY if rough else uncertain.get(key, np.inf)))
            center = find(key).check(center)
            table.append((center, prior_std(key, center, std, free=True), rough))
        for key in known:
            raise InputError(f"a prior for {key}, which calibration does not move: declare it uncertain too")
        columns = [np.array(column) for column in zip(*table, strict=True)]
        return Priors(*columns)

    def solver(self, extra: Sequence[str], rows: NDArray[np.int64] | None = None) -> FitRows:
        """Return rows, default all, as functions of what calibration moves and of `extra` parameters."""
        added = [key for key in extra if key not in self.keys]
        return FitRows(self.sets, (*self.keys, *added), self.mesh, rows)

    @cached_property
    def rest_keys(self) -> dict[str, int]:
        """Place in `rest` of the effects of the camera, by the key of their size."""
        camera = [candidate.keys[0] for candidate in self.candidates if candidate.effect.enters == "camera"]
        return {key: i for i, key in enumerate(camera)}

    @cached_property
    def rest(self) -> Array:
        """Derivatives of the readings of the unloaded neck by the sizes of the camera's effects, (k, 3)."""
        none = Measurements.from_columns({"lam_l_N": [0.0], "lam_r_N": [0.0]})
        rows = FitRows([FitSet(self.mechanism, none)], tuple(self.rest_keys), self.mesh)
        return np.asarray(rows.at(self.start(rows.names)).by[0].T)

    def keys_of(self, model: Sequence[int]) -> list[str]:
        """Return the keys of all parameters of the candidates at these places."""
        return [key for i in model for key in self.candidates[i].keys]

    def state(self, extra: Sequence[str], values: Mapping[str, float]) -> State:
        """Return all rows at values by key; what is not among them is as in the mechanism."""
        solver = self.solver(extra)
        starts = zip(solver.names, self.start(solver.names).tolist(), strict=True)
        return solver.at(np.array([values.get(key, start) for key, start in starts]))

    def by(self, rows: NDArray[np.int64]) -> "Problem":
        """Return the same with `rows`, places that rise, the only ones that a search looks at."""
        few = copy(self)
        few.open = rows
        return few

    def chain(self, rows: NDArray[np.int64]) -> RowOrder:
        """Return the order of rows, places that rise."""
        return RowOrder.from_runs(self.run, rows)

    def start(self, keys: Sequence[str]) -> Array:
        """Return the mechanism's own values of parameters."""
        return self.par[[index(key) for key in keys]]

    def noise(self, state: State) -> ReadingNoise:
        """Return what is known of the noise before anything is fitted."""
        return ReadingNoise.from_rows(self.rows, state, self.force_sigma)

    def weights(self, noise: ReadingNoise, state: State, names: Sequence[str] = ()) -> Weights:
        """Return how the readings of its stable rows count around a state, the force cells' noise carried through.

        names : keys of the state's derivatives; only with them does it count that no build is quite as drawn
        """
        used = self.wanted & state.stable[:, None]
        sigma = noise.filled(self.rows, state, used)
        whitening = noise.whitening(np.where(np.isfinite(sigma), sigma, 1.0), state, used)
        dpose_dlam = np.where(used[:, :, None], np.nan_to_num(state.dpose_dlam), 0.0)
        by_camera = np.where(used, np.nan_to_num(sigma), 0.0)[:, :, None] * np.eye(3)
        hidden = [self._near_zero(noise.force, dpose_dlam), self._drift(noise.force, dpose_dlam, by_camera),
                  self._zeros(by_camera)]  # fmt: skip
        build = self._build(state, used, names)
        return Weights(whitening, sigma, whitening @ np.concatenate(hidden, axis=2), whitening @ build)

    def _near_zero(self, force: Array, dpose_dlam: Array) -> Array:
        """Return what slack tendons change where their readings are not below zero, (n, 3, 1) or none of it."""
        lam = np.concatenate([part.lam for part in self.data])
        near = force[:, None] * (lam < _NEAR_ZERO * force[:, None]) * _ZERO_SHIFT
        shift: Array = (dpose_dlam * near[:, None, :]).sum(axis=2, keepdims=True)
        return shift if near.any() else shift[:, :, :0]

    def _zeros(self, by_camera: Array) -> Array:
        """Return what the noise of the readings adds that poses are zeroed by, each file or session its own, (n, 3, s).

        One alone is an origin, which is calibrated.
        """
        sessions = any(part.zeroed == ADDED_BY_SESSION for part in self.data)
        apart = self.run if sessions else self.rows.member
        if not self.data[0].zeroed or apart.max() == 0:
            return by_camera[:, :, :0]
        return np.concatenate([by_camera * (apart == k)[:, None, None] for k in range(apart.max() + 1)], axis=2)

    def _build(self, state: State, used: Mask, names: Sequence[str]) -> Array:
        """Return what each dimension does that is off by its tolerance, (n, 3, b)."""
        tolerances = {key: value for key, value in self.tolerances.items() if key in names}
        by: Array = state.by[:, :, [names.index(key) for key in tolerances]] * np.array(list(tolerances.values()))
        return np.where(used[:, :, None], np.nan_to_num(by), 0.0)

    def _drift(self, force: Array, dpose_dlam: Array, by_camera: Array) -> Array:
        """Return what little the camera's channels and both force cells drift in a file, (n, 3, s)."""
        each = self.drift * np.concatenate([by_camera, dpose_dlam * force[:, None, None]], axis=2)
        files = [self.rows.member == i for i, part in enumerate(self.data) if part.n >= _SHORT]
        elapsed = np.zeros((len(files), self.rows.n))
        for column, in_file in zip(elapsed, files, strict=True):
            column[in_file] = np.linspace(0.0, 1.0, int(in_file.sum()))
        if len(files) > _FEW:
            elapsed = elapsed.sum(axis=0, keepdims=True)
        found = np.concatenate([each[:, :, :0], *(each * column[:, None, None] for column in elapsed)], axis=2)
        return found[:, :, found.any(axis=(0, 1))]
