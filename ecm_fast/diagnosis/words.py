"""The answer in one plain sentence, and what to know before it is used."""

from .candidates import lacking
from .claim_words import size
from .problem import Problem
from .result import Claim, Gap, Remainder, Sight, Verdict
from .search import Found
from .transfer_result import Transfer, carried, not_carried

__all__ = ["missing_columns", "nearest", "sentence", "verdict_of"]


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
    gap: Gap | None,
    sights: tuple[Sight, ...],
    missing: tuple[str, ...],
    left: Remainder | None,
    tests: tuple[Transfer, ...] = (),
) -> str:
    """Return the answer in one sentence; what it does not carry over to comes before it, what it does after it."""
    names = [claim.name for claim in effects]
    answer = _answer(verdict, effects, gap, sights, missing, left)
    return " ".join((*not_carried(tests, names), answer, *carried(tests, names)))


def _answer(
    verdict: Verdict,
    effects: tuple[Claim, ...],
    gap: Gap | None,
    sights: tuple[Sight, ...],
    missing: tuple[str, ...],
    left: Remainder | None,
) -> str:
    if verdict == "nothing_found":
        seen = sum(sight.visible in ("named", "seen") for sight in sights)
        return (f"No missing effect was found: {seen} of {len(sights)} effects of the catalogue would have shown at "
                f"twice their typical size or less, the others cannot be seen in these data.")  # fmt: skip
    if verdict in ("named", "family"):
        return f"The data ask for {' and for '.join(_named(claim) for claim in effects)}{_proof(gap)}."
    like = f"; it resembles {left.resembles}, which does not explain it" if left else ""
    if verdict == "data_gap":
        return (f"Something is missing that no named effect explains{like}, and columns that could tell are not "
                f"there: {', '.join(missing)}.")  # fmt: skip
    return f"Something is missing that no one or two effects of the catalogue explain{like}."


def _named(claim: Claim) -> str:
    number = size(claim, next(iter(claim.parameters)))
    if not claim.look_alikes:
        return number
    return f"{number}, which these data cannot tell from {' or '.join(claim.look_alikes)}"


def _proof(gap: Gap | None) -> str:
    if gap is None:
        return " (too few rows to set any aside as proof)"
    return (f"; on {gap.rows} rows that were set aside the gap goes from {gap.before.sigma:.3g} to "
            f"{gap.after.sigma:.3g} times the noise")  # fmt: skip


def missing_columns(problem: Problem) -> tuple[str, ...]:
    """Return the columns that are needed to tell effects of the catalogue and that no measurement has."""
    found = dict.fromkeys(
        column for candidate in problem.candidates for column in lacking(candidate.effect, problem.data)
    )
    return tuple(found)


def nearest(found: Found) -> tuple[str, ...]:
    """Return a line on what comes nearest where nothing explains."""
    if not found.outside or not found.nearest:
        return ()
    return (f"{' with '.join(found.nearest)} comes nearest, but the tests still see something beyond it",)
