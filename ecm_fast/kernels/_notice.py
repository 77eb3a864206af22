"""One line of the log where compiling takes its time: nobody should wonder what a first call waits for."""

import logging
import threading
import time
from typing import Any, ClassVar

from numba.core import event

from ._cache import KernelCache

__all__ = ["CompileNotice"]

_log = logging.getLogger("ecm_fast")
_events: Any = event
_PATIENCE = 2.0  # seconds of compiling, all kernels together, that nobody needs to be told about
_TEXT = "ecm_fast: compiling kernels, once, which can take a minute or two; 'ecm-fast warmup' does this ahead"


class CompileNotice(_events.Listener):  # type: ignore[misc]  # numba is untyped
    """Listener to numba's compiler that speaks once a process; the kernels of other packages do not count.

    Attributes
    ----------
    given : whether the line was written, or need not be
    """

    given: ClassVar[bool] = False

    def __init__(self) -> None:
        self._inside, self._spent, self._begin = 0, 0.0, 0.0
        self._timer: threading.Timer | None = None

    def on_start(self, event: Any) -> None:
        if CompileNotice.given or not isinstance(event.data["dispatcher"]._cache, KernelCache):
            return
        self._inside += 1
        if self._inside == 1:
            self._begin = time.monotonic()
            self._timer = threading.Timer(max(_PATIENCE - self._spent, 0.0), self._speak)
            self._timer.daemon = True
            self._timer.start()

    def on_end(self, event: Any) -> None:
        if not self._inside or not isinstance(event.data["dispatcher"]._cache, KernelCache):
            return
        self._inside -= 1
        if self._inside == 0 and self._timer is not None:
            self._timer.cancel()
            self._spent += time.monotonic() - self._begin

    def _speak(self) -> None:
        if not CompileNotice.given:
            CompileNotice.given = True
            _log.warning(_TEXT)
