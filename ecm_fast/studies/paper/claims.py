"""Claims of the reproduction: the numbers behind them, and their section of the page."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data.columns import CHANNEL_KEYS
from ...pages.page import Section

__all__ = [
    "CHANNEL_KEYS",
    "COMPONENTS",
    "DEG",
    "MM",
    "NOT_GIVEN",
    "NOT_PUBLIC",
    "SIMULATED",
    "UNKNOWN",
    "PaperClaim",
    "Part",
    "by_channel",
    "by_component",
    "shown",
    "verdict",
]

COMPONENTS = ("fx_N", "fz_N", "tau_Nm")
MM, DEG = 1e3, 180.0 / math.pi  # factors from m and rad to mm and deg
NOT_GIVEN, UNKNOWN = "not given", "cannot be checked"
NOT_PUBLIC = f"{UNKNOWN}: the measurements are not public"
SIMULATED = "SIMULATED: no one measured this"
"""The remark in every picture of the simulated test bed."""


@dataclass(frozen=True)
class PaperClaim:
    """One thing somebody says, and what comes out here.

    Attributes
    ----------
    what : in one sentence, with the bound it is held to
    theirs : the number of the paper or of the other source, or "not given"
    ours : the number found here
    verdict : "holds", "differs by ..." or "cannot be checked", the last perhaps with the reason
    """

    what: str
    theirs: str
    ours: str
    verdict: str


@dataclass(frozen=True)
class Part:
    """Contribution of one subject: claims, numbers in SI for ``results.json``, a section of the page."""

    claims: tuple[PaperClaim, ...]
    numbers: Mapping[str, Any]
    section: Section


def verdict(value: float, bound: float, difference: str) -> str:
    """Return "holds" where `value` is within `bound`, else by what it differs; an unknown value does not hold."""
    return "holds" if value <= bound else f"differs by {difference}"


def shown(value: float, spec: str) -> str:
    """Return a number in a format, or "unknown" where it is not finite."""
    return format(value, spec) if math.isfinite(value) else "unknown"


def by_channel(pose: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """Return the columns of poses (n, 3) by name and unit."""
    return dict(zip(CHANNEL_KEYS, pose.T, strict=True))


def by_component(wrench: NDArray[np.float64], prefix: str = "") -> dict[str, NDArray[np.float64]]:
    """Return the columns of wrenches (n, 3), or of something about them, by name and unit."""
    return {f"{prefix}{name}": column for name, column in zip(COMPONENTS, wrench.T, strict=True)}
