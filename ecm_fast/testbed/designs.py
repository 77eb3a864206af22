"""Experimental designs: sets of experiments on one neck, named by letters joined with ``+``, such as ``T+S``."""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from ..data.measurements import Measurements
from ..errors import InputError, shown
from .experiments import in_sequence, table

__all__ = ["DESIGNS", "GRID", "design"]

Array = NDArray[np.float64]
Rng = np.random.Generator

LAM_MAX = 160.0
"""Largest tendon force [N]."""
GRID = "grid"
"""``grid7`` is T with 7 x 7 loads."""

_DWELL = (5.0, 120.0)  # [s]


def design(
    name: str = "T",
    *,
    replicated: int = 0,
    replicates: int = 1,
    sessions: int = 1,
    seed: int | Rng = 0,
) -> Measurements:
    """Return the loads of a design, in the order in which they are applied, each held for 5 to 120 s.

    Parameters
    ----------
    name : letters of `DESIGNS` or ``grid7`` and the like, joined with ``+``; each is an experiment of its own session
    replicated, replicates : how many loads of the first experiment are applied `replicates` times, at different times
    sessions : in how many sessions the first experiment is done
    seed : of orders and times

    Raises
    ------
    InputError : no such design.
    """
    rng = np.random.default_rng(seed)
    tables = [_named(part, rng) for part in name.split("+")]
    tables[0] = _repeated(tables[0], replicated, replicates, rng)
    cuts = np.array_split(np.arange(tables[0].n), sessions) if sessions > 1 else []
    parts = [tables[0].select(rows) for rows in cuts] or tables[:1]
    return in_sequence(*(_from_zero(part) for part in parts), *tables[1:])


def _named(name: str, rng: Rng) -> Measurements:
    size = name.removeprefix(GRID)
    if name.startswith(GRID) and size.isascii() and size.isdigit() and 1 < int(size) <= 100:
        return _tendons(*_grid(int(size)), rng)
    if name not in DESIGNS:
        raise InputError(f"design = {shown(name)}: allowed are {', '.join(DESIGNS)}, {GRID}2 to {GRID}100, "
                         "joined with +")  # fmt: skip
    return DESIGNS[name](rng)


def _repeated(loads: Measurements, replicated: int, replicates: int, rng: Rng) -> Measurements:
    """Apply some of the loads again, at random times."""
    if not 0 <= replicated <= loads.n or replicates < 1:
        raise InputError(f"{replicated} loads {replicates} times: allowed are 0 to {loads.n} loads, once or more")
    again = np.repeat(rng.permutation(loads.n)[:replicated], replicates - 1)
    return loads.select(rng.permutation(np.concatenate([np.arange(loads.n), again]))) if again.size else loads


def _from_zero(loads: Measurements) -> Measurements:
    """Return the loads with times that follow from how long each is held."""
    filled = {"lam_l_N": loads.lam_l, "lam_r_N": loads.lam_r, "fx_N": loads.fx, "fz_N": loads.fz, "tau_Nm": loads.tau}
    changed = {"extra_mass_kg": loads.extra_mass, "tilt_rad": loads.tilt}
    load = [int(label.rpartition(" ")[2]) - 1 for label in loads.pose_id]
    return table(str(loads.experiment[0]), filled | changed, load, loads.dwell)


def _table(experiment: str, columns: Mapping[str, Array], rng: Rng) -> Measurements:
    n = len(next(iter(columns.values())))
    return table(experiment, dict(columns), np.arange(n), rng.uniform(*_DWELL, n))


def _grid(k: int) -> tuple[Array, Array]:
    level = np.linspace(0.0, LAM_MAX, k)
    left, right = np.meshgrid(level, level, indexing="ij")
    return left.ravel(), right.ravel()


def _tendons(left: Array, right: Array, rng: Rng, experiment: str = "tendon", **more: Array) -> Measurements:
    order = rng.permutation(left.size)
    columns = {"lam_l_N": left, "lam_r_N": right, **more}
    return _table(experiment, {name: values[order] for name, values in columns.items()}, rng)


def _one_sided(rng: Rng) -> Measurements:
    left, right = _grid(9)
    return _tendons(left[left >= right], right[left >= right], rng)


def _both_ways(rng: Rng) -> Measurements:
    """Go through a grid like an ox plows, and all the way back."""
    left, right = (values.reshape(5, 5) for values in _grid(5))
    right[1::2] = right[1::2, ::-1].copy()
    way = [np.concatenate([values.ravel(), values.ravel()[::-1]]) for values in (left, right)]
    return _table("both ways", {"lam_l_N": way[0], "lam_r_N": way[1]}, rng)


def _heavy(rng: Rng) -> Measurements:
    return _tendons(*_grid(5), rng, "mass", extra_mass_kg=np.full(25, 2.0))


def _tilted(rng: Rng) -> Measurements:
    """Seven pairs of forces, each with the test bed tilted to either side by 40 degrees."""
    left = np.array([0.0, 80.0, 0.0, 160.0, 0.0, 80.0, 160.0])
    right = np.array([0.0, 0.0, 80.0, 0.0, 160.0, 80.0, 160.0])
    tilt = np.repeat(np.radians([40.0, -40.0]), 7)
    return _tendons(np.tile(left, 2), np.tile(right, 2), rng, "tilt", tilt_rad=tilt)


DESIGNS: Mapping[str, Callable[[Rng], Measurements]] = {
    "T": lambda rng: _tendons(*_grid(9), rng),
    "T1": _one_sided,
    "S": lambda rng: _table("shear", {"fz_N": np.linspace(-66.0, 66.0, 9)}, rng),
    "C": lambda rng: _table("compression", {"fx_N": np.linspace(0.0, -300.0, 7)}, rng),
    "M": lambda rng: _table("moment", {"tau_Nm": np.linspace(-6.0, 6.0, 9)}, rng),
    "W": _heavy,
    "G": _tilted,
    "B": _both_ways,
}
"""Tendons on a 9 x 9 grid (T) or its left half (T1), side force (S), push (C) and couple (M) at Q without tendons,
2 kg more on the head (W), test bed tilted (G), a grid forth and back (B)."""
