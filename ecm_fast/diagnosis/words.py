"""The answer in one plain sentence, and what to know before it is used."""

from .candidates import lacking
from .problem import Problem
from .result import Claim, Gap, Sight, Verdict

__all__ = ["missing_columns", "sentence", "verdict_of"]


def verdict_of(effects: tuple[Claim, ...], *, outside: bool, gap_in_data: bool) -> Verdict:
    """Return the verdict."""
    if outside:
        return "data_gap" if gap_in_data else "outside_catalogue"
    if not effects:
        return "nothing_found"
    return "family" if any(claim.look_alikes for claim in effects) else "named"


def sentence(
    verdict: Verdict, effects: tuple[Claim, ...], gap: Gap | None, sights: tuple[Sight, ...], missing: tuple[str, ...]
) -> str:
    """Return the answer in one sentence."""
    proof = _proof(gap)
    if verdict == "nothing_found":
        seen = sum(sight.visible in ("named", "seen") for sight in sights)
        return (f"No missing effect was found: {seen} of {len(sights)} effects of the catalogue would have shown at "
                f"twice their typical size or less, the others cannot be seen in these data.")  # fmt: skip
    if verdict == "data_gap":
        return (f"Something is missing that no named effect explains{proof}, and columns that could tell are not "
                f"there: {', '.join(missing) or 'more rows'}.")  # fmt: skip
    if verdict == "outside_catalogue":
        near = (
            f"; {' with '.join(claim.name for claim in effects)} comes nearest but does not explain it"
            if effects
            else ""
        )
        return f"Something is missing that no one or two effects of the catalogue explain{near}{proof}."
    parts = [_named(claim) for claim in effects]
    return f"The data ask for {' and for '.join(parts)}{proof}."


def _named(claim: Claim) -> str:
    size, value = next(iter(claim.parameters.items()))
    low, high = claim.interval[size]
    number = f"{size} = {value:.3g} ({low:.3g} to {high:.3g})"
    if not claim.look_alikes:
        return number
    return f"{number}, which these data cannot tell from {' or '.join(claim.look_alikes)}"


def _proof(gap: Gap | None) -> str:
    if gap is None:
        return " (too few rows to set any aside as proof)"
    return (f"; on {gap.rows} locked rows the gap goes from {gap.before.sigma:.3g} to {gap.after.sigma:.3g} times "
            f"the noise")  # fmt: skip


def missing_columns(problem: Problem) -> tuple[str, ...]:
    """Return the columns that are needed to tell effects of the catalogue and that no measurement has."""
    found = dict.fromkeys(
        column for candidate in problem.candidates for column in lacking(candidate.effect, problem.data)
    )
    return tuple(found)
