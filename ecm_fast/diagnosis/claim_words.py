"""A claim in words: its size with unit and meaning, its mirror class, and how far the next explanation is behind."""

import math
from collections.abc import Sequence

from ..effects import CATALOGUE
from ..parameters import find
from .parts import Claim, Model

__all__ = ["MIRRORS", "meaning", "next_best", "size"]

MIRRORS = {
    "even": "even (same on both sides)",
    "odd": "odd (differs left and right)",
    "mixed": "mixed (partly the same on both sides)",
    "path": "history (depends on what came before)",
}
"""Mirror classes in words."""

_CERTAIN = 1e4
"""Odds beyond which their number says nothing more."""


def size(claim: Claim, name: str) -> str:
    """Return one parameter of a claim with unit and interval."""
    low, high = claim.interval[name]
    unit = find(name).unit
    return f"{name} = {claim.parameters[name]:.3g}{'' if unit == '-' else f' {unit}'} (90 %: {low:.3g} to {high:.3g})"


def meaning(claim: Claim) -> str:
    """Return what an effect is, as the catalogue has it."""
    return CATALOGUE[claim.name].size.meaning


def next_best(models: Sequence[Model], names: Sequence[str]) -> str:
    """Return the best explanation that is none of a look-alike set, with its odds; empty where no other was fitted.

    The odds are those of the evidence: explanations are equally likely before the data speak.
    """
    others = [model for model in models if len(model.names) == len(names) and not model.in_set]
    rest = [model for model in others if not model.refused]
    if not names or not others:
        return ""
    if not rest:
        return "next best: none of the others that were fitted can be meant"
    best = min(rest, key=lambda model: model.behind)
    odds = math.exp(min(0.5 * best.behind, math.log(_CERTAIN)))
    number = f"more than {_CERTAIN:.0f}" if odds >= 0.999 * _CERTAIN else f"{odds:.0f}"
    return f"next best: {' with '.join(best.names)}, 1 : {number}"
