"""The types shared by all commands: a command and its answer."""

import argparse
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...errors import InputError, why

__all__ = [
    "BAD_INPUT",
    "DONE",
    "EXIT_CODES",
    "INTERRUPTED",
    "IN_OUT",
    "NOT_CONVERGED",
    "UNEXPECTED",
    "Answer",
    "Command",
    "folder",
    "outputs",
    "saved",
]

# exit codes; the last as shells say it of SIGINT
DONE, UNEXPECTED, BAD_INPUT, NOT_CONVERGED, INTERRUPTED = 0, 1, 2, 3, 130
EXIT_CODES = "exit codes: 0 done, 1 unexpected, 2 bad input, 3 a solve did not converge, 130 interrupted"


@dataclass(frozen=True)
class Answer:
    """Outcome of a command.

    Attributes
    ----------
    json : for ``--json``; what is not finite becomes null
    text : the same for a reader: plain ASCII, with units
    notes : lines for stderr
    code : the exit code
    after : what takes its time and may fail once all that is out; returns further notes
    """

    json: Mapping[str, Any]
    text: str
    notes: tuple[str, ...] = ()
    code: int = DONE
    after: Callable[[], tuple[str, ...]] | None = None


IN_OUT = "folder for files; made where it is missing; default out. Files of the same name in it are replaced"
"""Help on ``--out`` of commands that write in any case."""


@dataclass(frozen=True)
class Command:
    """One command: a line of help, its arguments beyond the common ones, what it does with them, help on --out."""

    summary: str
    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], Answer]
    out: str = "folder for files; made where it is missing"


def folder(path: str) -> Path:
    """Return the folder `path`, made where it is missing.

    Raises
    ------
    InputError : it cannot be made; names it and the system's reason.
    """
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise InputError(f"--out {path}: cannot be made ({why(error)})") from None
    return Path(path)


def outputs(*paths: Path) -> None:
    """See, before anything is computed, that no output of a command would replace one of its inputs or another output.

    Raises
    ------
    InputError : one would; names it.
    """
    from ...files import refuse_input

    for i, path in enumerate(paths):
        refuse_input(path)
        if path.resolve() in [other.resolve() for other in paths[:i]]:
            raise InputError(f"{path}: two outputs of this command would go there; give one of them another name")


def saved(args: argparse.Namespace, answer: Mapping[str, Any]) -> tuple[str, ...]:
    """Write the answer to ``DIR/COMMAND.json`` where ``--out DIR`` asks for it; returns the note that says so.

    A command of two words has ``_`` between them there.
    """
    from ...files import plain, write_whole

    if args.out is None:
        return ()
    path = folder(args.out) / f"{args.command.replace(' ', '_')}.json"
    write_whole(path, json.dumps(plain(answer), allow_nan=False, indent=1) + "\n")
    return (f"wrote {path}",)
