"""The score of an answer about sealed measurements."""

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from ...errors import InputError, why
from ...files import read_whole
from .ground_truth import Truth

__all__ = ["Score", "score"]

VERDICTS = {
    "clean": ("nothing_found",),
    "effect": ("named", "family"),
    "pair": ("named", "family"),
    "outside": ("outside_catalogue",),
}
"""The right verdicts on each kind of truth; a ``data_gap`` is never wrong, and never right."""


@dataclass(frozen=True)
class Score:
    """An answer beside the truth; None where a question does not apply.

    Attributes
    ----------
    kind : of the truth, see `Truth.kind`
    hidden : the effects that were hidden
    verdict, named : what the answer says
    verdict_right : whether the verdict is one of those that are right for this kind of truth
    top : whether the first names, as many as are hidden, are the hidden ones
    in_set : whether every hidden effect is among the names reported or their look-alikes
    set_size : how many names a reported effect may be, the mean over those reported
    alone, alone_right : whether a name is printed without look-alikes, and whether each such name is hidden
    extra : whether more effects are reported than are hidden
    size_error : by the name of a parameter, (found - true)/true
    covered : by the name of a parameter, whether its interval holds the truth
    gap_closed : share of the excess mean square over the floor that is gone on the locked rows, where the mechanism
        without any effect is calibrated, too
    gap_closed_since_given : the same of the mechanism as it was given
    """

    kind: str
    hidden: tuple[str, ...]
    verdict: str
    named: tuple[str, ...]
    verdict_right: bool
    top: bool | None
    in_set: bool | None
    set_size: float | None
    alone: bool
    alone_right: bool | None
    extra: bool
    size_error: Mapping[str, float]
    covered: Mapping[str, bool]
    gap_closed: float | None
    gap_closed_since_given: float | None

    @property
    def false_alarm(self) -> bool:
        """Whether something is reported where nothing was hidden."""
        return self.kind == "clean" and (bool(self.named) or self.verdict in ("named", "family", "outside_catalogue"))

    def to_json_dict(self) -> dict[str, Any]:
        """Return all of it as JSON can hold it."""
        return {**asdict(self), "false_alarm": self.false_alarm}

    def __repr__(self) -> str:
        words = {True: "right", False: "WRONG", None: "not asked"}
        names = ", ".join(self.named) or "no name"
        size = ", ".join(f"{name} off by {error:+.1%}" for name, error in self.size_error.items())
        gap = "" if self.gap_closed is None else f"; gap closed {self.gap_closed:.1%}"
        return (
            f"<Score of {self.verdict} ({names}) on {', '.join(self.hidden) or self.kind}: verdict "
            f"{words[self.verdict_right]}, top names {words[self.top]}, set {words[self.in_set]}{gap}"
            f"{'; ' if size else ''}{size}>"
        )


def score(result: Any, truth: Truth | str | os.PathLike[str]) -> Score:
    """Grade an answer.

    Parameters
    ----------
    result : what `diagnose` returned, its JSON as a mapping, or the path of a file that holds it
    truth : what `hide` kept back, or the path of its file

    Raises
    ------
    InputError : a file cannot be read, or is no answer; names it and why.
    """
    known = truth if isinstance(truth, Truth) else Truth.from_json(truth)
    answer, source = _answer(result)
    try:
        return _graded(answer, known)
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise InputError(f"{source}: no answer of diagnose ({type(error).__name__}: {why(error)})") from None


def _answer(result: Any) -> tuple[Mapping[str, Any], str]:
    """Return an answer as a mapping, and where it comes from."""
    if hasattr(result, "to_json_dict"):
        return result.to_json_dict(), "result"
    if isinstance(result, Mapping):
        return result, "result"
    try:
        found: Any = json.loads(read_whole(result))
    except (OSError, ValueError, TypeError, RecursionError) as error:
        raise InputError(f"{result}: cannot be read as an answer ({why(error)})") from None
    return found, str(result)


def _graded(answer: Mapping[str, Any], truth: Truth) -> Score:
    effects = list(answer["effects"])
    names = tuple(str(effect["name"]) for effect in effects)
    sets = [{name, *effect.get("look_alikes", ())} for name, effect in zip(names, effects, strict=True)]
    hidden, excused = truth.names, {name.partition(".")[0] for name in truth.tolerance}
    asked = truth.kind in ("effect", "pair")
    alone = [name for name, those in zip(names, sets, strict=True) if len(those) == 1]
    reported = {name for those in sets for name in those}
    unexcused = [name for name in names if name not in excused]
    return Score(
        kind=truth.kind,
        hidden=(*hidden, *truth.outside),
        verdict=str(answer["verdict"]),
        named=names,
        verdict_right=answer["verdict"] in VERDICTS[truth.kind],
        top=set(names[: len(hidden)]) == set(hidden) if asked else None,
        in_set=set(hidden) <= reported if asked else None,
        set_size=sum(map(len, sets)) / len(sets) if sets else None,
        alone=bool(alone),
        alone_right=all(name in hidden or name in excused for name in alone) if alone else None,
        extra=len(unexcused) > len(hidden),
        size_error=_size_errors(effects, truth),
        covered=_covered(effects, truth),
        gap_closed=_gap_closed(answer.get("gap") or {}, "before"),
        gap_closed_since_given=_gap_closed(answer.get("gap") or {}, "given"),
    )


def _size_errors(effects: list[Mapping[str, Any]], truth: Truth) -> dict[str, float]:
    found = {name: value for effect in effects for name, value in effect["parameters"].items()}
    return {
        name: (found[name] - true) / true
        for name, true in truth.effects.items()
        if found.get(name) is not None and true != 0.0
    }


def _covered(effects: list[Mapping[str, Any]], truth: Truth) -> dict[str, bool]:
    known = {name: ends for effect in effects for name, ends in (effect.get("interval") or {}).items()}
    whole = {name: ends for name, ends in known.items() if ends is not None and None not in ends}
    return {
        name: bool(whole[name][0] <= true <= whole[name][1]) for name, true in truth.effects.items() if name in whole
    }


def _gap_closed(gap: Mapping[str, Any], since: str) -> float | None:
    """1 - (after^2 - floor^2)/(since^2 - floor^2) of the rms in sigmas, None where there was no gap."""
    known = [(gap.get(name) or {}).get("rms_sigma") for name in (since, "after", "floor")]
    squares = [float(value) ** 2 for value in known if value is not None]
    if len(squares) < len(known):
        return None
    before, after, floor = squares
    return 1.0 - max(after - floor, 0.0) / (before - floor) if before > floor else None
