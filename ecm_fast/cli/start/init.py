"""``ecm-fast init``: a mechanism file to start from."""

import argparse
import os
from pathlib import Path

from ...errors import InputError
from ..frame.command import Answer, Command, folder

__all__ = ["COMMAND"]


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", nargs="?", default="mechanism.toml", metavar="FILE", help="default mechanism.toml")
    parser.add_argument("--preset", default="slender", metavar="NAME", help="'slender', the default, or 'paper'")
    parser.add_argument("--robot", metavar="NAME", help="a robot with tendons along its body instead: "
                        "'tentacle', 'segments' or 'finger'")  # fmt: skip
    parser.add_argument("--force", action="store_true", help="overwrite an existing file")


def _run(args: argparse.Namespace) -> Answer:
    from ...mechanism.mechanism import Mechanism

    Mechanism.preset(args.preset)  # complains about the name before the next import brings NumPy
    from ...files import write_whole
    from ...mechanism.toml_file import robot_file, template

    path = Path(args.file) if args.out is None else folder(args.out) / args.file
    if os.path.lexists(path) and not args.force:
        raise InputError(f"{path}: exists; --force overwrites it")
    write_whole(path, template(args.preset) if args.robot is None else robot_file(args.robot))
    kind = {"preset": args.preset} if args.robot is None else {"robot": args.robot}
    return Answer({"mechanism": path, **kind}, "", (f"wrote {path}",))


COMMAND = Command("write a commented mechanism file to start from", _add_arguments, _run)
