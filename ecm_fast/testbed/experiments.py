"""Experiments: tables of loads in the order in which they are applied, with blank poses, for `measure` to fill."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..data.columns import COLUMNS
from ..data.measurements import Measurements
from ..errors import InputError, shown
from ..mechanism.catalogue import CATALOGUE
from ..mechanism.mechanism import Effects, Mechanism
from .laws import named
from .section import section

__all__ = ["compression_test", "in_sequence", "mass_test", "shear_test", "table", "tendon_test", "tilt_test"]

Array = NDArray[np.float64]

_BETWEEN = 5.0
"""Time that it takes to change a load [s]."""


def tendon_test(
    n: int = 300,
    *,
    grid: int = 0,
    lam_max: float = 160.0,
    replicated: int = 0,
    replicates: int = 1,
    dwell: float = 10.0,
    seed: int | np.random.Generator = 0,
) -> Measurements:
    """Return tendon forces between 0 and `lam_max` [N] in random order.

    Parameters
    ----------
    n : how many loads, drawn evenly; not used with a grid
    grid : with k > 0, the k x k loads of an even grid instead
    replicated, replicates : how many of the loads are applied `replicates` times, at different times
    dwell : how long each load is held [s]
    seed : of loads and order
    """
    rng = np.random.default_rng(seed)
    _check("lam_max", lam_max, lam_max > 0.0, "a number > 0")
    _check("grid" if grid else "n", grid or n, (grid or n) > 0, "a whole number > 0")
    _check("replicates", replicates, replicates >= 1, "a whole number >= 1")
    if grid:
        level = np.linspace(0.0, lam_max, grid)
        lam = np.stack(np.meshgrid(level, level, indexing="ij"), axis=-1).reshape(-1, 2)
    else:
        lam = rng.uniform(0.0, lam_max, (n, 2))
    _check("replicated", replicated, 0 <= replicated <= len(lam), f"a whole number from 0 to {len(lam)}")
    again = np.repeat(rng.permutation(len(lam))[:replicated], replicates - 1)
    load = rng.permutation(np.concatenate([np.arange(len(lam)), again]))
    return table("tendon", {"lam_l_N": lam[load, 0], "lam_r_N": lam[load, 1]}, load, dwell)


def shear_test(forces: ArrayLike, *, dwell: float = 10.0) -> Measurements:
    """Return side forces fz at Q [N], one a row, tendons off."""
    fz = _vector("forces", forces)
    return table("shear", {"fz_N": fz}, np.arange(fz.size), dwell)


def compression_test(
    length: float = 0.028,
    mechanism: Mechanism | None = None,
    *,
    shortening: float = 0.2,
    n: int = 21,
    weight: bool = False,
    dwell: float = 10.0,
) -> tuple[Mechanism, Measurements]:
    """Return a bare specimen and the pushes fx [N] that shorten it evenly up to a share of its length.

    Parameters
    ----------
    length : of the specimen [m]
    mechanism : its material; of the effects, those of the cross-section go with it
    shortening : largest share of the length, if the specimen stays straight [-]
    n : how many pushes, the first one is none
    weight : whether the specimen weighs anything
    dwell : how long each push is held [s]
    """
    _check("shortening", shortening, 0.0 < shortening < 1.0, "a number between 0 and 1")
    _check("n", n, n > 0, "a whole number > 0")
    neck = mechanism or Mechanism()
    of_section = {entry.name for effect in CATALOGUE.values() if effect.enters == "section" for entry in effect}
    specimen = replace(
        neck,
        beam=replace(neck.beam, length=length, mass_per_length=neck.beam.mass_per_length if weight else 0.0),
        head=replace(neck.head, mass=0.0),
        effects=Effects({name: value for name, value in neck.effects.items() if name in of_section}),
    )
    stretch = 1.0 - np.linspace(0.0, shortening, n)
    fx = section(named(specimen), 0.0, np.stack([stretch, 0.0 * stretch, 0.0 * stretch]))[0]
    return specimen, table("compression", {"fx_N": fx}, np.arange(n), dwell)


def tilt_test(tilts: ArrayLike, lam: ArrayLike = ((0.0, 0.0),), *, dwell: float = 10.0) -> Measurements:
    """Return every tilt of the test bed [rad] with every pair of tendon forces, `lam` (k, 2) [N]."""
    return _changed("tilt", "tilt_rad", _vector("tilts", tilts), lam, dwell)


def mass_test(masses: ArrayLike, lam: ArrayLike = ((0.0, 0.0),), *, dwell: float = 10.0) -> Measurements:
    """Return every mass added to the head [kg] with every pair of tendon forces, `lam` (k, 2) [N]."""
    return _changed("mass", "extra_mass_kg", _vector("masses", masses), lam, dwell)


def in_sequence(*tables: Measurements) -> Measurements:
    """Return several experiments as one, each a session of its own, begun when the one before is over.

    Loads of different sessions count as different, also where they are equal.
    """
    if not tables:
        raise InputError("no experiments to do in sequence; name at least one")
    columns: dict[str, Any] = {
        column.names[0]: np.concatenate([getattr(one, name) for one in tables]) for name, column in COLUMNS.items()
    }
    ends = np.cumsum([one.t[-1] + _BETWEEN for one in tables])
    begins = np.repeat([0.0, *ends[:-1]], [one.n for one in tables])
    session = np.repeat(np.arange(len(tables)) + 1, [one.n for one in tables])
    columns["t_s"] = columns["t_s"] + begins
    columns["session"] = [str(number) for number in session]
    columns["pose_id"] = [f"{number}: {label}" for number, label in zip(session, columns["pose_id"], strict=True)]
    return Measurements.from_columns(columns, source=" and ".join(dict.fromkeys(one.source for one in tables)))


def _changed(experiment: str, name: str, values: Array, lam: ArrayLike, dwell: float) -> Measurements:
    pairs = np.asarray(lam, dtype=np.float64)
    _check("lam", pairs.tolist(), pairs.ndim == 2 and pairs.shape[-1:] == (2,), "pairs of tendon forces, shape (k, 2)")
    change, left = np.repeat(values, len(pairs)), np.tile(pairs, (values.size, 1))
    columns = {name: change, "lam_l_N": left[:, 0], "lam_r_N": left[:, 1]}
    return table(experiment, columns, np.arange(change.size), dwell)


def table(
    experiment: str, columns: dict[str, Any], load: Sequence[int] | NDArray[np.int64], dwell: float | Array
) -> Measurements:
    """Return a table of loads; rows with the same entry in `load` repeat one load."""
    n = len(load)
    held = np.broadcast_to(np.asarray(dwell, dtype=np.float64), n)
    times = {"t_s": np.cumsum(held + _BETWEEN) - _BETWEEN, "dwell_s": held}
    labels = {"experiment": [experiment] * n, "pose_id": [f"{experiment} {i + 1}" for i in load], "session": ["1"] * n}
    return Measurements.from_columns({**columns, **times, **labels}, source=f"{experiment} test")


def _vector(name: str, values: ArrayLike) -> Array:
    vector = np.asarray(values, dtype=np.float64)
    _check(name, vector.tolist(), vector.ndim == 1 and vector.size > 0, "a list of numbers")
    return vector


def _check(name: str, value: object, good: bool, allowed: str) -> None:
    if not good:
        raise InputError(f"{name} = {shown(value)}: allowed is {allowed}")
