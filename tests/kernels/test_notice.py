"""The one line about compiling, and what a warm-up covers: against numba's own count of what was compiled."""

import logging

import numba
import pytest

from ecm_fast.kernels import _notice
from ecm_fast.kernels._jit import kernel
from ecm_fast.kernels._notice import CompileNotice
from ecm_fast.models.paths.condensed import ORDERS
from ecm_fast.studies.warmup import _touches


def compiled(decorate) -> list[str]:
    """Compile two new functions by a decorator, in a second or so; returns what was logged."""
    lines: list[str] = []

    class Keep(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            lines.append(record.getMessage())

    handler, log = Keep(), logging.getLogger("ecm_fast")
    log.addHandler(handler)
    try:
        for power in (2, 3):
            source = f"def f(x):\n    total = 0.0\n    for i in range(3):\n        total += x ** {power}\n"
            place: dict[str, object] = {}
            exec(source + "    return total\n", place)
            # nothing but a constant tells one from the other, and no file has their text
            assert decorate(place["f"])(1.5) == pytest.approx(3 * 1.5**power)
    finally:
        log.removeHandler(handler)
    return lines


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the line come after a hundredth of a second, as if nothing had been said."""
    monkeypatch.setattr(_notice, "_PATIENCE", 0.01)
    monkeypatch.setattr(CompileNotice, "given", False)


def test_compiling_is_said_once():
    """Two kernels compiled, each of which takes numba longer than the patience: one line."""
    lines = compiled(kernel)
    assert len(lines) == 1
    assert "compiling kernels, once" in lines[0]
    assert "ecm-fast warmup" in lines[0]
    assert compiled(kernel) == []


def test_what_others_compile_is_not_ours_to_say():
    """A function under numba's own decorator."""
    assert compiled(numba.njit) == []


def test_a_warmup_covers_every_order_of_the_fast_path():
    """The orders that the fast path says it has: control step and batch of each, without `everything`."""
    names = [what for what, _ in _touches((3,), ("lagrange",))]
    for order in ORDERS:
        for what in ("control step", "control step with derivatives", "batch", "batch from a polynomial"):
            assert f"one element of order {order}: {what}" in names
