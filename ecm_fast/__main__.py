"""Entry point of the command ``ecm-fast`` and of ``python -m ecm_fast``."""

import sys

from .cli import main

__all__ = ["main"]

if __name__ == "__main__":
    sys.exit(main())
