"""Output to stdout and stderr."""

import os
import shutil
import sys
import time
from typing import TextIO

from ...errors import InputError, why

__all__ = ["Waiting", "bar", "note", "write"]

_PATIENCE = 1.0  # seconds that nobody needs to be told about
_PAUSE = 0.1  # seconds between two texts on a line that is read
_WIDTH = 78  # of a bar with its numbers: the narrowest terminal in use


def write(stream: TextIO | None, text: str) -> None:
    """Write and flush. A reader that has gone away (``| head``) is no error: the rest goes nowhere.

    Raises
    ------
    InputError : stdout cannot be written, as on a full disk; names the system's reason.
    """
    if stream is None:  # closed by the caller, as in ``>&-``
        return
    encoding = stream.encoding or "utf-8"
    try:
        # a file's name may hold bytes that are no text, and a terminal may know ASCII alone
        stream.write(text.encode(encoding, "backslashreplace").decode(encoding))
        stream.flush()
    except OSError as error:
        # what is still in the buffer would be tried again, and complained about, at the interpreter's end
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        if stream is not sys.stderr and not isinstance(error, BrokenPipeError):
            raise InputError(f"stdout: cannot be written ({why(error)})") from None


def note(text: str) -> None:
    """Write one line to stderr, whatever line breaks a file's name in it may hold."""
    write(sys.stderr, f"ecm-fast: {' '.join(text.splitlines())}\n")


def bar(done: float, total: float, seconds: float, before: float, unit: str) -> str:
    """Return a bar with rate and time left, as tqdm draws it; `before` of the total was done at the beginning."""
    from tqdm import tqdm

    text: str = tqdm.format_meter(done, total, seconds, ncols=_WIDTH, ascii=True, unit=unit, initial=before)
    return text


class Waiting:
    """One line on a terminal's stderr that says what is being done, when it takes its time; silent elsewhere."""

    def __init__(self, patience: float | None = None) -> None:
        self.seen = sys.stderr is not None and sys.stderr.isatty()
        self._shown, self._width = time.monotonic() + (_PATIENCE if patience is None else patience) - _PAUSE, 0

    def __call__(self, text: str) -> None:
        """Show `text` in place of the one before."""
        if self.seen and time.monotonic() - self._shown >= _PAUSE:
            self._shown = time.monotonic()
            text = text[: shutil.get_terminal_size().columns - 1]
            write(sys.stderr, f"\r{text:<{self._width}}")
            self._width = len(text)

    def end(self) -> None:
        """Leave the line empty."""
        if self._width:
            write(sys.stderr, f"\r{'':<{self._width}}\r")
            self._width = 0
