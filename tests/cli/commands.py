"""Results of commands run in a test."""

import json
from collections.abc import Callable
from typing import Any, NamedTuple

import pytest

__all__ = ["Ended", "Refused", "Run"]


class Ended(NamedTuple):
    """Exit code and output of a command."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        """The one JSON object on stdout."""
        assert self.out.count("\n") == 1
        answer = json.loads(self.out, parse_constant=lambda word: pytest.fail(f"{word} in JSON"))
        assert isinstance(answer, dict)
        return answer


Run = Callable[..., Ended]
Refused = Callable[..., str]
