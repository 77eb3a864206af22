"""``ecm-fast hide`` and ``score``: simulated measurements with a hidden effect, and the grade of an answer."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError
from .frame.arguments import count, finite_number, mechanism
from .frame.command import IN_OUT, Answer, Command, folder, outputs, saved

if TYPE_CHECKING:
    from ..testbed.sealed.score import Score

__all__ = ["HIDE", "SCORE"]

_COMMENT = "SIMULATED, nobody measured this: the test bed of ecm_fast made it. What is hidden in it is told elsewhere."


def _sized(word: str) -> tuple[str, float | None]:
    """Split ``NAME=SIZE``; without a size it is None."""
    name, given, size = word.partition("=")
    return name, finite_number(size) if given else None


def _add_hide(parser: argparse.ArgumentParser) -> None:
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
    parser.add_argument(
        "--variant",
        default="",
        metavar="V",
        help="law in the place of the catalogue's, such as 'bending_levels_off' or 'zeroed_at_rest'; default none",
    )
    parser.add_argument("--sessions", type=count, default=1, metavar="K", help="sessions of the first experiment")
    parser.add_argument("--seed", type=count, default=0, metavar="N", help="of everything random; default 0")
    parser.add_argument("--truth", metavar="FILE", help="where the truth goes; default truth.json beside the data")


def _hide(args: argparse.Namespace) -> Answer:
    from ..testbed.sealed.hide import hide

    effects = dict(args.effect)
    if len(effects) < len(args.effect):
        raise InputError("--effect: a name is given twice; say each once")
    neck, place = mechanism(args), folder(args.out or "out")
    path, kept = place / "sealed.csv", Path(args.truth) if args.truth else place / "truth.json"
    outputs(path, kept)
    data, truth = hide(
        neck,
        effects,
        design=args.design,
        seed=args.seed,
        noise=args.noise,
        sessions=args.sessions,
        variant=args.variant,
    )
    data.to_csv(path, _COMMENT)
    truth.to_json(kept)
    answer = {"data": path, "truth": kept, "rows": data.n}
    return Answer(answer, f"{data.n} rows", (f"wrote {path}", f"wrote {kept}: do not look before you have an answer"))


def _add_score(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("result", metavar="RESULT", help="what diagnose --json said")
    parser.add_argument("truth", metavar="TRUTH", help="what hide kept back")


def _score(args: argparse.Namespace) -> Answer:
    from ..testbed.sealed.score import score

    grade = score(args.result, args.truth)
    answer = grade.to_json_dict()
    return Answer(answer, _text(grade), saved(args, answer))


def _text(grade: "Score") -> str:
    answers = {True: "yes", False: "NO", None: "not asked"}
    lines = [
        f"hidden: {', '.join(grade.hidden) or 'nothing'}",
        f"answer: {grade.verdict}, {', '.join(grade.named) or 'no name'}",
        f"verdict right: {answers[grade.verdict_right]}",
        f"first names right: {answers[grade.top]}",
        f"truth in the reported set: {answers[grade.in_set]}",
        f"more effects than hidden: {'YES' if grade.extra else 'no'}",
    ]
    if grade.set_size is not None:
        lines.append(f"names in a set: {grade.set_size:.3g}")
    if grade.alone:
        lines.append(f"names printed alone right: {answers[grade.alone_right]}")
    for name, error in grade.size_error.items():
        lines.append(f"{name}: {error:+.2%} off, interval holds the truth: {answers[grade.covered.get(name)]}")
    if grade.gap_closed is not None:
        lines.append(f"gap closed on locked rows, of the mechanism calibrated alone: {grade.gap_closed:.2%}")
    if grade.gap_closed_since_given is not None:
        lines.append(f"the same of the mechanism as it was given: {grade.gap_closed_since_given:.2%}")
    return "\n".join(lines)


HIDE = Command("make measurements that hide an effect, and its truth in another file", _add_hide, _hide, IN_OUT)
SCORE = Command("grade the answer of a diagnosis against the truth", _add_score, _score)
