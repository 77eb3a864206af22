"""The argument parser: argparse with one-line errors and without abbreviated options."""

import argparse
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NoReturn

from ... import __version__
from ...errors import InputError, did_you_mean
from .command import EXIT_CODES, Command
from .terminal import note

if TYPE_CHECKING:
    from ...data.column_map import ColumnMap
    from ...data.measurements import Measurements
    from ...mechanism.mechanism import Mechanism

__all__ = [
    "add_columns",
    "add_conventions",
    "add_model",
    "add_noise",
    "add_path",
    "add_rename",
    "column_map",
    "count",
    "discretization",
    "finite_number",
    "measurements",
    "mechanism",
    "mechanism_of",
    "note_assumed",
    "numbers_by_name",
    "parse",
    "priors_by_name",
    "tension",
    "told",
]


EXAMPLES = {"--prior": "--prior GA 2420 17", "--at-most": "--at-most fx_N 0", "--noise": "--noise x_mm 0.1",
            "--rename": '--rename "F_left [kgf]=lam_l_kgf"'}  # fmt: skip
"""Of options whose words a reader could not guess."""


class _Parser(argparse.ArgumentParser):
    def __init__(self, **options: Any) -> None:
        super().__init__(**options, allow_abbrev=False, epilog=EXIT_CODES)

    def error(self, message: str) -> NoReturn:
        raise InputError(f"{message}{self._wanted(message)}; see {self.prog} --help")

    def _wanted(self, message: str) -> str:
        """Return the names of the words that an option takes, where the complaint is about their number."""
        option = message.removeprefix("argument ").partition(":")[0]
        names = next((action.metavar for action in self._actions if option in action.option_strings), None)
        if ": expected " not in message or not isinstance(names, tuple):
            return ""
        return f", {' '.join(names)}" + (f", such as {EXAMPLES[option]}" if option in EXAMPLES else "")


def parse(words: list[str], commands: Mapping[str, Command]) -> argparse.Namespace:
    """Return the arguments, `command` among them.

    Raises
    ------
    InputError : a word is not what it can be; names it and what is allowed.
    SystemExit : help or version was asked for, and printed.
    """
    top = _Parser(prog="ecm-fast", description="Statics of a tendon-driven soft robot neck.")
    top.add_argument("--version", action="version", version=f"ecm-fast {__version__}")
    parsers = top.add_subparsers(dest="command", metavar="COMMAND", required=True)
    groups, options = {"": parsers}, {}
    for name, command in commands.items():
        group = name.rpartition(" ")[0]
        if group not in groups:
            groups[group] = _add_group(parsers, group, [name for name in commands if name.startswith(f"{group} ")])
        options[name] = _add_command(groups[group], name, command)
    _check_command(words, commands)
    args, unknown = top.parse_known_args([_shielded(word) for word in words])
    if unknown:
        known, word = options[args.command], unknown[0]
        whole = next((option for option in known if word.startswith("--") and option.startswith(word)), word)
        hint = f": say it after {args.command}" if word in known else did_you_mean(whole, known)
        raise InputError(f"unknown argument {word.strip()!r}{hint}; see ecm-fast {args.command} --help")
    return args


def _add_group(parsers: Any, group: str, names: list[str]) -> Any:
    """Add the parser of the first word of commands of two; returns the place of their second words."""
    text = ", ".join(names)
    parser: _Parser = parsers.add_parser(group, help=text, description=text)
    return parser.add_subparsers(metavar=" or ".join(name.rpartition(" ")[2] for name in names), required=True)


def _add_command(parsers: Any, name: str, command: Command) -> list[str]:
    """Add a command's parser; returns its options."""
    word = name.rpartition(" ")[2]
    parser: _Parser = parsers.add_parser(word, help=command.summary, description=command.summary)
    command.add_arguments(parser)
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout and nothing else there")
    parser.add_argument("--out", metavar="DIR", help=command.out)
    parser.add_argument("--plugin", metavar="FILE", help="Python file to run first: it may add effects of your own")
    parser.set_defaults(command=name)
    return [option for action in parser._actions for option in action.option_strings]


def _check_command(words: list[str], commands: Mapping[str, Command]) -> None:
    """Complain about words that are no command; argparse would list them all and guess none."""
    given = [word for word in words if not word.startswith("-")]
    firsts = {name.partition(" ")[0] for name in commands}
    if not given or given[0] in commands or (given[0] in firsts and len(given) == 1):
        return
    name, known = (" ".join(given[:2]), commands) if given[0] in firsts else (given[0], firsts)
    if name not in commands:
        raise InputError(f"no command {name!r}{did_you_mean(name, known)}; allowed are {', '.join(commands)}")


def _shielded(word: str) -> str:
    """Return a negative number with a blank before it: argparse would take -5e1 and -inf for options."""
    try:
        float(word)
    except ValueError:
        return word
    return f" {word}" if word.startswith("-") else word


def finite_number(text: str) -> float:
    """Return a finite number; float() alone also takes nan, inf and 1_000."""
    try:
        value = math.nan if "_" in text else float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text.strip()!r}: allowed is a finite number")
    return value


def add_columns(parser: argparse.ArgumentParser) -> None:
    """Let a command be told what the columns of its measurements mean."""
    parser.add_argument("--columns", metavar="MAP", help="what the columns mean (TOML), as 'ecm-fast import' writes it")
    add_rename(parser)
    add_conventions(parser)


