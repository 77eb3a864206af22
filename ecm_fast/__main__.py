"""Entry point of the command ``ecm-fast`` and of ``python -m ecm_fast``."""

import sys
from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; an interrupt while its modules are loaded is one line, too."""
    try:
        from .cli import main as run

        return run(argv)
    except KeyboardInterrupt:
        sys.stderr.write("ecm-fast: interrupted\n")
        return 130


if __name__ == "__main__":
    sys.exit(main())
