"""``ecm-fast sweep``: many cases, written to files; an interrupted sweep can be resumed."""

import argparse
import time
from collections.abc import Mapping
from typing import Any

from .frame.arguments import count, note_assumed
from .frame.command import Answer, Command
from .frame.terminal import Waiting, bar, note

__all__ = ["COMMAND"]

# seconds before the first report of progress on a terminal, and between two where every report is a line of its own
_ON_TERMINAL, _ON_LINES = 0.2, 10.0


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "spec", metavar="SPEC", help="what varies, and how (TOML); see ecm_fast/studies/sweeps/README.md"
    )
    parser.add_argument("--threads", metavar="N", type=count, help="of this machine; default: one a core")
    parser.add_argument("--cluster", metavar="ADDRESS", help="of a scheduler of dask's distributed; default: none")


def _run(args: argparse.Namespace) -> Answer:
    from ..studies.sweeps import read_spec, sweep

    spec, progress = read_spec(args.spec), _Progress()
    note_assumed(spec.mechanism, args.spec)
    done = sweep(spec, args.out or "out/sweep", executor=args.cluster, threads=args.threads, progress=progress)
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
        self._line = Waiting(_ON_TERMINAL)
        self._first: tuple[float, int] | None = None
        self._said = time.monotonic()

    def __call__(self, done: int, cases: int) -> None:
        now = time.monotonic()
        if self._first is None:
            self._first = now, done
        start, before = self._first
        text = bar(done, cases, now - start, before, " cases")
        self._line(text)
        if not self._line.seen and now - self._said >= _ON_LINES:
            self._said = now
            note(text)

    def end(self) -> None:
        """Leave the line of a terminal empty."""
        self._line.end()


COMMAND = Command(
    "many cases over loads, parameters and effects, into files; goes on where it stopped", _add_arguments, _run
)
