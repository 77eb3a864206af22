"""Interrupts (Ctrl-C) that are never lost: they wait where an exception would be, and come again where it was."""

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

__all__ = ["interrupts_kept"]

_IMPORT = "<frozen importlib._bootstrap>"
_AGAIN = 0.02  # seconds after which an interrupt that waits or was lost is tried again


@contextmanager
def interrupts_kept() -> Iterator[None]:
    """Within it an interrupt is raised between imports and calls of llvmlite, not in one; a second one at once.

    Modules of compiled packages run callbacks while they are imported, where an exception is lost, and so does
    llvmlite, whose objects fail in ``__del__`` when they were not made to the end. It may be lost in any ``__del__``
    and callback of a weak reference: the interpreter hands it to `sys.unraisablehook`, and the interrupt is raised
    again a little later. What a command has found after an interrupt is no answer, whatever became of the exception.

    Raises
    ------
    KeyboardInterrupt : an interrupt came, however the body ended.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    asked = False

    def interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal asked
        second, asked = asked and number == signal.SIGINT, True
        if second or not (_may_be_lost(frame) and _again()):
            raise KeyboardInterrupt

    def lost(what: Any) -> None:
        if not (issubclass(what.exc_type, KeyboardInterrupt) and _again()):
            hook(what)

    numbers = (signal.SIGINT, signal.SIGALRM) if hasattr(signal, "SIGALRM") else (signal.SIGINT,)
    before = {number: signal.signal(number, interrupt) for number in numbers}
    hook, sys.unraisablehook = sys.unraisablehook, lost
    try:
        yield
    finally:
        if asked:
            _again(0.0)
        sys.unraisablehook = hook
        for number, handler in before.items():
            signal.signal(number, handler)
        if asked:
            raise KeyboardInterrupt


def _again(after: float = _AGAIN) -> bool:
    """Let the interrupt come again a little later, or with 0 never; returns whether the system can."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, after)
        return True
    return False


def _may_be_lost(frame: FrameType | None) -> bool:
    """Whether a module is being imported, or llvmlite at work."""
    while frame is not None:
        if frame.f_code.co_filename == _IMPORT or str(frame.f_globals.get("__name__")).startswith("llvmlite."):
            return True
        frame = frame.f_back
    return False
