"""Derived quantities with bounds: lengths, masses, radii, stiffnesses and gains that parameters make together.

Each parameter has bounds of its own, but an effect adds to a part of the mechanism: the sum must stay physical. The
kernels refuse the same mechanisms, see `kernels.prepare`.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import InputError
from .parameters import find, index

__all__ = ["DERIVED", "Derived", "check_derived", "limits"]

Values = Callable[[str], float]
"""The values of a mechanism's parameters by their keys."""

# a fit stays this far inside a limit that itself is not allowed
MARGIN = 1e-6
# what rounding leaves of a sum that is 0
ROUNDING = 1e-12


@dataclass(frozen=True)
class Derived:
    """A number that is linear in each of several parameters.

    Attributes
    ----------
    formula : in the names of the parameters
    unit : SI unit, ``-`` when it has none
    constant : what it is without the terms
    terms : factor of each parameter, by its key; a number, or a function of the values of all
    positive : whether it must be above 0; else 0 is allowed too
    """

    formula: str
    unit: str
    constant: float
    terms: Mapping[str, float | Callable[[Values], float]]
    positive: bool

    def factor(self, key: str, at: Values) -> float:
        """Return by how much the number grows with a parameter."""
        term = self.terms[key]
        return term(at) if callable(term) else term

    def value(self, at: Values) -> float:
        """Return the number for the values of a mechanism."""
        return self.constant + sum(self.factor(key, at) * at(key) for key in self.terms)

    def holds(self, at: Values) -> bool:
        """Whether the number is possible."""
        value = self.value(at)
        return value > 0.0 if self.positive else value >= -ROUNDING


def _at_both_ends(at: Values) -> float:
    length = at("beam.length") + at("effects.beam_length")
    return 1.0 + math.exp(-length / at("effects.bonded_ends.decay"))


def _sum(part: str, effect: str, unit: str, *, positive: bool = False) -> Derived:
    return Derived(f"{part} + {effect}", unit, 0.0, {part: 1.0, effect: 1.0}, positive)


def _side(part: str, effect: str, constant: float, unit: str, sign: float, *, positive: bool = False) -> Derived:
    """Return what one of two tendons has of something: the left one with the sign +1, the right one with -1."""
    terms = {**({part: 1.0} if part else {}), effect: 1.0, f"{effect}_asymmetry": 0.5 * sign}
    shown = f"{part or f'{constant:g}'} + {effect} {'+' if sign > 0.0 else '-'} {effect}_asymmetry/2"
    return Derived(shown, unit, constant, terms, positive)


DERIVED = (
    _sum("beam.length", "effects.beam_length", "m", positive=True),
    _sum("beam.mass_per_length", "effects.beam_mass", "kg/m"),
    _sum("head.mass", "effects.head_mass", "kg"),
    _sum("tendons.pulley_radius", "effects.pulley_radius", "m"),
    *(_side("", "effects.force_gain", 1.0, "-", sign, positive=True) for sign in (1.0, -1.0)),
    Derived(
        "1 + effects.bonded_ends.size (1 + exp(-length/effects.bonded_ends.decay))",
        "-",
        1.0,
        {"effects.bonded_ends.size": _at_both_ends},
        True,
    ),
)


def check_derived(values: Mapping[str, Any]) -> None:
    """Refuse a mechanism whose effects take a length, mass, radius, stiffness or gain out of what is possible.

    Parameters
    ----------
    values : by key; what is not there has its default

    Raises
    ------
    InputError : names what is impossible, its value and what is allowed.
    """

    def at(key: str) -> float:
        return float(values.get(key, find(key).default))

    for entry in DERIVED:
        if not entry.holds(at):
            unit = "" if entry.unit == "-" else f" {entry.unit}"
            allowed = "a number above 0" if entry.positive else "0 or more"
            raise InputError(f"{entry.formula} = {entry.value(at):g}{unit}: allowed is {allowed}")


def limits(key: str, par: Any) -> tuple[float, float]:
    """Return the least and the largest value that a parameter may have while all others stay as in a vector.

    Parameters
    ----------
    key : name of the parameter
    par : (n_parameters,)
    """
    entry = find(key)
    lower, upper = entry.lower, entry.upper

    def at(other: str) -> float:
        return float(par[index(other)])

    for number in DERIVED:
        if entry.key not in number.terms:
            continue
        factor = number.factor(entry.key, at)
        edge = at(entry.key) - (number.value(at) - MARGIN * number.positive) / factor
        lower, upper = (max(lower, edge), upper) if factor > 0.0 else (lower, min(upper, edge))
    return lower, upper
