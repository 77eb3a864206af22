"""``ecm-fast score``: the grade of an answer about sealed measurements."""

import argparse
from typing import TYPE_CHECKING

from ._command import Answer, Command, saved

if TYPE_CHECKING:
    from ..testbed.sealed.score import Score

__all__ = ["COMMAND"]


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("result", metavar="RESULT", help="what diagnose --json said")
    parser.add_argument("truth", metavar="TRUTH", help="what hide kept back")


def _run(args: argparse.Namespace) -> Answer:
    from ..testbed.sealed.score import score

    grade = score(args.result, args.truth)
    answer = grade.to_json_dict()
    return Answer(answer, _text(grade), saved(args, answer))


def _text(grade: "Score") -> str:
    said = {True: "yes", False: "NO", None: "not asked"}
    lines = [
        f"hidden: {', '.join(grade.hidden) or 'nothing'}",
        f"answer: {grade.verdict}, {', '.join(grade.named) or 'no name'}",
        f"verdict right: {said[grade.verdict_right]}",
        f"first names right: {said[grade.top]}",
        f"truth in the reported set: {said[grade.in_set]}",
        f"more effects than hidden: {'YES' if grade.extra else 'no'}",
    ]
    if grade.set_size is not None:
        lines.append(f"names in a set: {grade.set_size:.3g}")
    if grade.alone:
        lines.append(f"names printed alone right: {said[grade.alone_right]}")
    for name, error in grade.size_error.items():
        lines.append(f"{name}: {error:+.2%} off, interval holds the truth: {said[grade.covered.get(name)]}")
    if grade.gap_closed is not None:
        lines.append(f"gap closed on locked rows, of the mechanism calibrated alone: {grade.gap_closed:.2%}")
    if grade.gap_closed_since_given is not None:
        lines.append(f"the same of the mechanism as it was given: {grade.gap_closed_since_given:.2%}")
    return "\n".join(lines)


COMMAND = Command("grade the answer of a diagnosis against the truth", _add_arguments, _run)
