"""``ecm-fast effects``: the catalogue."""

import argparse
from collections.abc import Mapping
from typing import Any

from ..effects import CATALOGUE, Effect
from ._answer import Answer, Command, saved

__all__ = ["COMMAND"]


def _run(args: argparse.Namespace) -> Answer:
    entries = [_entry(effect) for effect in CATALOGUE.values()]
    answer = {"effects": entries}
    return Answer(answer, "\n".join(map(_text, entries)), saved(args, answer))


def _entry(effect: Effect) -> dict[str, Any]:
    columns = ("name", "unit", "meaning", "default", "typical", "lower", "upper")
    return {
        **{name: getattr(effect.size, name) for name in ("meaning", "unit", "typical", "lower", "upper")},
        **{name: getattr(effect, name) for name in ("name", "law", "family", "mirror", "enters", "needs")},
        "parameters": [{name: getattr(entry, name) for name in columns} for entry in effect],
    }


def _text(entry: Mapping[str, Any]) -> str:
    needs = f"; needs {', '.join(entry['needs'])}" if entry["needs"] else ""
    return (
        f"{entry['name']}: {entry['meaning']}\n"
        f"    {entry['law']}\n"
        f"    typical {entry['typical']:g} {entry['unit']}, allowed {entry['lower']:g} to {entry['upper']:g}\n"
        f"    enters {entry['enters']}; family {entry['family']}; mirror {entry['mirror']}{needs}"
    )


COMMAND = Command("the catalogue of physical effects", lambda parser: None, _run)
