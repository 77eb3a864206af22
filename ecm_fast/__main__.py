"""Entry point of the command ``ecm-fast`` and of ``python -m ecm_fast``."""

import os
import signal
import sys
from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code.

    An interrupt while the modules of the commands are loaded, or while the process that came for this command ends,
    ends it at once: there is nothing to tidy up then, and an exception may be lost there.
    """
    try:
        before = signal.signal(signal.SIGINT, _end)
    except ValueError:  # in a thread beside the main one, where no signal comes
        before = None
    try:
        from .cli import main as run

        return run(argv)
    finally:
        if before is not None:
            signal.signal(signal.SIGINT, _end if argv is None else before)


def _end(*_: object) -> None:
    try:
        os.write(2, b"ecm-fast: interrupted\n")
    finally:
        os._exit(130)


if __name__ == "__main__":
    sys.exit(main())
