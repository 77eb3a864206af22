"""The cache of compiled kernels: its folder, and one file for each kernel and signature.

Numba's cache keys a kernel by the source of its file alone, so an edit in one file would leave stale callers in
another. This folder is named by a digest of everything a kernel can depend on: the sources of the package below the
models. ``NUMBA_CACHE_DIR`` moves it.

A file that is damaged is compiled and written anew. Where a file cannot be written, the kernel is compiled in memory,
in each process anew, and that is logged once. A file holds pickled objects, which run code when they are read: a folder
that belongs to another user, or that others can write, is not used.
"""

import hashlib
import linecache
import logging
import os
import pickle
import stat
import sys
import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

import numba
from numba.core import compiler, serialize, sigutils

__all__ = ["CACHE_FOLDER", "KernelCache", "sources"]

_log = logging.getLogger("ecm_fast")
_config: Any = numba.config  # its settings come from the environment, unknown to a type checker
_compiler: Any = compiler
_serialize: Any = serialize
_signatures: Any = sigutils
_ROOT = 0
_CHECKSUM = 4  # bytes at the head of a file


def sources() -> list[Path]:
    """Return every file whose text a compiled kernel can depend on."""
    package = Path(__file__).resolve().parent.parent
    return sorted(path for pattern in ("kernels/**/*.py", "mechanism/**/*.py") for path in package.glob(pattern))


def _user_cache() -> Path:
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))


def _cache_folder() -> Path | None:
    """Return the folder for this very version of the kernels, or None where there is none to write and to trust."""
    digest = hashlib.sha256(b"\0".join(path.read_bytes() for path in sources())).hexdigest()[:16]
    try:
        base = Path(_config.CACHE_DIR) if _config.CACHE_DIR else _user_cache()
        folders = base, base / "ecm_fast", base / "ecm_fast" / digest
        for folder in folders:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        why = next(filter(None, map(_distrusted, folders)), None)
        if why is None and not os.access(folders[-1], os.W_OK | os.X_OK):
            why = f"{folders[-1]} cannot be written"
    except (OSError, RuntimeError) as error:  # RuntimeError: no home directory can be determined
        why = str(error)
    if why is None:
        return folders[-1]
    _log.warning("no folder for compiled kernels: %s. Each process compiles anew; set NUMBA_CACHE_DIR.", why)
    return None


def _distrusted(folder: Path) -> str | None:
    """Return why another user could put files here, or put another folder in its place; None if nobody can."""
    if not hasattr(os, "geteuid"):
        return None
    status, user = folder.stat(), os.geteuid()
    if status.st_uid not in (user, _ROOT):
        return f"{folder} belongs to another user"
    # a group with the user's number is the user's alone, as most distributions set it up
    others = stat.S_IWOTH if status.st_gid == user else stat.S_IWOTH | stat.S_IWGRP
    # in a folder like /tmp what stands below belongs to whom it belongs
    if status.st_mode & others and not status.st_mode & stat.S_ISVTX:
        return f"{folder} can be written by other users"
    return None


CACHE_FOLDER = _cache_folder()


@cache
def _digest_of(file: str) -> str | None:
    """Return a digest of a file's text; None where there is none to read."""
    lines = linecache.getlines(file)
    return hashlib.sha256("".join(lines).encode()).hexdigest() if lines else None


class KernelCache:
    """The compiled versions of one kernel; what a dispatcher of numba expects of its cache.

    Attributes
    ----------
    cache_path : the folder
    compiled, loaded : kernels that this process compiled, and that it took from the cache
    """

    compiled: ClassVar[int] = 0
    loaded: ClassVar[int] = 0
    _complained: ClassVar[bool] = False

    def __init__(self, function: Callable[..., Any]) -> None:
        self.cache_path = str(CACHE_FOLDER)
        self._function = function
        # without its text a kernel cannot be told from another whose constants differ: it is never kept
        self._kept = CACHE_FOLDER is not None and _digest_of(function.__code__.co_filename) is not None

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """Return what was compiled for a signature, or None."""
        if not self._kept:
            return None
        try:
            content = self._path(signature, target_context.codegen()).read_bytes()
        except OSError:
            return None
        if content[:_CHECKSUM] != _checksum(content[_CHECKSUM:]):
            return None
        target_context.refresh()
        result = _compiler.CompileResult._rebuild(target_context, *pickle.loads(content[_CHECKSUM:]))
        KernelCache.loaded += 1
        return result

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep what was just compiled for a signature."""
        KernelCache.compiled += 1
        if not self._kept or result.lifted or result.library.has_dynamic_globals:
            return
        content = _serialize.dumps(result._reduce())
        try:
            _write(self._path(signature, result.library.codegen), _checksum(content) + content)
        except OSError as error:
            if not KernelCache._complained:
                _log.warning("compiled kernels cannot be kept: %s. Each process compiles anew.", error)
            KernelCache._complained = True

    def _path(self, signature: Any, codegen: Any) -> Path:
        """Return the file of a signature: named by all that the compiled code depends on, beside `sources`."""
        code = self._function.__code__
        # the text, for a kernel that stands elsewhere; what a kernel inside a function sees of it
        text, cells = _digest_of(code.co_filename), [cell.cell_contents for cell in self._function.__closure__ or ()]
        types = [str(entry) for entry in _signatures.normalize_signature(signature)]
        made_by = numba.__version__, sys.implementation.cache_tag, codegen.magic_tuple()
        key = types, made_by, code.co_firstlineno, code.co_code, text, cells
        name = f"{Path(code.co_filename).stem}.{self._function.__name__}"
        return Path(self.cache_path) / f"{name}-{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.nbc"


def _checksum(content: bytes) -> bytes:
    return zlib.crc32(content).to_bytes(_CHECKSUM, "little")


def _write(path: Path, content: bytes) -> None:
    """Write a file that is there whole or not at all, whatever other processes do."""
    draft = path.with_name(f"draft-{os.urandom(8).hex()}")
    try:
        with open(draft, "xb", opener=lambda name, flags: os.open(name, flags, 0o600)) as file:
            file.write(content)
        os.replace(draft, path)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise
