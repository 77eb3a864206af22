"""The flat parameter vector: every number of a mechanism, effects included, at a fixed place.

Kernels take the vector; files, fits and reports use the names. To add a parameter, declare it in `mechanism`
(or an effect in `effects`) and write its law in a kernel: the place in the vector follows from the declaration.

Effects that a user adds at run time, see `user_effects`, come last. Behind them the vector then holds what the kernels
need to call their laws: the addresses of those of the section and of the head, and which of the values are sizes.
"""

from collections import namedtuple
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, did_you_mean
from .catalogue import CATALOGUE, Effect
from .mechanism import AXIAL_LAWS, EFFECT_QUANTITIES, SECTIONS, Effects, Mechanism
from .quantity import Quantity

__all__ = ["PARAMETERS", "PLACES", "USER_LAWS", "append", "find", "index", "pack", "remove", "size", "unpack"]

PARAMETERS: list[Quantity] = [
    *(item.metadata["quantity"] for section in SECTIONS.values() for item in fields(section)),
    *EFFECT_QUANTITIES.values(),
]
"""The entries of the vector, in order; those of effects that a user adds come last."""

_PLACE = {entry.key: place for place, entry in enumerate(PARAMETERS)}
_NAMES = [key.replace(".", "_") for key in _PLACE]
PLACES: Any = namedtuple("PLACES", _NAMES)(*range(len(_NAMES)))
"""The place of every built-in entry, a constant for kernels: ``PLACES.beam_EA``, ``PLACES.effects_soft_spot_size``."""

_SHORT: dict[str, list[str]] = {}
for _entry in PARAMETERS:
    _SHORT.setdefault(_entry.name, []).append(_entry.key)


USER_LAWS = {"section": 0, "head": 0}
"""Addresses of what calls the laws of all user effects of the section and of the head; 0 where there are none."""


def append(effect: Effect) -> None:
    """Make the parameters of a user's effect the last entries of the vector."""
    CATALOGUE[effect.name] = effect
    for entry in effect:
        _PLACE[entry.key] = len(PARAMETERS)
        _SHORT.setdefault(entry.name, []).append(entry.key)
        EFFECT_QUANTITIES[entry.name] = entry
        PARAMETERS.append(entry)


def remove(effect: Effect) -> None:
    """Take a user's effect out of the catalogue, and its parameters out of the vector: the others move up."""
    del CATALOGUE[effect.name]
    for entry in effect:
        del _PLACE[entry.key], EFFECT_QUANTITIES[entry.name]
        _SHORT[entry.name].remove(entry.key)
        PARAMETERS.remove(entry)
    _PLACE.update({entry.key: place for place, entry in enumerate(PARAMETERS)})


def size() -> int:
    """Return how many numbers a parameter vector has."""
    return len(PARAMETERS) + (3 if len(PARAMETERS) > len(_NAMES) else 0)


def _sizes() -> float:
    """Return which of the user's values are sizes of effects: bit i for value i."""
    own = PARAMETERS[len(_NAMES) :]
    sizes = {effect.size.key for effect in CATALOGUE.values()}
    return float(sum(1 << i for i, entry in enumerate(own) if entry.key in sizes))


def find(name: str) -> Quantity:
    """Return the entry called `name`, either ``EA`` or, in full, ``beam.EA``.

    A short name that an effect shares with a part of the mechanism is the part's.

    Raises
    ------
    InputError : no such name (with the nearest one), or a short name that two sections share.
    """
    if name in _PLACE:
        return PARAMETERS[_PLACE[name]]
    keys = _SHORT.get(name, [])
    parts = [key for key in keys if not key.startswith("effects.")]
    keys = parts or keys
    if len(keys) == 1:
        return PARAMETERS[_PLACE[keys[0]]]
    if keys:
        raise InputError(f"parameter {name!r} is ambiguous: say {' or '.join(keys)}")
    raise InputError(f"no parameter is called {name!r}{did_you_mean(name, [*_SHORT, *_PLACE])}")


def index(name: str) -> int:
    """Return the place of a parameter in the vector."""
    return _PLACE[find(name).key]


def pack(mechanism: Mechanism) -> NDArray[np.float64]:
    """Return the parameter vector of a mechanism, shape (n_parameters,), see `size`."""
    par = np.array([entry.default for entry in PARAMETERS])
    if size() > len(PARAMETERS):
        par = np.concatenate([par, [float(USER_LAWS["section"]), float(USER_LAWS["head"]), _sizes()]])
    for section in SECTIONS:
        part = getattr(mechanism, section)
        for item in fields(part):
            value: Any = getattr(part, item.name)
            par[_PLACE[f"{section}.{item.name}"]] = AXIAL_LAWS.index(value) if isinstance(value, str) else value
    for name, value in mechanism.effects.items():
        par[_PLACE[f"effects.{name}"]] = value
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
