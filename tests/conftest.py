"""Shared fixtures: the reader of the tables in `tests/tables`; interrupts in background jobs."""

import csv
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

Row = dict[str, float | str]

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as a shell's background jobs have it, and all that they start
    signal.signal(signal.SIGINT, signal.default_int_handler)


def _value(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


@pytest.fixture(scope="session")
def table() -> Callable[[str], list[Row]]:
    """Return a function that reads a table of `tests/tables`; the comment at its head defines its columns."""

    def _table(name: str) -> list[Row]:
        with (Path(__file__).parent / "tables" / f"{name}.csv").open(encoding="utf-8") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        return [{key: _value(text) for key, text in row.items()} for row in rows]

    return _table
