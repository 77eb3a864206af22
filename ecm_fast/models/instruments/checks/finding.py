"""The record of one finding about measurements."""

from dataclasses import dataclass

from ....data.measurements import Measurements

__all__ = ["Finding", "places"]

_SHOWN = 8  # row numbers that fit one line


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong with data, or that they cannot tell.

    Attributes
    ----------
    kind : one word or two, such as ``unit``, ``swapped``, ``outliers``, ``one-sided``
    rows : which records, as a user finds them; empty for all of them
    sentence : what was seen, with its number
    cure : what to do about it
    certain : the data cannot be used before it is cured
    """

    kind: str
    rows: tuple[int, ...]
    sentence: str
    cure: str
    certain: bool = False

    def __str__(self) -> str:
        return f"{self.sentence}; {self.cure}" if self.cure else self.sentence

    def __repr__(self) -> str:
        return f"<Finding {self.kind}{' (certain)' if self.certain else ''}: {self}>"


def places(data: Measurements, rows: tuple[int, ...]) -> str:
    """Return the places of some records in words: ``lines 7, 9 and 12 more``."""
    some = ", ".join(map(str, rows[:_SHOWN]))
    rest = f" and {len(rows) - _SHOWN} more" if len(rows) > _SHOWN else ""
    return f"{data.counted}{'s' if len(rows) > 1 else ''} {some}{rest}"
