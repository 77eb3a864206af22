"""Candidate effects: entries of the catalogue that the measurements and the mechanism allow."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from ...data.columns import COLUMNS
from ...data.measurements import Measurements
from ...errors import InputError, did_you_mean
from ...mechanism.catalogue import CATALOGUE, Effect
from ...mechanism.derived import limits
from ...mechanism.mechanism import Mechanism
from ...mechanism.parameters import find, index
from ...mechanism.vector import pack
from ..statistics.priors import SIZE_SPREAD

__all__ = ["GROUPS", "EffectCandidate", "chosen", "lacking", "uncertain_parameters"]

GROUPS = {"camera_frame": ("camera_x_offset", "camera_z_offset", "camera_rotation")}
"""Names under which several parameters are declared uncertain together."""


@dataclass(frozen=True)
class EffectCandidate:
    """One effect on top of a mechanism.

    Attributes
    ----------
    effect : its entry in the catalogue
    keys : of its parameters in the vector, the size first
    start : their values in the mechanism
    spread : standard deviations of the priors that fits work with
    lower, upper : bounds
    """

    effect: Effect
    keys: tuple[str, ...]
    start: tuple[float, ...]
    spread: tuple[float, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]

    @property
    def name(self) -> str:
        """As in the catalogue."""
        return self.effect.name

    @property
    def typical(self) -> float:
        """The size that one expects."""
        return self.effect.size.typical

    @property
    def one_sided(self) -> bool:
        """Whether it can only grow from where it is."""
        return self.lower[0] >= self.start[0]

    @classmethod
    def from_effect(cls, effect: Effect, mechanism: Mechanism) -> "EffectCandidate":
        """Return an effect as a candidate on a mechanism."""
        par, entries = pack(mechanism), tuple(effect)
        lower, upper = zip(*(limits(entry.key, par) for entry in entries), strict=True)
        return cls(
            effect,
            tuple(entry.key for entry in entries),
            tuple(float(par[index(entry.key)]) for entry in entries),
            (SIZE_SPREAD * entries[0].typical, *(entry.typical for entry in entries[1:])),
            lower,
            upper,
        )


def chosen(names: Iterable[str] | None, mechanism: Mechanism) -> list[EffectCandidate]:
    """Return the candidates called `names`, default the whole catalogue, in its order.

    Raises
    ------
    InputError : the catalogue has no such name, or none is given.
    """
    wanted = list(CATALOGUE if names is None else names)
    if names is not None and not wanted:
        raise InputError("0 candidates: give at least one effect, or leave them out for the whole catalogue")
    for name in wanted:
        if name not in CATALOGUE:
            raise InputError(f"candidate {name!r}: no such effect{did_you_mean(str(name), CATALOGUE)}")
    return [EffectCandidate.from_effect(CATALOGUE[name], mechanism) for name in CATALOGUE if name in set(wanted)]


def lacking(effect: Effect, data: Iterable[Measurements]) -> tuple[str, ...]:
    """Return the columns that an effect needs and no measurement has."""
    fields = {name: entry.name for entry in COLUMNS.values() for name in entry.names}
    return tuple(
        column
        for column in effect.needs
        if not any(np.isfinite(getattr(part, fields[column])).any() for part in data if fields[column] in vars(part))
    )


def uncertain_parameters(given: Mapping[str, float | None]) -> dict[str, float]:
    """Return standard deviations by parameter, inf where it is free, of what a user declares uncertain.

    Names are parameters, effects or groups of them.

    Raises
    ------
    InputError : no such name, or a standard deviation that is none.
    """
    found: dict[str, float] = {}
    for name, std in given.items():
        if std is not None and not 0.0 < std <= np.inf:
            raise InputError(f"uncertain {name} = {std!r}: allowed is a number > 0, or none for a free one")
        for one in GROUPS.get(name, (name,)):
            key = CATALOGUE[one].size.key if one in CATALOGUE else find(one).key
            found[key] = np.inf if std is None else float(std)
    return found
