"""A claim in words: its size with unit and meaning, its mirror class, and how far the next explanation is behind."""

from collections.abc import Mapping, Sequence

from ...mechanism.catalogue import CATALOGUE
from ...mechanism.parameters import find
from ..results.findings import Claim, Model
from ..search.odds import odds

__all__ = ["MIRRORS", "alike", "dimensions", "meaning", "next_best", "size"]

MIRRORS = {
    "even": "even (same on both sides)",
    "odd": "odd (differs left and right)",
    "mixed": "mixed (partly the same on both sides)",
    "path": "history (depends on what came before)",
}
"""Mirror classes in words."""


def size(claim: Claim, name: str) -> str:
    """Return one parameter of a claim with unit and interval."""
    low, high = claim.interval[name]
    return f"{name} = {_in_unit(claim.parameters[name], find(name).unit)} (90 %: {low:.3g} to {high:.3g})"


def meaning(claim: Claim) -> str:
    """Return what an effect is, as the catalogue has it for a size above zero."""
    entry = CATALOGUE[claim.name].size
    return entry.meaning + ("; below zero: the other way round" if claim.parameters[entry.name] < 0.0 else "")


def alike(models: Sequence[Model], names: Sequence[str], claim: Claim) -> str:
    """Return the look-alikes of a claim with the sizes that they would have, and its own chance; empty for none.

    models, names : all explanations, and what the best of them names
    """
    sizes = dict[str, float]()
    given = [model for model in models if model.in_set and len(model.names) == len(names)]
    for model in sorted(given, key=lambda model: model.behind):
        for name, value in zip(model.names, model.sizes, strict=True):
            sizes.setdefault(name, value)
    others = [_named(name, sizes.get(name)) for name in claim.look_alikes]
    return f"{', '.join(others)}; chance of {claim.name} among them {claim.probability:.0%}" if others else ""


def _named(name: str, value: float | None) -> str:
    return name if value is None else f"{name} ({_in_unit(value, CATALOGUE[name].size.unit)})"


def _in_unit(value: float, unit: str) -> str:
    return f"{value:.3g}" if unit == "-" else f"{value:.3g} {unit}"


def dimensions(fitted: Mapping[str, float], given: Mapping[str, float]) -> str:
    """Return what the fit made of dimensions that are known within a tolerance; empty where there are none.

    fitted, given : by name, in the mechanism that was found and in the one that was given
    """
    if not fitted:
        return ""
    moves = {find(name): value - given.get(name, 0.0) for name, value in fitted.items()}
    far = [f"; {entry.name} moves by {_in_unit(move, entry.unit)}, its tolerance is {entry.tolerance:g}"
           for entry, move in moves.items() if abs(move) > entry.tolerance]  # fmt: skip
    within = f"dimensions within their tolerances: {len(moves) - len(far)} of {len(moves)}"
    return f"{within}; the mechanism file has them as fitted{''.join(far)}"


def next_best(models: Sequence[Model], names: Sequence[str]) -> str:
    """Return the best explanation that is none of a look-alike set, with its odds; empty where no other was fitted."""
    others = [model for model in models if len(model.names) == len(names) and not model.in_set]
    rest = [model for model in others if not model.refused]
    if not names or not others:
        return ""
    if not rest:
        return "next best: none of the others that were fitted can be meant"
    best = min(rest, key=lambda model: model.behind)
    return f"next best: {' with '.join(best.names)}, {odds(best.behind)} times less likely"
