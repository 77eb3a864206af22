"""Input files read with care, atomic file writing, text tables, and JSON-compatible values."""

import csv
import errno
import io
import math
import os
import stat
import threading
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from .errors import InputError, shown, why

__all__ = ["check_form", "csv_text", "inputs_kept", "plain", "read_whole", "refuse_input", "write_whole"]

MOST_BYTES = 1 << 30
"""Largest input file: ten million rows of CSV; what is larger is no file of measurements, and fills the memory."""

_UMASK = threading.Lock()  # it can only be read by being set: two threads at once would leave the other's 0
_Inode = tuple[int, int]  # device and number of a file, the same for all its names
_inputs: dict[str, _Inode] | None = None  # what was read within `inputs_kept`, by its real path


def read_whole(path: str | os.PathLike[str]) -> bytes:
    """Return the content of an input file.

    Only a regular file is read: a pipe may wait for a writer for ever, and a device need not end.

    Raises
    ------
    OSError : the file cannot be read, is not a regular file, or is larger than `MOST_BYTES`.
    ValueError : the path holds a NUL.
    """
    with open(path, "rb", opener=_open_at_once) as file:
        about = os.fstat(file.fileno())
        if not stat.S_ISREG(about.st_mode):
            raise OSError(errno.EINVAL, "not a regular file; write what comes through it to one")
        if about.st_size > MOST_BYTES:
            raise OSError(errno.EFBIG, f"{about.st_size} bytes; allowed are {MOST_BYTES}")
        if _inputs is not None:
            _inputs[os.path.realpath(path)] = about.st_dev, about.st_ino
        return file.read()


def _open_at_once(path: str, flags: int) -> int:
    """Open a file without waiting for a writer, should it be a pipe."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


@contextmanager
def inputs_kept() -> Iterator[None]:
    """Within it no file that `read_whole` has read is replaced by `write_whole`; for one command line at a time."""
    global _inputs
    before, _inputs = _inputs, {}
    try:
        yield
    finally:
        _inputs = before


def refuse_input(path: str | os.PathLike[str]) -> None:
    """Complain where an output would replace what was read within `inputs_kept`, under this or another name.

    Raises
    ------
    InputError : it would.
    """
    if not _inputs:
        return
    try:
        about = os.stat(path)
    except (OSError, ValueError):  # nothing there to replace, or what `write_whole` complains about
        return
    if os.path.realpath(path) in _inputs or (about.st_dev, about.st_ino) in _inputs.values():
        raise InputError(f"{os.fspath(path)}: is an input of this command, which its output must not replace; "
                         "write to another folder or name")  # fmt: skip


def write_whole(path: str | os.PathLike[str], content: str | bytes | memoryview | Sequence[bytes | memoryview]) -> Path:
    """Write `content`, or its parts, to a temporary file beside `path`, then rename it over `path`.

    A reader sees the old file or the new one, never a half, and after a power failure, too: the content is on disk
    before its name is. A full disk leaves the old file untouched. Letters that are no text, as the names of files may
    hold, are written as escapes.

    Raises
    ------
    InputError : the file cannot be written, or is an input, see `refuse_input`; names the path and the reason.
    """
    place = Path(path)
    refuse_input(place)
    whole = content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content
    parts = [whole] if isinstance(whole, (bytes, memoryview)) else whole
    temporary = None
    try:
        target = Path(os.path.realpath(place))  # a link stays a link
        if target.exists() and not target.is_file():
            reason = os.strerror(errno.EISDIR) if target.is_dir() else "not a regular file"
            raise OSError(errno.EISDIR, reason)
        temporary = target.with_name(f".{target.name}.{os.urandom(4).hex()}")  # known before it is there
        with open(temporary, "xb", opener=_open_for_us) as file:
            file.writelines(parts)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, _mode(target))
        os.replace(temporary, target)
    except (OSError, ValueError) as error:
        raise InputError(f"{place}: cannot be written here ({why(error)})") from None
    finally:
        if temporary is not None:
            with suppress(OSError):  # it has its place by now, or was never made
                temporary.unlink()
    return place


def _open_for_us(path: str, flags: int) -> int:
    return os.open(path, flags, 0o600)


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


def check_form(value: Any, form: Any, name: str = "") -> None:
    """See that a value from a JSON file has a form.

    Parameters
    ----------
    form : a type; None; a list with the form of every entry; a dict with the forms of its keys, of which one that ends
        with a question mark may be missing, and ``"*"`` stands for all others; or a tuple of forms that are allowed
    name : of the value, for the message

    Raises
    ------
    InputError : it has another one; names the first place where, and what is there.
    """
    if isinstance(form, tuple):
        if not any(_has_form(value, each) for each in form):
            raise _misfit(name, value)
    elif isinstance(form, list):
        if not isinstance(value, list):
            raise _misfit(name, value)
        for i, entry in enumerate(value):
            check_form(entry, form[0], f"{name}[{i}]")
    elif isinstance(form, dict):
        if not isinstance(value, dict):
            raise _misfit(name, value)
        for key in form:
            if key != "*" and not key.endswith("?") and key not in value:
                raise InputError(f"{name} has no {shown(key)}".lstrip())
        for key, entry in value.items():
            entry_form = form.get(key, form.get(f"{key}?", form.get("*")))
            if entry_form is not None:
                check_form(entry, entry_form, f"{name}.{key}" if name else key)
    elif not _is_a(value, form):
        raise _misfit(name, value)


def _has_form(value: Any, form: Any) -> bool:
    try:
        check_form(value, form)
    except InputError:
        return False
    return True


def _is_a(value: Any, form: type | None) -> bool:
    """Tell whether a value is of a type; a float is any finite number that is no truth value."""
    if form is None:
        return value is None
    if form is float:
        return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e308
    return isinstance(value, form)


def _misfit(name: str, value: Any) -> InputError:
    return InputError(f"{name or 'the whole'} = {shown(value)}: not of the form that such a file has there")
