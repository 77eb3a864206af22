"""Odds of one explanation against another, in words."""

import math

__all__ = ["alternative_caveat", "odds"]

_CERTAIN = 1e4
"""Odds beyond which their number says nothing more."""


def odds(evidence: float) -> str:
    """Return the odds of what has so much more evidence, of explanations equally likely before the data speak."""
    times = math.exp(min(0.5 * evidence, math.log(_CERTAIN)))
    return f"more than {_CERTAIN:.0f}" if times >= 0.999 * _CERTAIN else f"{times:.0f}"


def alternative_caveat(name: str, evidence: float) -> str:
    """Return a line where one effect alone passes the tests, though two have so much more evidence."""
    return f"{name} alone passes the tests, too; that there are two effects is {odds(evidence)} times as likely"
