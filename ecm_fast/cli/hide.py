"""``ecm-fast hide``: simulated measurements with a hidden effect, to test a diagnosis."""

import argparse
from pathlib import Path

from ..errors import InputError
from ._arguments import count, finite_number, mechanism
from ._command import IN_OUT, Answer, Command, folder, outputs

__all__ = ["COMMAND"]

_COMMENT = "SIMULATED, nobody measured this: the test bed of ecm_fast made it. What is hidden in it is told elsewhere."


def _sized(word: str) -> tuple[str, float | None]:
    """Split ``NAME=SIZE``; without a size it is None."""
    name, given, size = word.partition("=")
    return name, finite_number(size) if given else None


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--mechanism", metavar="F", help="what everybody believes to be built; default: 'slender'")
    parser.add_argument(
        "--effect",
        action="append",
        default=[],
        type=_sized,
        metavar="NAME[=SIZE]",
        help="an effect to hide; without a size 0.5 to 2 times the typical one; 'random' for any of the catalogue, "
        "'random_outside' for one that is in none; may be given several times, and not at all",
    )
    parser.add_argument(
        "--design",
        default="T",
        metavar="D",
        help="experiments joined with +: T tendons on a 9 x 9 grid (grid7: 7 x 7), T1 its left half, S side force, "
        "C push, M couple, W 2 kg more, G tilted, B forth and back; default T",
    )
    parser.add_argument(
        "--noise",
        default="white",
        metavar="N",
        help="joined with +: white, none, force, strong_force, tails, correlated, outliers, drift, undeclared, "
        "geometry, frame; default white",
    )
    parser.add_argument("--sessions", type=count, default=1, metavar="K", help="sessions of the first experiment")
    parser.add_argument("--seed", type=count, default=0, metavar="N", help="of everything random; default 0")
    parser.add_argument("--truth", metavar="FILE", help="where the truth goes; default truth.json beside the data")


def _run(args: argparse.Namespace) -> Answer:
    from ..testbed.sealed.hide import hide

    effects = dict(args.effect)
    if len(effects) < len(args.effect):
        raise InputError("--effect: a name is given twice; say each once")
    neck, place = mechanism(args), folder(args.out or "out")
    path, kept = place / "sealed.csv", Path(args.truth) if args.truth else place / "truth.json"
    outputs(path, kept)
    data, truth = hide(neck, effects, design=args.design, seed=args.seed, noise=args.noise, sessions=args.sessions)
    data.to_csv(path, _COMMENT)
    truth.to_json(kept)
    answer = {"data": path, "truth": kept, "rows": data.n}
    return Answer(answer, f"{data.n} rows", (f"wrote {path}", f"wrote {kept}: do not look before you have an answer"))


COMMAND = Command("make measurements that hide an effect, and its truth in another file", _add_arguments, _run, IN_OUT)
