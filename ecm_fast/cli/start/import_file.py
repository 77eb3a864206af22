"""``ecm-fast import``: a map of the columns of measurement files, proposed from their names and numbers."""

import argparse
import os
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...errors import InputError
from ..frame.arguments import add_conventions, add_rename
from ..frame.arguments import told as told_by
from ..frame.command import BAD_INPUT, Answer, Command, folder
from ..frame.terminal import write

if TYPE_CHECKING:
    from ...data.column_map import ColumnMap
    from ...data.proposal import Guess

__all__ = ["COMMAND"]


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="+", metavar="FILE", help="measurements, all with the same columns")
    add_rename(parser)
    add_conventions(parser)
    parser.add_argument("--map", default="map.toml", metavar="MAP", help="file to write; default map.toml")
    parser.add_argument("--decimal", default="", choices=[",", "."], help="mark of decimals, where it is not clear")
    parser.add_argument("--header", type=int, default=0, metavar="N", help="line that names the columns")
    parser.add_argument("--sheet", default="", metavar="NAME", help="sheet of a workbook")
    parser.add_argument("--force", action="store_true", help="overwrite an existing map")


def _run(args: argparse.Namespace) -> Answer:
    from ...data.column_map import ColumnMap
    from ...data.grid import Layout
    from ...data.measurements import read_measurements
    from ...data.proposal import propose
    from ...data.readers import files_of, is_pattern, read_table

    path = Path(args.map) if args.out is None else folder(args.out) / args.map
    if os.path.lexists(path) and not args.force:
        raise InputError(f"{path}: exists; --force overwrites it")
    layout = Layout(args.decimal, args.header, args.sheet)
    files = [each for file in args.files for each in (files_of(file) if is_pattern(file) else [file])]
    try:
        table = read_table(files[0], layout, bare=True)
        told = told_by(ColumnMap({}, layout), args)
        guesses = propose(table, told)
    except InputError as error:
        raise InputError(f"{files[0]}: {error}") from None
    open_ = [one for one in guesses if not one.certain]
    if open_ and (args.json or sys.stdin is None or not sys.stdin.isatty()):
        return Answer({"map": None, "columns": _columns(guesses, told), "files": []}, "\n".join(_lines(guesses, told)),
                      (f"{files[0]}: {_refusal(open_, len(guesses))}",), BAD_INPUT)  # fmt: skip
    told = _answered(guesses, told)
    read = [(file, read_measurements(file, told)) for file in files]
    told.to_toml(path, f"What the columns of {Path(files[0]).name} mean.", {one.name: one.because for one in guesses})
    counted = [{"file": file, "rows": data.n, "poses": int(data.measured.any(axis=1).sum())} for file, data in read]
    rows = [f"{one['file']}: {one['rows']} rows, {one['poses']} with a pose" for one in counted]
    follows = f"next: ecm-fast predict {shlex.quote(files[0])} --columns {shlex.quote(str(path))}"
    return Answer({"map": path, "columns": _columns(guesses, told), "files": counted},
                  "\n".join([*_lines(guesses, told), *rows, follows]), (f"wrote {path}",))  # fmt: skip


def _columns(guesses: Sequence["Guess"], told: "ColumnMap") -> list[dict[str, Any]]:
    return [{"name": one.name, "told": told.columns.get(one.name, one.told), "certain": one.certain,
             "doubt": one.doubt, "because": one.because} for one in guesses]  # fmt: skip


def _refusal(guesses: Sequence["Guess"], of: int) -> str:
    """Return what is not certain in one line, with the words that say it."""
    at_rest = any("--zeroed" in one.doubt for one in guesses)
    rest = "; poses relative to the pose at rest are told by --zeroed first, session or unloaded" * at_rest
    words = [f"{one.name}={one.told or '?'}" for one in guesses]
    return (f"{len(guesses)} of {of} columns are not certain, nothing is written; where a proposal is right repeat it: "
            f"{' '.join(f'--rename {shlex.quote(word)}' for word in words)}; =note ignores a column{rest}")  # fmt: skip


def _answered(guesses: Sequence["Guess"], told: "ColumnMap") -> "ColumnMap":
    """Return the map of what is certain, what is told and what is answered."""
    answers = {one.name: one.told if one.certain else _asked(one, told) for one in guesses}
    return told.with_words(f"{name}={meaning}" for name, meaning in answers.items())


def _asked(guess: "Guess", told: "ColumnMap") -> str:
    """Return what the user answers; an empty line takes the proposal."""
    while True:
        default = f" [{guess.told}]" if guess.told else ""
        write(sys.stderr, f"{guess.name}: {guess.doubt}?\n  name, or note to ignore it{default}: ")
        line = sys.stdin.readline()
        if not line:
            raise InputError(f"column {guess.name!r}: not answered; nothing is written")
        answer = line.strip() or guess.told
        try:
            told.with_words([f"{guess.name}={answer}"])
            return answer
        except InputError as error:
            write(sys.stderr, f"  {error}\n")


def _lines(guesses: Sequence["Guess"], told: "ColumnMap") -> list[str]:
    """Return the proposals in words, one a line."""
    wide = max(len(one.name) for one in guesses)
    meant = [told.columns.get(one.name, one.told) or "?" for one in guesses]
    long = max(map(len, meant))
    return [f"{one.name:<{wide}}  {name:<{long}}  {'certain' if one.certain else 'asked: ' + one.doubt} ({one.because})"
            for one, name in zip(guesses, meant, strict=True)]  # fmt: skip


COMMAND = Command("propose what the columns of a measurement file mean, and write it down", _add_arguments, _run)
