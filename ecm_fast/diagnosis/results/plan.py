"""The result of a plan: detectability of every effect before measuring."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...files import plain
from .diagnosis import Detectability

__all__ = ["Plan"]


@dataclass(frozen=True, eq=False, repr=False)
class Plan:
    """Detectability of the catalogue under a list of loads.

    Attributes
    ----------
    rows : how many loads
    sights : every entry of the catalogue
    names : of the candidates, in the order of `cosines`
    cosines : (k, k) between signatures, calibrated parameters projected out; 0 where one is invisible
    distances : (k, k) sigmas between a typical size of the first and any size of the second
    noise : in words, what was assumed
    missing : columns without which effects cannot be distinguished
    warnings : loads that have no stable equilibrium, and the like
    """

    rows: int
    sights: tuple[Detectability, ...]
    names: tuple[str, ...]
    cosines: NDArray[np.float64]
    distances: NDArray[np.float64]
    noise: str
    missing: tuple[str, ...]
    warnings: tuple[str, ...]

    def effects_that_are(self, visible: str) -> tuple[str, ...]:
        """Return the names that are ``named``, ``seen``, ``absorbed`` or ``invisible``."""
        return tuple(sight.name for sight in self.sights if sight.visible == visible)

    def to_json_dict(self) -> dict[str, Any]:
        """Return the plan as JSON has it; what is not finite is None."""
        answer = {
            "rows": self.rows,
            "named": self.effects_that_are("named"),
            "seen": self.effects_that_are("seen"),
            "absorbed": self.effects_that_are("absorbed"),
            "invisible": self.effects_that_are("invisible"),
            "sights": [sight.to_json_dict() for sight in self.sights],
            "names": self.names,
            "cosines": self.cosines,
            "noise": self.noise,
            "missing": self.missing,
            "warnings": self.warnings,
        }
        return {name: plain(value) for name, value in answer.items()}

    def _lines(self) -> Iterator[str]:
        yield f"<Plan of {self.rows} rows; {self.noise}"
        for visible in ("named", "seen", "absorbed", "invisible"):
            names = self.effects_that_are(visible)
            yield f"  {visible} ({len(names)}): {', '.join(names) or 'none'}"

    def __repr__(self) -> str:
        return "\n".join([*self._lines(), *(f"  warning: {text}" for text in self.warnings)]) + ">"
