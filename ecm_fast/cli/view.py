"""``ecm-fast view``: an interactive page of the neck, served on this machine."""

import argparse
import signal
from functools import partial
from typing import Any

from .frame.arguments import add_columns, count, measurements, mechanism
from .frame.command import Answer, Command
from .frame.terminal import note

__all__ = ["COMMAND"]


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--mechanism", metavar="F", help="mechanism file (TOML); default: the preset 'slender'")
    parser.add_argument("--data", metavar="DATA", help="measurements whose poses are laid over the picture")
    add_columns(parser)
    parser.add_argument("--port", metavar="N", type=count, default=0, help="of 127.0.0.1; default: a free one")
    parser.add_argument("--no-browser", action="store_true", help="open no browser; the address is on stderr")


def _run(args: argparse.Namespace) -> Answer:
    from ..pages.live import Page, Scene

    data = None if args.data is None else measurements(args.data, args)
    make = partial(Scene, mechanism(args), data)
    make().frame({"id": 0})  # compiles what is needed before anybody waits for it
    with Page(make, args.port) as page:
        note(f"{page.url} (Ctrl-C ends)")
        before = {number: signal.signal(number, _interrupt) for number in (signal.SIGINT, signal.SIGTERM)}
        if not args.no_browser:
            import webbrowser

            webbrowser.open(page.url)
        try:
            page.serve()
        except KeyboardInterrupt:
            pass
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
    answer: dict[str, Any] = {"url": page.url, "frames": page.frames}
    return Answer(answer, f"{page.frames} frames shown")


def _interrupt(*_: object) -> None:
    raise KeyboardInterrupt


COMMAND = Command("the neck on a live page: drag its head, move forces, parameters and effects", _add_arguments, _run)
