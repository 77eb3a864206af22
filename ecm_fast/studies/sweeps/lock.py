"""The lock of a sweep's folder: one run at a time, released by the operating system when the process ends."""

import errno
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from ...errors import InputError, why

__all__ = ["sole_writer"]

_NAME = ".lock"
# what a system answers whose file is locked by another; any other answer means that it has no locks
_BUSY = {errno.EAGAIN, errno.EACCES, errno.EDEADLK}
# these locks tell processes apart, not threads; a forked process has none of its parent's
_HELD: set[tuple[int, str]] = set()
_GUARD = threading.Lock()


@contextmanager
def sole_writer(folder: Path) -> Iterator[None]:
    """Keep every other run out of a folder; where a file system has no locks, those of this process alone.

    Raises
    ------
    InputError : another run writes it now.
    """
    key = os.getpid(), os.path.realpath(folder)
    with _GUARD:
        if key in _HELD:
            raise _taken(folder)
        _HELD.add(key)
    try:
        with _locked(folder):
            yield
    finally:
        _HELD.discard(key)


def _locked(folder: Path) -> IO[bytes]:
    """Return the locked file; to close it unlocks it."""
    try:
        file = (folder / _NAME).open("ab")
    except OSError as error:
        raise InputError(f"{folder}: cannot be written here ({why(error)})") from None
    try:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.lockf(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in _BUSY:
            file.close()
            raise _taken(folder) from None
    return file


def _taken(folder: Path) -> InputError:
    return InputError(f"{folder}: another run is writing it; wait for its end, or give another folder")
