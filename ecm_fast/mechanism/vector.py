"""A mechanism as the flat parameter vector, and back."""

import hashlib
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .catalogue import CATALOGUE
from .mechanism import Effects, Mechanism
from .parameters import N_BUILT_IN, PARAMETERS, index, size
from .sections import AXIAL_LAWS, EFFECT_QUANTITIES, SECTIONS

__all__ = ["check_tail", "pack", "tail", "unpack"]


def pack(mechanism: Mechanism) -> NDArray[np.float64]:
    """Return the parameter vector of a mechanism, shape (n_parameters,), see `size`."""
    par = np.concatenate([[entry.default for entry in PARAMETERS], tail()])
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
    check_tail(vector[None])
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


def tail() -> NDArray[np.float64]:
    """Return what stands behind the values of a user's effects, (N_TAIL,), or (0,) where none was added.

    A digest of the names of their parameters, and which of these are sizes of effects: bit i for value i.
    """
    names = [entry.name for entry in PARAMETERS[N_BUILT_IN:]]
    if not names:
        return np.empty(0)
    sizes = {effect.size.name for effect in CATALOGUE.values()}
    digest = hashlib.sha256(" ".join(names).encode()).digest()[:6]  # 48 bits, which a float64 holds exactly
    bits = sum(1 << i for i, name in enumerate(names) if name in sizes)
    return np.array([float(int.from_bytes(digest, "big")), float(bits)])


def check_tail(rows: NDArray[np.float64]) -> None:
    """Raise where parameter vectors, (n, n_parameters), were made with other effects of the user's own than these."""
    if rows.shape[1] != size() or not (rows[:, len(PARAMETERS) :] == tail()).all():
        known = ", ".join(entry.name for entry in PARAMETERS[N_BUILT_IN:])
        raise InputError(f"the parameter vector was made where other effects of the user's own were added than here "
                         f"({known}): add the same ones in the same order first")  # fmt: skip
