"""The result of a search for the next loads, with their expected gain."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["ENOUGH", "NextLoads", "Suggestion"]

Array = NDArray[np.float64]

ENOUGH = 8.0
"""Sigmas from which on two explanations count as distinguished."""


@dataclass(frozen=True)
class Suggestion:
    """One load to apply next.

    Attributes
    ----------
    loads : by column of a measurement file
    mount : what has to be mounted for it
    repeats : how often to read it
    minutes : it costs
    promised_sigma : smallest distance in the set once this load and those before it are measured
    split : the two explanations that are closest then
    """

    loads: dict[str, float]
    mount: str
    repeats: int
    minutes: float
    promised_sigma: float
    split: tuple[str, str]

    def to_json_dict(self) -> dict[str, Any]:
        """Return the entry of ``next`` in JSON."""
        return {**vars(self), "split": list(self.split)}

    def __repr__(self) -> str:
        loads = ", ".join(f"{name} {value:g}" for name, value in self.loads.items())
        mount = "" if self.mount == "nothing" else f" ({self.mount})"
        return f"{self.repeats} x {loads}{mount}: {self.minutes:.1f} min, then {self.promised_sigma:.1f} sigma"


@dataclass(frozen=True, eq=False, repr=False)
class NextLoads:
    """Loads to measure next.

    Attributes
    ----------
    names : of the explanations
    before, after : (m, m) sigmas by which the second one, fitted, misses the first one; 0 on the diagonal, inf
        where a pair was not asked for
    suggestions : in the order of measurement
    alone : by add-on, the distance that its best load buys alone
    twins : pairs that no load of the pool tells apart in the time there is; distances in the set leave them out
    notes : what the promise does not hold for
    """

    names: tuple[str, ...]
    before: Array
    after: Array
    suggestions: tuple[Suggestion, ...]
    alone: dict[str, float]
    twins: tuple[tuple[str, str], ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def minutes(self) -> float:
        """Time that all of it takes."""
        return sum(entry.minutes for entry in self.suggestions)

    @property
    def worst_before(self) -> float:
        """Smallest distance in the set now."""
        return self._worst(self.before)

    @property
    def worst_after(self) -> float:
        """Smallest distance in the set once everything is measured."""
        return self._worst(self.after)

    def _worst(self, distances: Array) -> float:
        left_out = np.eye(len(self.names), dtype=bool) | np.isinf(distances)
        for one, other in self.twins:
            i, j = self.names.index(one), self.names.index(other)
            left_out[[i, j], [j, i]] = True
        return 0.0 if left_out.all() else float(distances[~left_out].min())

    @property
    def why_none(self) -> str:
        """The reason that no load is suggested, where none is."""
        if self.worst_before >= ENOUGH:
            return f"these are told apart already: {ENOUGH:g} sigma are enough"
        return "no load that fits into the time tells them apart"

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks, in sentences: twins first."""
        twins = [f"no load here tells {one} from {other} in this time" for one, other in self.twins]
        return (*twins, *self.notes)

    def to_json_dict(self) -> dict[str, Any]:
        """Return the answer as JSON has it."""
        return {
            "set": list(self.names),
            "sigma_before": self.worst_before,
            "sigma_after": self.worst_after,
            "minutes": self.minutes,
            "next": [entry.to_json_dict() for entry in self.suggestions],
            "alone": self.alone,
            "twins": [list(pair) for pair in self.twins],
            "notes": list(self.notes),
        }

    def _lines(self) -> Iterator[str]:
        yield f"<NextLoads to tell apart {'; '.join(self.names)}: {self.worst_before:.1f} sigma now"
        yield from (f"  {entry!r}" for entry in self.suggestions)
        if not self.suggestions:
            yield f"  {self.why_none}"
        yield from (f"  {text}" for text in self.remarks)

    def __repr__(self) -> str:
        return "\n".join(self._lines()) + ">"
