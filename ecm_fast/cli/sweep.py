"""``ecm-fast sweep``: many cases, written to files; an interrupted sweep can be resumed."""

import argparse
import sys
import time
from collections.abc import Mapping
from typing import Any

from ._arguments import count
from ._command import Answer, Command
from ._terminal import note, write

__all__ = ["COMMAND"]

# seconds between two reports of progress: on a terminal, and where every report is a line of its own
_ON_TERMINAL, _ON_LINES = 0.2, 10.0


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "spec", metavar="SPEC", help="what varies, and how (TOML); see ecm_fast/studies/sweeps/README.md"
    )
    parser.add_argument("--threads", metavar="N", type=count, help="of this machine; default: one a core")
    parser.add_argument("--cluster", metavar="ADDRESS", help="of a scheduler of dask's distributed; default: none")


def _run(args: argparse.Namespace) -> Answer:
    from ..studies.sweeps import sweep

    progress = _Progress()
    done = sweep(args.spec, args.out or "out/sweep", executor=args.cluster, threads=args.threads, progress=progress)
    progress.end()
    answer = {
        "cases": done.cases,
        "statuses": dict(done.statuses),
        "solved": done.solved,
        "seconds": done.seconds,
        "folder": done.folder,
        "files": len(done.files),
    }
    return Answer(answer, _text(answer), (f"wrote {done.folder}",))


def _text(answer: Mapping[str, Any]) -> str:
    kinds = ", ".join(f"{number} {name}" for name, number in answer["statuses"].items() if number)
    rate = answer["solved"] / answer["seconds"]
    return f"{answer['cases']} cases: {kinds}\n{answer['solved']} solved now, {rate:.3g} a second"


class _Progress:
    """Says on stderr how far the sweep is, how fast it goes and what time is left."""

    def __init__(self) -> None:
        self._same_line = sys.stderr is not None and sys.stderr.isatty()
        self._every = _ON_TERMINAL if self._same_line else _ON_LINES
        self._first: tuple[float, int] | None = None
        self._said = time.monotonic()
        self._width = 0

    def __call__(self, done: int, cases: int) -> None:
        now = time.monotonic()
        if self._first is None:
            self._first = now, done
        if now - self._said < self._every:
            return
        self._said = now
        start, before = self._first
        rate = (done - before) / max(now - start, 1e-9)
        left = f", {_time((cases - done) / rate)} left" if rate > 0.0 else ""
        text = f"{done / cases:.1%} of {cases}, {rate:.3g} a second{left}"
        if not self._same_line:
            note(text)
            return
        write(sys.stderr, f"\r{text:<{self._width}}")
        self._width = len(text)

    def end(self) -> None:
        """Leave the line of a terminal."""
        if self._width:
            write(sys.stderr, "\n")


def _time(seconds: float) -> str:
    hours, rest = divmod(round(seconds), 3600)
    return f"{hours} h {rest // 60} min" if hours else f"{rest // 60} min {rest % 60} s" if rest >= 60 else f"{rest} s"


COMMAND = Command(
    "many cases over loads, parameters and effects, into files; goes on where it stopped", _add_arguments, _run
)
