"""The exceptions of the package.

    EcmError
    ├── InputError      what came in cannot be right: names the place, the value and what is allowed
    ├── OutOfReach      no allowed tendon forces meet a wish: names the nearest
    └── NotConverged    a solve was asked to vouch for its result and could not

    UserWarning
    └── OutOfRangeWarning    a fitted polynomial is asked about what it was not trained on

Kernels never raise: they return a status, and `Equilibrium.raise_if_failed` is where it becomes an exception.
"""

import math
from collections.abc import Iterable
from difflib import get_close_matches
from numbers import Real

__all__ = [
    "EcmError",
    "InputError",
    "NotConverged",
    "OutOfRangeWarning",
    "OutOfReach",
    "did_you_mean",
    "key_shown",
    "real",
    "shown",
    "why",
]


class EcmError(Exception):
    """Base of every error this package raises on purpose."""


class InputError(EcmError, ValueError):
    """Input that cannot be right; the text is one line with the place, the value and the cure."""


class OutOfReach(EcmError):  # noqa: N818  as below
    """No allowed tendon forces meet a wish; the text gives the nearest that can be had."""


class NotConverged(EcmError):  # noqa: N818  the name says what happened, as `StopIteration` does
    """No equilibrium was found for the loads asked for; the text tells how far the loading got."""


class OutOfRangeWarning(UserWarning):
    """A fitted polynomial is asked about what it was not trained on; the text says what leaves the range, how far."""


def real(name: str, value: object) -> float:
    """Return an argument that must be one number as a float, or raise `InputError` that names it."""
    if not isinstance(value, Real) or isinstance(value, bool):
        raise InputError(f"{name} = {shown(value)}: allowed is a number")
    try:
        return float(value)
    except OverflowError:
        return math.inf


def did_you_mean(word: str, allowed: Iterable[str]) -> str:
    """Return ``" (did you mean 'length'?)"`` for a misspelt word, or nothing when no name is near."""
    names = list(allowed)
    same = [name for name in names if name.lower() == word.lower()]
    near = same or get_close_matches(word, names, n=1)
    return f" (did you mean {near[0]!r}?)" if near else ""


def key_shown(key: str) -> str:
    """Return a key as it is written in a file, quoted where it holds anything but plain characters."""
    return key if key.isprintable() and len(key) <= 80 else shown(key)


def why(error: Exception) -> str:
    """Return the system's reason for refusing a file, in the same words on every Python."""
    reason = getattr(error, "strerror", None) or str(error)
    return "embedded null byte" if "embedded null" in reason else reason


def shown(value: object) -> str:
    """Return a value as an error shows it: on one line, and not longer than a line."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # an integer of thousands of digits, a table nested as deep
        return f"something too long to write out, of type {type(value).__name__}"
    text = " ".join(text.split())
    return text if len(text) <= 80 else f"{text[:60]}... ({len(text)} characters)"
