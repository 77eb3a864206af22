"""The next step after an answer, in one sentence."""

from collections.abc import Mapping, Sequence
from typing import Any

__all__ = ["next_step", "unexplained"]

_ABOVE = 1.2
"""Misfit on rows set aside, over the noise, that its interval must exceed before more is missing."""

_STEPS = {
    "named": "measure other loads and confirm it there: ecm-fast diagnose DATA --test OTHER",
    "family": "measure what ecm-fast next lists for this result, and diagnose both files together",
    "outside_catalogue": "see on the page where the model is off, write that law as a plug-in (--plugin), and diagnose "
                         "again; until then trust the model to no better than what is left",
    "nothing_found": "use the mechanism as calibrated; ecm-fast plan DATA lists what these loads cannot show",
}  # fmt: skip


def unexplained(gap: Mapping[str, Any]) -> float:
    """Return how many times the noise is left on rows set aside with what was found, 0 where that may be noise alone.

    gap : of a diagnosis's JSON
    """
    left = gap.get("after") or {}
    low = (left.get("interval") or [None])[0]
    return float(left["rms_sigma"]) if low is not None and low > _ABOVE else 0.0


def next_step(verdict: str, gap: Mapping[str, Any], missing: Sequence[str] = ()) -> str:
    """Return what to do with an answer.

    Parameters
    ----------
    verdict, gap, missing : of a diagnosis's JSON
    """
    step = f"record {', '.join(missing)} and diagnose again" if verdict == "data_gap" else _STEPS[verdict]
    left = unexplained(gap)
    if not left or verdict in ("outside_catalogue", "data_gap"):
        return step
    return (f"{left:.2g} times the noise is left on rows set aside, so more is missing: see on the page where, and "
            f"measure other kinds of loads; then {step}")  # fmt: skip
