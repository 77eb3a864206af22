"""Write a file whole or not at all."""

import os
import tempfile
from pathlib import Path

from .errors import InputError

__all__ = ["write_whole"]


def write_whole(path: str | os.PathLike[str], content: str | bytes) -> Path:
    """Write `content` to a temporary file beside `path`, then rename it over `path`.

    A reader sees the old file or the new one, never a half; a full disk leaves the old one untouched.

    Raises
    ------
    InputError : the file cannot be written; names the path and the system's reason.
    """
    target = Path(path)
    data = content.encode() if isinstance(content, str) else content
    try:
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
    except (OSError, ValueError) as error:
        raise InputError(f"{target}: cannot be written here ({_reason(error)})") from None
    try:
        with os.fdopen(handle, "wb") as temporary:
            temporary.write(data)
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(name, 0o666 & ~umask)  # mkstemp keeps the file to its owner; a result is as public as any file
        os.replace(name, target)
    except OSError as error:
        os.unlink(name)
        raise InputError(f"{target}: cannot be written here ({_reason(error)})") from None
    return target


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)