def add_conventions(parser: argparse.ArgumentParser) -> None:
    """Let a command be told in which conventions measurements are taken."""
    parser.add_argument("--zeroed", metavar="AT", help="poses are relative to the pose at rest: of the 'first' row, of "
                        "the first row of each 'session', or without any load, 'unloaded'")  # fmt: skip
    parser.add_argument("--slack", type=finite_number, metavar="N", help="tendon forces whose reading is at most this "
                        "hang slack: they pull nothing, whatever their cell's zero")  # fmt: skip


def add_rename(parser: argparse.ArgumentParser) -> None:
    """Let a command be told what single columns of its measurements mean."""
    parser.add_argument(
        "--rename",
        action="append",
        default=[],
        metavar="COLUMN=NAME",
        help=f"what one column means ({EXAMPLES['--rename']}; =-z_mm turns its sign, =note ignores it); may be given "
        "several times",
    )


def column_map(args: argparse.Namespace) -> "ColumnMap | None":
    """Return what the arguments of `add_columns` say of columns, None where they say nothing."""
    from ...data.column_map import ColumnMap

    if args.columns is None and not args.rename and args.zeroed is None and args.slack is None:
        return None
    return told(ColumnMap({}) if args.columns is None else ColumnMap.from_toml(args.columns), args)


def told(given: "ColumnMap", args: argparse.Namespace) -> "ColumnMap":
    """Return a map with what the arguments of `add_rename` and `add_conventions` say."""
    said = {name: value for name in ("zeroed", "slack") if (value := getattr(args, name)) is not None}
    try:
        return replace(given, **said).with_words(args.rename)
    except InputError as error:
        raise InputError(f"argument --rename: {error}") from None


def add_noise(parser: argparse.ArgumentParser) -> None:
    """Let a command be told what columns mean, and the noise of readings that do not say it."""
    add_columns(parser)
    parser.add_argument(
        "--noise",
        action="append",
        default=[],
        nargs=2,
        metavar=("READING", "SIGMA"),
        help=f"noise of x, z, theta or lam, one standard deviation ({EXAMPLES['--noise']}), of all rows that declare "
        "none; may be given several times",
    )


def measurements(path: str, args: argparse.Namespace) -> "Measurements":
    """Return the measurements of a file, with what `add_columns` and `add_noise` let be told."""
    from ...data.measurements import read_measurements

    data = read_measurements(path, column_map(args))
    if data.ignored:
        note(f"{path}: ignored {', '.join(data.ignored)}")
    return data.with_noise(numbers_by_name("--noise", getattr(args, "noise", [])))


def numbers_by_name(option: str, given: list[list[str]]) -> dict[str, float]:
    """Return the numbers of an option that takes a name and a number and may be given several times."""
    found: dict[str, float] = {}
    for name, number in given:
        try:
            found[name] = finite_number(number)
        except argparse.ArgumentTypeError as error:
            raise InputError(f"argument {option} {name}: {error}") from None
    return found


def priors_by_name(given: list[list[str]]) -> dict[str, tuple[float, float]]:
    """Return value and standard deviation by name from what --prior was given."""
    priors = {}
    for name, *numbers in given:
        try:
            value, std = (finite_number(text) for text in numbers)
        except argparse.ArgumentTypeError as error:
            raise InputError(f"argument --prior {name}: {error}") from None
        if name in priors:
            raise InputError(f"argument --prior {name}: given twice")
        priors[name] = value, std
    return priors


def tension(text: str) -> float:
    """Return a tendon force."""
    allowed = "allowed is a finite number >= 0 [N], a tendon only pulls"
    try:
        value = finite_number(text)
    except argparse.ArgumentTypeError:
        value = -1.0
    if value < 0.0:
        raise argparse.ArgumentTypeError(f"{text.strip()!r}: {allowed}")
    return value


def count(text: str) -> int:
    """Return a whole number >= 0."""
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise argparse.ArgumentTypeError(f"{text.strip()!r}: allowed is a whole number")
    return int(text)


def add_model(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the commands that solve."""
    parser.add_argument("--mechanism", metavar="F", help="mechanism file (TOML); default: the preset 'slender'")
    parser.add_argument(
        "--elements", metavar="N", type=count, help="number of equal elements; default: refined where needed"
    )
    parser.add_argument("--order", metavar="P", type=count, help="of their shape functions; default: the model's")


def add_path(parser: argparse.ArgumentParser) -> None:
    """Let a command that knows no order of loads leave out what depends on one."""
    parser.add_argument(
        "--path",
        choices=("ignore",),
        help="'ignore' leaves out effects of the path (friction, hysteresis, memory, creep, drift), which depend on "
        "the loads before; else a mechanism that has them is refused. 'predict' takes them in the order of its rows",
    )


def discretization(args: argparse.Namespace) -> dict[str, Any]:
    """Return what the arguments say of the discretization, as keywords; the rest is the model's own default."""
    return {name: getattr(args, name) for name in ("elements", "order") if getattr(args, name) is not None}


def mechanism(args: argparse.Namespace) -> "Mechanism":
    """Return the mechanism that the arguments name."""
    return mechanism_of(args.mechanism)


def mechanism_of(path: str | None) -> "Mechanism":
    """Return the mechanism of a file, or the preset, and say what the file leaves to that."""
    from ...mechanism.mechanism import Mechanism

    if path is None:
        return Mechanism.preset()
    found = Mechanism.from_toml(path)
    note_assumed(found, path)
    return found


def note_assumed(mechanism: "Mechanism", path: str) -> None:
    """Say which values a mechanism's file leaves to the preset, where an answer can depend on them."""
    if mechanism.assumed:
        values = mechanism.values()
        taken = ", ".join(f"{name} = {values[name]}" for name in mechanism.assumed)
        note(f"{path}: not given, so as in the preset 'slender': {taken}; preset = \"slender\" in the file "
             "means them")  # fmt: skip
