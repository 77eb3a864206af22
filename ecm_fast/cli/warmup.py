"""``ecm-fast warmup``: compilation of every kernel in advance."""

import argparse
from dataclasses import asdict

from .frame.command import Answer, Command, saved
from .frame.terminal import note

__all__ = ["COMMAND"]


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--all",
        action="store_true",
        dest="everything",
        help="every family of elements and degree of polynomials too, not the defaults alone",
    )


def _run(args: argparse.Namespace) -> Answer:
    note("loading the compiler")
    from ..studies.warmup import warmup

    done = warmup(everything=args.everything, progress=note)
    kept = "nowhere: set NUMBA_CACHE_DIR" if done.cache is None else f"in {done.cache}"
    text = f"{done.compiled} kernels compiled, {done.from_cache} from the cache, in {done.seconds:.3g} s; kept {kept}"
    answer = asdict(done)
    return Answer(answer, text, saved(args, answer))


COMMAND = Command(
    "compile and keep the kernels of the default family and degree, of every order, so that nobody waits later",
    _add_arguments,
    _run,
)
