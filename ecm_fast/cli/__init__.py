"""The command line: arguments in, one call of the library, one answer out. One file a command.

The answer goes to stdout, with ``--json`` as exactly one JSON object; all else (notes, progress, errors) goes to
stderr. Nothing but the standard library is imported before a command runs: help, version and complaints about
arguments must not wait for the compiler.
"""

import json
import os
import sys
import traceback
from collections.abc import Sequence

from ..errors import InputError, NotConverged
from ..files import inputs_kept
from . import (
    bench,
    diagnose,
    effects,
    elements,
    identify,
    next_loads,
    polynomial,
    predict,
    reproduce,
    sealed,
    solve,
    sweep,
    view,
    warmup,
)
from .frame.arguments import parse
from .frame.command import BAD_INPUT, DONE, INTERRUPTED, NOT_CONVERGED, UNEXPECTED
from .frame.interrupt import interrupts_kept
from .frame.terminal import note, write
from .start import import_file, init

__all__ = ["COMMANDS", "main"]

COMMANDS = {
    "solve": solve.COMMAND,
    "predict": predict.COMMAND,
    "identify": identify.COMMAND,
    "polynomial fit": polynomial.FIT,
    "polynomial eval": polynomial.EVAL,
    "elements": elements.COMMAND,
    "plan": diagnose.PLAN,
    "diagnose": diagnose.DIAGNOSE,
    "next": next_loads.COMMAND,
    "sweep": sweep.COMMAND,
    "effects": effects.COMMAND,
    "hide": sealed.HIDE,
    "score": sealed.SCORE,
    "init": init.COMMAND,
    "import": import_file.COMMAND,
    "view": view.COMMAND,
    "reproduce": reproduce.COMMAND,
    "bench": bench.COMMAND,
    "warmup": warmup.COMMAND,
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; never raises."""
    # matrices are small here: threads of the linear algebra library would only fight over the cores
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        with inputs_kept(), interrupts_kept():
            return _run(list(sys.argv[1:] if argv is None else argv))
    except InputError as error:
        return _failed(str(error), BAD_INPUT)
    except NotConverged as error:
        return _failed(str(error), NOT_CONVERGED)
    except KeyboardInterrupt:
        return _failed("interrupted", INTERRUPTED)
    except Exception as error:
        if os.environ.get("ECM_FAST_TRACEBACK"):
            write(sys.stderr, traceback.format_exc())
        hint = "ECM_FAST_TRACEBACK=1 in the environment shows where"
        return _failed(f"unexpected {type(error).__name__}: {error} ({hint})", UNEXPECTED)


def _as_json(answer: object) -> str:
    from ..files import plain

    return json.dumps(plain(answer), allow_nan=False)


def _check_environment() -> None:
    """Complain about settings of numba under which no kernel runs as it should."""
    jit, threads = (os.environ.get(f"NUMBA_{name}", "").strip() for name in ("DISABLE_JIT", "NUM_THREADS"))
    if jit not in ("", "0"):
        raise InputError(f"NUMBA_DISABLE_JIT={jit} in the environment: the kernels run compiled alone; unset it")
    if threads and not (threads.isdecimal() and int(threads) > 0):
        raise InputError(f"NUMBA_NUM_THREADS={threads} in the environment: allowed is 1 or more; unset it")


def _run(words: list[str]) -> int:
    try:
        args = parse(words, COMMANDS)
    except SystemExit:  # argparse has printed the help or the version
        write(sys.stdout, "")
        return DONE
    _check_environment()
    if args.plugin:
        from ..models.user_effects import load_effects

        load_effects(args.plugin)
    answer = COMMANDS[args.command].run(args)
    for line in answer.notes:
        note(line)
    text = _as_json(answer.json) if args.json else answer.text
    if text:
        write(sys.stdout, f"{text}\n")
    for line in answer.after() if answer.after else ():
        note(line)
    return answer.code


def _failed(text: str, code: int) -> int:
    note(text)
    return code
