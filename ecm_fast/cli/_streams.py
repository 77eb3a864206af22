"""Writing to stdout and stderr."""

import os
import sys
from typing import TextIO

__all__ = ["note", "write"]


def write(stream: TextIO | None, text: str) -> None:
    """Write and flush. A reader that has gone away (``| head``) is no error: the rest goes nowhere."""
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
            raise


def note(text: str) -> None:
    """Write one line to stderr, whatever line breaks a file's name in it may hold."""
    write(sys.stderr, f"ecm-fast: {' '.join(text.splitlines())}\n")
