"""A mechanism as the flat parameter vector, and back."""

from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .catalogue import CATALOGUE
from .mechanism import Effects, Mechanism
from .parameters import N_BUILT_IN, PARAMETERS, USER_LAWS, index, size
from .sections import AXIAL_LAWS, EFFECT_QUANTITIES, SECTIONS

__all__ = ["pack", "unpack"]


def pack(mechanism: Mechanism) -> NDArray[np.float64]:
    """Return the parameter vector of a mechanism, shape (n_parameters,), see `size`."""
    par = np.array([entry.default for entry in PARAMETERS])
    if size() > len(PARAMETERS):
        par = np.concatenate([par, [float(USER_LAWS["section"]), float(USER_LAWS["head"]), _sizes()]])
    for key, value in mechanism.values().items():
        par[index(key)] = AXIAL_LAWS.index(value) if isinstance(value, str) else value
    return par


def unpack(par: NDArray[np.float64]) -> Mechanism:
    """Return the mechanism of a parameter vector; the inverse of `pack`, without loss.

    Raises
    ------
    InputError : wrong length, a value out of its bounds, or an axial law that is neither 0 nor 1.
    """
    vector = np.asarray(par, dtype=np.float64)
    if vector.shape != (size(),):
        raise InputError(f"a parameter vector has shape ({size()},), not {vector.shape}")
    values: dict[str, Any] = {entry.key: float(vector[place]) for place, entry in enumerate(PARAMETERS)}
    law = values["beam.axial_law"]
    if law not in (0.0, 1.0):
        raise InputError(f"beam.axial_law = {law!r}: allowed is 0 ({AXIAL_LAWS[0]}) or 1 ({AXIAL_LAWS[1]})")
    values["beam.axial_law"] = AXIAL_LAWS[int(law)]
    parts = {
        name: section(**{item.name: values[f"{name}.{item.name}"] for item in fields(section)})
        for name, section in SECTIONS.items()
    }
    return Mechanism(**parts, effects=Effects({name: values[f"effects.{name}"] for name in EFFECT_QUANTITIES}))


def _sizes() -> float:
    """Return which of the user's values are sizes of effects: bit i for value i."""
    own = PARAMETERS[N_BUILT_IN:]
    sizes = {effect.size.key for effect in CATALOGUE.values()}
    return float(sum(1 << i for i, entry in enumerate(own) if entry.key in sizes))
