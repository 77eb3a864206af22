"""The result of a validation on experiments that were not fitted."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .findings import HoldoutMisfit

__all__ = ["Transfer", "allowed", "carried", "not_carried"]

_CHANCE = 0.01  # of refuting an effect that is right
_LEAST = 1.1  # times the noise that is never held against an effect: a declared noise is not known better


def allowed(readings: int) -> float:
    """Return the root mean square [sigma] of so many readings that noise exceeds once in a hundred, at least 1.1.

    The sum of squares of N readings of Gaussian noise 1 follows chi squared with N degrees of freedom.
    """
    from scipy.special import chdtri

    return max(math.sqrt(float(chdtri(readings, _CHANCE)) / readings), _LEAST)


@dataclass(frozen=True)
class Transfer(HoldoutMisfit):
    """Residuals on an experiment that was never fitted, before and after.

    Attributes
    ----------
    allowed : root mean square [sigma] up to which a model meets the experiment, see `allowed`
    adapted : what is left of `after` where all that was fitted may move within its doubt [sigma]
    left_out : rows that count nowhere here, as outliers
    rivals : the next best explanations of what was fitted, and what they leave here [sigma]
    """

    allowed: float
    adapted: float
    left_out: int = 0
    rivals: tuple[tuple[str, float], ...] = ()

    @property
    def carries_over(self) -> bool:
        """Whether the model with what was found meets the experiment as it stands."""
        return self.after.sigma <= self.allowed

    @property
    def proves(self) -> bool:
        """Whether it does, and the model without it does not."""
        return self.carries_over and self.before.sigma > self.allowed

    def to_json_dict(self) -> dict[str, Any]:
        """Return the entry of ``transfer`` in a diagnosis's JSON."""
        verdicts = {name: getattr(self, name) for name in ("allowed", "adapted", "left_out", "carries_over", "proves")}
        rivals = [{"name": name, "after": left, "carries_over": left <= self.allowed} for name, left in self.rivals]
        return {**super().to_json_dict(), **verdicts, "rivals": rivals}


def not_carried(transfers: Sequence[Transfer], names: Sequence[str]) -> tuple[str, ...]:
    """Return a sentence for every experiment that the model with `names` in it does not meet."""
    return tuple(_missed(entry, names) for entry in transfers if not entry.carries_over)


def _missed(entry: Transfer, names: Sequence[str]) -> str:
    what = " with ".join(names) or "The calibrated model"
    without = f" ({entry.before.sigma:.3g} without it)" if names else ""
    refitted = "EA, GA, EI and its size" if names else "EA, GA and EI"
    moved = f"With {refitted} moved within their doubt {entry.adapted:.3g} are left"
    if entry.adapted <= entry.allowed:
        moved = f"{moved}: they are not known well enough to tell, so this refutes nothing yet"
    rivals = [f"{name} ({left:.3g})" for name, left in entry.rivals]
    meets = [rival for rival, (_, left) in zip(rivals, entry.rivals, strict=True) if left <= entry.allowed]
    others = f" None of the next best would: {', '.join(rivals)}." if rivals else ""
    if meets:
        others = f" Of the next best, {' and '.join(meets)} would."
    return (f"{what} does NOT carry over to {_short(entry)}: {entry.after.sigma:.3g} times the noise is left"
            f"{without}, where about 1 is expected and {entry.allowed:.3g} allowed. {moved}.{others} "
            f"Fit both: give this file as data beside the other.")  # fmt: skip


def carried(transfers: Sequence[Transfer], names: Sequence[str]) -> tuple[str, ...]:
    """Return a sentence for every experiment that the model with `names` in it meets."""
    return tuple(_met(entry, names) for entry in transfers if entry.carries_over)


def _met(entry: Transfer, names: Sequence[str]) -> str:
    after = f"{entry.after.sigma:.3g} times the noise is left in {entry.rows} rows that were never fitted"
    after += f", {entry.left_out} more left out as outliers" if entry.left_out else ""
    if not names:
        return f"The calibrated model carries over to {_short(entry)}: {after}."
    what = " with ".join(names)
    if not entry.proves:
        return (f"{_short(entry)} proves nothing of {what}: without it {entry.before.sigma:.3g} times the noise is "
                f"left there, with it {entry.after.sigma:.3g}.")  # fmt: skip
    return f"{what} carries over to {_short(entry)}: {after} ({entry.before.sigma:.3g} without it).{_others(entry)}"


def _others(entry: Transfer) -> str:
    """Return what becomes there of the next best explanations."""
    meets = [f"{name} ({left:.3g})" for name, left in entry.rivals if left <= entry.allowed]
    misses = [f"{name} ({left:.3g})" for name, left in entry.rivals if left > entry.allowed]
    sentence = (
        f" So {'do' if len(meets) > 1 else 'does'} {' and '.join(meets)}, not refuted by this file." if meets else ""
    )
    return sentence + (f" It refutes {' and '.join(misses)}." if misses else "")


def _short(entry: Transfer) -> str:
    return Path(entry.what).name or entry.what
