"""A mechanism as the flat parameter vector, and back."""

import hashlib
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .body import KINDS, SLOTS
from .catalogue import CATALOGUE
from .mechanism import PARTS, Effects, Mechanism
from .parameters import N_BUILT_IN, PARAMETERS, index, size
from .sections import CHOICES, EFFECT_QUANTITIES, SECTIONS

__all__ = ["check_tail", "pack", "tail", "unpack"]


def pack(mechanism: Mechanism) -> NDArray[np.float64]:
    """Return the parameter vector of a mechanism, shape (n_parameters,), see `size`."""
    par = np.concatenate([[entry.default for entry in PARAMETERS], tail()])
    for key, value in mechanism.values().items():
        par[index(key)] = CHOICES[key].index(value) if isinstance(value, str) else value
    return par


def unpack(par: NDArray[np.float64], like: Mechanism | None = None) -> Mechanism:
    """Return the mechanism of a parameter vector; the inverse of `pack`, without loss.

    like : a mechanism with the same parts, whose tendons and markers have the same names; without it they are called
        ``tendon1``, ``marker1`` and so on

    Raises
    ------
    InputError : wrong length, a value out of its bounds, or a number that stands for no word.
    """
    vector = np.asarray(par, dtype=np.float64)
    if vector.shape != (size(),):
        raise InputError(f"a parameter vector has shape ({size()},), not {vector.shape}")
    check_tail(vector[None])
    values: dict[str, Any] = {entry.key: float(vector[place]) for place, entry in enumerate(PARAMETERS)}
    for key, words in CHOICES.items():
        if values[key] not in range(len(words)):
            allowed = " or ".join(f"{number} ({word or 'absent'})" for number, word in enumerate(words))
            raise InputError(f"{key} = {values[key]!r}: allowed is {allowed}")
        values[key] = words[int(values[key])]
    parts: dict[str, Any] = {
        name: section(**{item.name: values[f"{name}.{item.name}"] for item in fields(section)})
        for name, section in SECTIONS.items()
    }
    effects = Effects({name: values[f"effects.{name}"] for name in EFFECT_QUANTITIES})
    return Mechanism(**parts, effects=effects, **_parts(values, like))


def _parts(values: dict[str, Any], like: Mechanism | None) -> dict[str, Any]:
    """Return the parts of a body: those that are there have a length, a route or a place."""
    known: dict[str, list[Any]] = {name: [] for name in PARTS.values()}
    for slot, (kind, number) in SLOTS.items():
        cls = KINDS[kind]
        given = {item.name: values[f"{slot}.{item.name}"] for item in fields(cls) if item.name != "name"}
        present = given["length"] if kind == "segment" else given["route"] if kind == "tendon" else (
            given["place"] or given["on_head"])  # fmt: skip
        if present:
            named = getattr(like, PARTS[kind]) if like is not None else ()
            name = {} if kind == "segment" else {"name": named[number].name if number < len(named) else slot}
            known[PARTS[kind]].append(cls(**given, **name))
    return {field: tuple(parts) for field, parts in known.items()}


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
