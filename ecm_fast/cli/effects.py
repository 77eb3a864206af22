"""``ecm-fast effects``: the catalogue of effects, and their size on a mechanism."""

import argparse
from collections.abc import Mapping
from typing import Any

from ..mechanism.catalogue import CATALOGUE, Effect
from .frame.arguments import add_columns, measurements, mechanism
from .frame.command import Answer, Command, folder, saved

__all__ = ["COMMAND"]


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "data",
        nargs="?",
        metavar="DATA",
        help="measurements whose loads decide what looks alike; default: tendon forces",
    )
    parser.add_argument("--mechanism", metavar="F", help="mechanism file (TOML); default: the preset 'slender'")
    add_columns(parser)


def _run(args: argparse.Namespace) -> Answer:
    entries = [_entry(effect) for effect in CATALOGUE.values()]
    notes: tuple[str, ...] = ()
    if args.out is not None or args.data is not None or args.mechanism is not None:
        notes = _shown(args, entries)
    answer = {"effects": entries}
    return Answer(answer, "\n".join(map(_text, entries)), (*notes, *saved(args, answer)))


def _shown(args: argparse.Namespace, entries: list[dict[str, Any]]) -> tuple[str, ...]:
    """Add to the entries how they show on a mechanism; write the page where a folder is named."""
    from ..pages.catalogue import look_alikes, write_catalogue
    from ..pages.page import require
    from ..studies.diagnosis import plan
    from ..testbed import tendon_test

    neck = mechanism(args)
    data = None if args.data is None else measurements(args.data, args)
    notes: tuple[str, ...] = ()
    if args.out is not None:
        require()
    found = plan(neck, tendon_test(grid=9) if data is None else data)
    if args.out is not None:
        notes = (f"wrote {write_catalogue(neck, folder(args.out), found, args.data or '')}",)
    alike, sights = look_alikes(found), {sight.name: sight for sight in found.sights}
    for entry in entries:
        sight = sights[entry["name"]]
        entry |= {
            "visible": sight.visible,
            "sigmas": sight.sigmas,
            "smallest": sight.smallest,
            "look_alikes": [{"name": name, "cosine": cosine} for name, cosine in alike[entry["name"]]],
        }
    return notes


def _entry(effect: Effect) -> dict[str, Any]:
    columns = ("name", "unit", "meaning", "default", "typical", "lower", "upper")
    return {
        **{name: getattr(effect.size, name) for name in ("meaning", "unit", "typical", "tolerance", "lower", "upper")},
        **{name: getattr(effect, name) for name in ("name", "law", "group", "mirror", "enters", "needs")},
        "parameters": [{name: getattr(entry, name) for name in columns} for entry in effect],
    }


def _text(entry: Mapping[str, Any]) -> str:
    needs = f"; needs {', '.join(entry['needs'])}" if entry["needs"] else ""
    shown = ""
    if "visible" in entry:
        others = ", ".join(f"{other['name']} {other['cosine']:.2f}" for other in entry["look_alikes"])
        shown = f"\n    {entry['visible']}, typical size {entry['sigmas']:.1f} sigma; look-alikes: {others or 'none'}"
    drawn = f", {entry['tolerance']:g} within the tolerances of a build" if entry["tolerance"] else ""
    return (
        f"{entry['name']}: {entry['meaning']}\n"
        f"    {entry['law']}\n"
        f"    typical {entry['typical']:g} {entry['unit']}{drawn}, allowed {entry['lower']:g} to {entry['upper']:g}\n"
        f"    enters {entry['enters']}; group {entry['group']}; mirror {entry['mirror']}{needs}{shown}"
    )


COMMAND = Command("the catalogue of physical effects, and how each shows on a mechanism", _add_arguments, _run)
