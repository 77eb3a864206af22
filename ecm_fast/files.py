"""Atomic file writing, text tables, and JSON-compatible values."""

import csv
import errno
import io
import math
import os
import stat
import tempfile
import threading
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from .errors import InputError, why

__all__ = ["csv_text", "plain", "write_whole"]

_UMASK = threading.Lock()  # it can only be read by being set: two threads at once would leave the other's 0


def write_whole(path: str | os.PathLike[str], content: str | bytes | Sequence[bytes | memoryview]) -> Path:
    """Write `content`, or its parts, to a temporary file beside `path`, then rename it over `path`.

    A reader sees the old file or the new one, never a half; a full disk leaves the old one untouched.

    Raises
    ------
    InputError : the file cannot be written; names the path and the system's reason.
    """
    place = Path(path)
    whole = content.encode() if isinstance(content, str) else content
    parts = [whole] if isinstance(whole, bytes) else whole
    temporary = None
    try:
        target = Path(os.path.realpath(place))  # a link stays a link
        if target.exists() and not target.is_file():
            reason = os.strerror(errno.EISDIR) if target.is_dir() else "not a regular file"
            raise OSError(errno.EISDIR, reason)
        handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
        with os.fdopen(handle, "wb") as file:
            file.writelines(parts)
        os.chmod(temporary, _mode(target))
        os.replace(temporary, target)
        temporary = None
    except (OSError, ValueError) as error:
        raise InputError(f"{place}: cannot be written here ({why(error)})") from None
    finally:
        if temporary is not None:
            os.unlink(temporary)
    return place


def _mode(target: Path) -> int:
    """Return the permissions of the file that is replaced, or those that any new file gets."""
    if target.exists():
        return stat.S_IMODE(target.stat().st_mode)
    with _UMASK:
        umask = os.umask(0)
        os.umask(umask)
    return 0o666 & ~umask


def csv_text(columns: Mapping[str, Iterable[Any]]) -> str:
    """Return a CSV of equally long columns: numbers to the last digit, blank where a number is not known."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_cell(value) for value in row] for row in zip(*columns.values(), strict=True))
    return text.getvalue()


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return repr(float(value)) if math.isfinite(value) else ""
    return "" if value is None else str(value)


def plain(value: Any) -> Any:
    """Return `value` as JSON can hold it: arrays as lists, paths as text, what is not finite as None."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, os.PathLike):
        return str(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value
