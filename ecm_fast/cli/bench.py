"""``ecm-fast bench``: solve times of all models on this machine, as in the paper's Fig. 7."""

import argparse

from .frame.arguments import count, mechanism
from .frame.command import IN_OUT, Answer, Command, folder
from .frame.terminal import note

__all__ = ["COMMAND"]


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--mechanism", metavar="F", help="mechanism file (TOML); default: the preset 'slender'")
    parser.add_argument("--poses", type=count, default=100, metavar="N", help="random poses; default 100")
    parser.add_argument("--seed", type=count, default=7, metavar="S", help="for the poses; default 7")
    parser.add_argument("--batch", type=count, default=2048, metavar="N", help="solves in a batch; default 2048")
    parser.add_argument("--threads", type=count, default=2, metavar="N", help="of the second batches; default 2")
    parser.add_argument("--rounds", type=count, default=2, metavar="N", help="the shortest of N counts; default 2")


def _run(args: argparse.Namespace) -> Answer:
    from ..studies.paper.fig7_times import fig7

    note("compiling what is not compiled yet, and timing")
    settings = {name: getattr(args, name) for name in ("poses", "seed", "batch", "threads", "rounds")}
    result = fig7(None if args.mechanism is None else mechanism(args), **settings)
    files = result.write(folder(args.out or "out"))
    answer = {"settings": result.settings, "rows": result.rows, "times": result.times, "files": files}
    return Answer(answer, str(result), tuple(f"wrote {path}" for path in files))


COMMAND = Command(
    "how long a solve takes on this machine, model by model: the paper's Fig. 7", _add_arguments, _run, IN_OUT
)
