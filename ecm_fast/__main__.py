"""Entry point of the command ``ecm-fast`` and of ``python -m ecm_fast``."""

import os
import signal
import sys
import threading
from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code.

    An interrupt while the modules of the commands are loaded, or while the process that came for this command ends,
    ends it at once: there is nothing to tidy up then, and an exception may be lost there.
    """
    main_thread = threading.current_thread() is threading.main_thread()
    before = signal.signal(signal.SIGINT, _end) if main_thread else None
    try:
        from .cli import main as run

        return run(argv)
    finally:
        if main_thread:
            signal.signal(signal.SIGINT, _end if argv is None else before)


def _end(*_: object) -> None:
    try:
        os.write(2, b"ecm-fast: interrupted\n")
    finally:
        os._exit(130)


if __name__ == "__main__":
    sys.exit(main())
