"""Validation of a model's inputs: loads, parameter vectors, tolerances."""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..data.columns import PAIR
from ..errors import InputError, did_you_mean, real, shown
from ..kernels.layout import L_FX, L_GRAVITY, L_LAM_3, L_LAM_L, L_LAM_R, L_PRESTRAIN, N_LOADS
from ..mechanism.catalogue import CATALOGUE, FULL_SCALE, LARGEST_PUSH
from ..mechanism.parameters import PARAMETERS, PLACES, index, size
from ..mechanism.sections import AXIAL_LAWS
from ..mechanism.vector import check_tail

__all__ = [
    "LAM_PLACES",
    "MIN_TOLERANCE",
    "PAIR",
    "Names",
    "finite_load",
    "forces_by_name",
    "in_order",
    "last_step",
    "loads_of",
    "many_loads",
    "numbers",
    "one_load",
    "parameter_rows",
    "pushing",
]

Array = NDArray[np.float64]
Names = tuple[str, ...]
LAM_PLACES = (L_LAM_L, L_LAM_R, *range(L_LAM_3, N_LOADS))
"""Places of tendon forces among the kernels' loads."""
# Newton's method leaves at most this times the square of its last step (measured: 0.4 under tendons, 1.2 with wrenches)
QUADRATIC, MIN_TOLERANCE = 10.0, 1e-13
_CELLS = [index(effect.size.key) for effect in CATALOGUE.values() if effect.enters == "force"]


def last_step(tolerance: float) -> float:
    """Return the largest squared last step that leaves an error of at most `tolerance`."""
    if type(tolerance) is not float:  # most are: the check of others costs a solve a per cent
        tolerance = real("tolerance", tolerance)
    if not MIN_TOLERANCE <= tolerance <= 1e-3:
        raise InputError(f"tolerance = {shown(tolerance)}: allowed is a number from {MIN_TOLERANCE:g} to 1e-3")
    return tolerance / QUADRATIC


def numbers(name: str, values: ArrayLike) -> Array:
    """Return values as a contiguous array of at least one axis."""
    try:
        return np.atleast_1d(np.ascontiguousarray(values, dtype=np.float64))
    except (TypeError, ValueError):
        raise InputError(f"{name} = {shown(values)}: allowed is an array of numbers") from None


def many_loads(lam: ArrayLike, wrench: ArrayLike | None, names: Names = PAIR) -> tuple[Array, Array]:
    """Return tendon forces (n, m) and dead wrenches (n, 3) or, where all are the same, (1, 3); or raise.

    names : of the tendons; m is their number, or 2 where there are fewer, whose forces then are 0
    """
    tensions = numbers("tendon forces", lam)
    dead = np.zeros(3) if wrench is None else numbers("wrenches", wrench)
    if tensions.ndim != 2 or tensions.shape[1] != len(names):
        each = "two, left and right, a case" if names == PAIR else f"{len(names)} a case: {', '.join(names)}"
        raise InputError(f"tendon forces have shape {tensions.shape}: allowed is {each}")
    if dead.shape not in {(3,), (len(tensions), 3)}:
        raise InputError(f"wrenches have shape {dead.shape}: allowed is ({len(tensions)}, 3): fx, fz, tau a case")
    if (tensions < 0.0).any():
        row, side = np.argwhere(tensions < 0.0)[0]
        raise InputError(
            f"lam_{names[side]} = {tensions[row, side]} N in row {row}: allowed is >= 0, a tendon only pulls"
        )
    if len(names) < len(PAIR):
        tensions = np.hstack([tensions, np.zeros((len(tensions), len(PAIR) - len(names)))])
    return tensions, np.atleast_2d(dead)


def loads_of(lam: Array, wrench: Array) -> Array:
    """Return the kernels' loads of many cases, (n, N_LOADS).

    lam : (n, m) tendon forces, wrench : (1 or n, 3)
    """
    loads = np.zeros((len(lam), N_LOADS))
    loads[:, LAM_PLACES[: lam.shape[1]]], loads[:, L_FX:L_GRAVITY] = lam, wrench
    loads[:, [L_GRAVITY, L_PRESTRAIN]] = 1.0
    return loads


def one_load(lam: ArrayLike, wrench: ArrayLike, names: Names = PAIR) -> Array:
    """Return the kernels' loads of one case, (N_LOADS,), or raise where they cannot be meant."""
    loads = loads_of(*many_loads(numbers("tendon forces", lam)[None], numbers("wrench", wrench)[None], names))
    return np.asarray(loads[0])


