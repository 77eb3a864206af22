"""The summary sentence of a diagnosis, and its cautions."""

from collections.abc import Mapping, Sequence

from ...mechanism.catalogue import CATALOGUE
from ...mechanism.parameters import find
from ..problem.candidates import lacking
from ..problem.problem import Problem
from ..results.diagnosis import Detectability, HoldoutMisfit, Remainder, Verdict
from ..results.external_validation import Transfer, carried, not_carried
from ..results.findings import Claim, Model
from ..search.odds import odds
from ..search.result import Selection, implausible, leaves_most

__all__ = [
    "MIRRORS",
    "alike",
    "dimensions",
    "meaning",
    "missing_columns",
    "nearest",
    "next_best",
    "sentence",
    "size",
    "verdict_of",
]

_UNUSUAL = 4.0  # typical sizes beyond which an effect may stand for another one
_FEW_NAMES = 4  # that a sentence can list


def verdict_of(effects: tuple[Claim, ...], *, outside: bool, gap_in_data: bool) -> Verdict:
    """Return the verdict."""
    if outside:
        return "data_gap" if gap_in_data else "outside_catalogue"
    if not effects:
        return "nothing_found"
    return "family" if any(claim.look_alikes for claim in effects) else "named"


def sentence(
    verdict: Verdict,
    effects: tuple[Claim, ...],
    gap: HoldoutMisfit | None,
    sights: tuple[Detectability, ...],
    missing: tuple[str, ...],
    left: Remainder | None,
    tests: tuple[Transfer, ...] = (),
    only: Sequence[str] | None = None,
) -> str:
    """Return the answer in one sentence; what it does not carry over to comes before it, what it does after it.

    only : the names that it may give, where these are not the whole catalogue
    """
    names = [claim.name for claim in effects]
    answer = _answer(verdict, effects, gap, sights, missing, left, only)
    return " ".join((*not_carried(tests, names), answer, *carried(tests, names), *_left_of(effects, tests)))


def _left_of(effects: tuple[Claim, ...], tests: tuple[Transfer, ...]) -> tuple[str, ...]:
    """Return which of a set of look-alikes the test files leave, where they meet its first name and refute others."""
    refuted = {name for test in tests for name, left in test.rivals if left > test.allowed}
    if len(effects) != 1 or not all(test.carries_over for test in tests) or not refuted & set(effects[0].look_alikes):
        return ()
    names = [effects[0].name, *(name for name in effects[0].look_alikes if name not in refuted)]
    return (f"Of the look-alikes {' and '.join(names)} {'are' if names[1:] else 'alone is'} left.",)


def _answer(
    verdict: Verdict,
    effects: tuple[Claim, ...],
    gap: HoldoutMisfit | None,
    sights: tuple[Detectability, ...],
    missing: tuple[str, ...],
    left: Remainder | None,
    only: Sequence[str] | None,
) -> str:
    among = "the catalogue" if only is None else f"those that may be named here ({_listed(only)})"
    if verdict == "nothing_found":
        seen = sum(sight.visible in ("named", "seen") for sight in sights)
        return (f"No missing effect was found: {seen} of {len(sights)} effects of {among} would have shown at "
                f"twice their typical size or less, the others cannot be seen in these data.")  # fmt: skip
    if verdict in ("named", "family"):
        alone = "" if only is None else f" Only {_listed(only)} may be named here: another effect may fit better."
        return f"The data ask for {' and for '.join(_named(claim) for claim in effects)}{_proof(gap)}.{alone}"
    like = f"; it resembles {left.resembles}, which does not explain it" if left else ""
    if verdict == "data_gap":
        return (f"Something is missing that no named effect explains{like}, and columns that could tell are not "
                f"there: {', '.join(missing)}.")  # fmt: skip
    return f"Something is missing that no one or two effects of {among} explain{like}."


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) <= _FEW_NAMES else f"{len(names)} effects"


def _named(claim: Claim) -> str:
    number = size(claim, next(iter(claim.parameters)))
    if claim.times > _UNUSUAL:
        number += f", {claim.times:.0f} times what is typical, so that it may stand for something in no catalogue"
    number += f", {claim.law}" if claim.law else ""
    if not claim.look_alikes:
        return number
    return f"{number}, which these data cannot tell from {' or '.join(claim.look_alikes)}"


def _proof(gap: HoldoutMisfit | None) -> str:
    if gap is None:
        return " (too few rows to set any aside as proof)"
    return (f"; on {gap.rows} rows that were set aside the mechanism as given is off by {gap.given.sigma:.3g} times "
            f"the noise, calibrated alone by {gap.before.sigma:.3g}, with this by {gap.after.sigma:.3g}")  # fmt: skip


def missing_columns(problem: Problem) -> tuple[str, ...]:
    """Return the columns that are needed to tell effects of the catalogue and that no measurement has."""
    found = dict.fromkeys(
        column for candidate in problem.candidates for column in lacking(candidate.effect, problem.data)
    )
    return tuple(found)


def nearest(selection: Selection) -> tuple[str, ...]:
    """Return a line on what comes nearest where nothing explains."""
    fit = selection.closest_fit
    if not selection.outside or fit is None:
        return ()
    values, sizes = fit.by_key(), list[str]()
    for name in selection.names(fit):
        entry = CATALOGUE[name].size
        sizes.append(f"{name} = {values[entry.key]:.3g}{'' if entry.unit == '-' else f' {entry.unit}'}")
    closest = selection.closest or selection.view
    reason = implausible(fit, closest)
    if not reason and leaves_most(closest, selection.baseline):
        reason = "it leaves more than half of the misfit"
    return (f"{' with '.join(sizes)} comes nearest, but {reason or 'the tests still see something beyond it'}",)


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
    others = [_with_size(name, sizes.get(name)) for name in claim.look_alikes]
    return f"{', '.join(others)}; chance of {claim.name} among them {claim.probability:.0%}" if others else ""


def _with_size(name: str, value: float | None) -> str:
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
