"""Interrupts (Ctrl-C) that wait for the end of an import or of a callback from C."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["interrupts_after_imports"]

_IMPORT = "<frozen importlib._bootstrap>"
_CALLBACK = "_raw_object_cache_notify"  # of llvmlite, called from C when a kernel is compiled or loaded
_AGAIN = 0.02  # seconds after which an interrupt that waits is tried again


@contextmanager
def interrupts_after_imports() -> Iterator[None]:
    """Within it an interrupt is raised between imports, not in one; a second one is raised at once.

    Modules of compiled packages run callbacks from C while they are imported, and so does the compiler of kernels. An
    exception that is raised there is printed and lost: the command would go on as if nobody had interrupted it.
    """
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "setitimer"):
        yield
        return
    waiting = False

    def interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal waiting
        if _called_from_c(frame) and not (waiting and number == signal.SIGINT):
            waiting = True
            signal.setitimer(signal.ITIMER_REAL, _AGAIN)
            return
        raise KeyboardInterrupt

    before = {number: signal.signal(number, interrupt) for number in (signal.SIGINT, signal.SIGALRM)}
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        for number, handler in before.items():
            signal.signal(number, handler)


def _called_from_c(frame: FrameType | None) -> bool:
    """Whether an exception that is raised here may be lost in C: in an import, or in a callback of the compiler."""
    while frame is not None:
        if frame.f_code.co_filename == _IMPORT or frame.f_code.co_name == _CALLBACK:
            return True
        frame = frame.f_back
    return False