def forces_by_name(lam: Mapping[str, float], names: Names) -> list[float]:
    """Return tendon forces in the order of `names`, 0 for what is not given; or raise for a name that is none."""
    for name in lam:
        if name not in names:
            raise InputError(f"no tendon is called {name!r}{did_you_mean(name, names)}; allowed are {', '.join(names)}")
    return [lam.get(name, 0.0) for name in names]


def in_order(lam: ArrayLike | Mapping[str, float] | None, names: Names) -> ArrayLike:
    """Return tendon forces in the order of `names`; None: none pulls."""
    if lam is None:
        return (0.0,) * len(names)
    return tuple(forces_by_name(lam, names)) if isinstance(lam, Mapping) else lam


def finite_load(lam: ArrayLike, wrench: ArrayLike, names: Names = PAIR) -> Array | tuple[float, ...]:
    """Return the loads of one case as `one_load` does, all of them finite, or raise; quick for tuples of two floats.

    For these without what follows `L_PRESTRAIN`, which is 0.
    """
    quick = isinstance(lam, tuple) and isinstance(wrench, tuple) and len(lam) == len(names) == 2 and len(wrench) == 3
    if quick:
        left, right, f_x, f_z, tau = loads = (*lam, *wrench)  # type: ignore[misc]  # tuples, both
        plain = type(left) is type(right) is type(f_x) is type(f_z) is type(tau) is float
        if plain and 0.0 <= left < np.inf and 0.0 <= right < np.inf and math.isfinite(f_x + f_z + tau):
            return (*loads, 1.0, 1.0)
    values = one_load(lam, wrench, names)
    bad = ~np.isfinite(values)
    if bad.any():
        places = dict(zip(LAM_PLACES, (f"lam_{name}" for name in names), strict=False))
        place = int(np.argmax(bad))
        name = places.get(place) or ("fx", "fz", "tau")[place - L_FX]
        raise InputError(f"{name} = {values[bad][0]}: allowed is a finite number")
    return values


def parameter_rows(values: ArrayLike, n: int) -> Array:
    """Return parameter vectors (n, n_parameters), or raise where they cannot be meant; names row and parameter."""
    par = numbers("parameters", values)
    if par.shape != (n, size()):
        raise InputError(f"parameters has shape {par.shape}: allowed is ({n}, {size()}), which counts the effects that "
                         "were added in this process")  # fmt: skip
    check_tail(par)
    lower, upper = (np.array([getattr(entry, bound) for entry in PARAMETERS]) for bound in ("lower", "upper"))
    known = par[:, : len(PARAMETERS)]
    outside = ~((known >= lower) & (known <= upper))
    if outside.any():
        row, place = np.argwhere(outside)[0]
        entry = PARAMETERS[place]
        raise InputError(f"row {row} of parameters: {entry.key} = {par[row, place]}: allowed is {entry.allowed}")
    laws = par[:, PLACES.beam_axial_law]
    neither = (laws != 0.0) & (laws != 1.0)
    if neither.any():
        row = int(np.argmax(neither))
        allowed = " or ".join(f"{number} ({law})" for number, law in enumerate(AXIAL_LAWS))
        raise InputError(f"row {row} of parameters: beam.axial_law = {laws[row]}: allowed is {allowed}")
    return par


def pushing(par: Array, lam: Array) -> NDArray[np.bool_] | None:
    """Return where a tendon would push by what the force cells are off, (n,), or None where none is off.

    par : (1 or n, n_parameters), lam : (n, 2) readings
    """
    if not par[:, _CELLS].any():
        return None
    side = np.array([0.5, -0.5])

    def effect(name: str) -> Array:
        return par[:, index(f"effects.{name}"), None]

    with np.errstate(all="ignore"):  # a load out of all proportion overflows; the solver refuses it
        gain = 1.0 + effect("force_gain") + side * effect("force_gain_asymmetry")
        zero = effect("force_zero") + side * effect("force_zero_asymmetry")
        bent = effect("force_nonlinearity") / FULL_SCALE * lam * lam
        force: Array = gain * lam + zero + bent + effect("force_crosstalk") * lam[:, ::-1]
    return np.asarray(np.less(force.min(axis=1), -LARGEST_PUSH))
