"""One parameter of the mechanism: name, unit, meaning, bounds and source."""

import math
from dataclasses import dataclass
from numbers import Real
from typing import Literal

from ..errors import InputError, shown

__all__ = ["Quantity", "Status"]

Status = Literal["stated", "derived", "found", "assumed", "zero"]
"""Source of a default: stated by the paper, derived from what it states, found elsewhere, assumed by us.

``zero`` marks an effect's size (absent unless asked for)."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """One entry of the parameter vector.

    Attributes
    ----------
    key : dotted name, the section and the name in a mechanism file, e.g. ``beam.EA``
    unit : SI unit in plain ASCII, ``-`` when it has none
    meaning : one line
    default : value where none is given
    lower, upper : closed bounds; outside them a value is refused
    typical : the size one expects (a prior's scale), in the same unit
    status : where the default comes from
    source : the sentence behind the status
    tolerance : by how much a build differs from its drawing, one standard deviation; 0 where no drawing tells the value
    """

    key: str
    unit: str
    meaning: str
    default: float
    lower: float
    upper: float
    typical: float
    status: Status
    source: str = ""
    tolerance: float = 0.0

    @property
    def name(self) -> str:
        """The key without its section: ``EA``, ``precurvature``, ``contact_stop.angle``."""
        return self.key.split(".", 1)[1]

    @property
    def allowed(self) -> str:
        """Allowed values, in words."""
        unit = "" if self.unit == "-" else f" {self.unit}"
        return f"a finite number from {self.lower:g} to {self.upper:g}{unit}"

    def check(self, value: object) -> float:
        """Return `value` as a float, or raise `InputError` naming the key, the value and what is allowed."""
        if isinstance(value, bool) or not isinstance(value, Real):
            raise InputError(f"{self.key} = {shown(value)}: allowed is {self.allowed}")
        try:
            number = float(value)
        except OverflowError:
            number = value = math.inf
        if not self.lower <= number <= self.upper:
            raise InputError(f"{self.key} = {shown(value)}: allowed is {self.allowed}")
        return number
