"""The flat parameter vector: every number of a mechanism, effects included, at a fixed place.

Kernels take the vector; files, fits and reports use the names. To add a parameter, declare it in `sections`
(or an effect in `catalogue`) and write its law in a kernel: the place in the vector follows from the declaration.

Effects that a user adds at run time, see `user_effects`, come last. Behind them the vector then holds a number that
stands for their names, by which the kernels find their laws in this process, and which of the values are sizes; see
`vector.tail`. A saved vector is so recognized where other effects, or none, have been added.
"""

from collections import namedtuple
from dataclasses import fields
from typing import Any

from ..errors import InputError, did_you_mean
from .body import SLOTS, slot_quantities
from .catalogue import CATALOGUE, Effect
from .quantity import Quantity
from .sections import EFFECT_QUANTITIES, SECTIONS

__all__ = [
    "FIRST_MARKER",
    "FIRST_SEGMENT",
    "FIRST_TENDON",
    "N_BUILT_IN",
    "N_TAIL",
    "PARAMETERS",
    "PLACES",
    "append",
    "find",
    "index",
    "remove",
    "size",
]

PARAMETERS: list[Quantity] = [
    *(item.metadata["quantity"] for section in SECTIONS.values() for item in fields(section)),
    *EFFECT_QUANTITIES.values(),
]
"""The entries of the vector: sections, effects, parts of a body; those of effects that a user adds come last."""

_NAMES = [entry.key.replace(".", "_") for entry in PARAMETERS]
PLACES: Any = namedtuple("PLACES", _NAMES)(*range(len(_NAMES)))
"""The place of every section's and effect's entry, a constant for kernels: ``PLACES.beam_EA``."""

PARAMETERS += slot_quantities()
_PLACE = {entry.key: place for place, entry in enumerate(PARAMETERS)}
FIRST_SEGMENT, FIRST_TENDON, FIRST_MARKER = (
    _PLACE[key] for key in ("segment1.length", "tendon1.route", "marker1.place")
)
"""First places of the parts of a body; their own numbers follow each other as in `body.SEGMENT` and its like."""

N_BUILT_IN = len(PARAMETERS)
"""Number of entries without effects that a user adds."""
N_TAIL = 2
"""Numbers behind the values of the effects that a user adds, where there are any."""

_SHORT: dict[str, list[str]] = {}
for _entry in PARAMETERS:
    _SHORT.setdefault(_entry.name, []).append(_entry.key)


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
    return len(PARAMETERS) + (N_TAIL if len(PARAMETERS) > N_BUILT_IN else 0)


def find(name: str) -> Quantity:
    """Return the entry called `name`, either ``EA`` or, in full, ``beam.EA``.

    A short name that an effect shares with a section of the mechanism is the section's; one that all segments have is
    the first one's, which the others take over.

    Raises
    ------
    InputError : no such name (with the nearest one), or a short name that two sections share.
    """
    if name in _PLACE:
        return PARAMETERS[_PLACE[name]]
    keys = min(_by_section(_SHORT.get(name, [])), key=lambda group: group[0], default=(0, []))[1]
    if len(keys) == 1 or (keys and keys[0].startswith("segment")):
        return PARAMETERS[_PLACE[keys[0]]]
    if keys:
        raise InputError(f"parameter {name!r} is ambiguous: say {' or '.join(keys)}")
    raise InputError(f"no parameter is called {name!r}{did_you_mean(name, [*_SHORT, *_PLACE])}")


def _by_section(keys: list[str]) -> list[tuple[int, list[str]]]:
    """Group keys by which are meant first: those of sections, of effects, of parts of a body."""
    groups: dict[int, list[str]] = {}
    for key in keys:
        section = key.split(".")[0]
        groups.setdefault(2 if section in SLOTS else 1 if section == "effects" else 0, []).append(key)
    return list(groups.items())


def index(name: str) -> int:
    """Return the place of a parameter in the vector."""
    return _PLACE[find(name).key]
