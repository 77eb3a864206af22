"""Progress reports of a running diagnosis."""

from collections.abc import Callable

from tqdm import tqdm

__all__ = ["STAGES", "Progress"]

STAGES = ("search", "all rows", "proof")
_BAR = 20  # characters
_HALF = 20  # fits after which a stage's part of the bar is half full: how many a search takes nobody knows before


class Progress:
    """Tells of every step of a diagnosis in one line with a bar.

    Parameters
    ----------
    tell : what to call with that line; nobody where it is None
    """

    def __init__(self, tell: Callable[[str], None] | None = None) -> None:
        self._tell, self._stage, self._steps = tell, 0, 0

    def begin(self, stage: str) -> None:
        """Enter one of the `STAGES`."""
        self._stage, self._steps = STAGES.index(stage), 0
        self._say("")

    def step(self, rows: int, what: str) -> None:
        """Begin a step on so many rows."""
        self._steps += 1
        self._say(f", {rows} rows, step {self._steps}: {what}")

    def _say(self, text: str) -> None:
        if self._tell is not None:
            share = (self._stage + self._steps / (self._steps + _HALF)) / len(STAGES)
            bar = tqdm.format_meter(share, 1.0, 0.0, ncols=_BAR + 2, ascii=".#", bar_format="[{bar}]")
            self._tell(f"{bar} {STAGES[self._stage]}{text}")
