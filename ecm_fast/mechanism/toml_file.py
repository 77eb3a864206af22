"""Mechanism files in TOML, in SI units and radians, with every key optional."""

import os
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ..errors import InputError, did_you_mean, key_shown, shown, why
from ..files import read_whole, write_whole
from .body import KINDS
from .body_tables import read_tables, write_tables
from .catalogue import CATALOGUE
from .parameters import PARAMETERS
from .quantity import Quantity
from .sections import PRESETS, SECTIONS

__all__ = ["ROBOTS", "read_toml", "read_values", "robot_file", "template", "write_values"]

ROBOTS = {path.stem: path for path in sorted((Path(__file__).parent / "robots").glob("*.toml"))}
"""Files of robots to start from, by name."""


Parts = Mapping[str, Sequence[Any]]
EMPTY: Parts = MappingProxyType({})
"""Segments, tendons and markers by the name of their tables."""


def read_toml(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return what a TOML file holds.

    Raises
    ------
    InputError : the file cannot be read, or is not TOML; names it.
    """
    try:
        return tomllib.loads(read_whole(path).decode("utf-8-sig"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({why(error)})") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not a TOML file ({str(error).splitlines()[0]})") from None


def read_values(path: str | os.PathLike[str]) -> tuple[str, dict[str, Any], Parts]:
    """Return the preset that a mechanism file names, "" where it names none, its values by full names, and its parts.

    Raises
    ------
    InputError : the file cannot be read, is not TOML, or holds a key or value that cannot be; one line with
        file, key, value and what is allowed.
    """
    content = read_toml(path)
    try:
        return _values(content)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _values(content: dict[str, Any]) -> tuple[str, dict[str, Any], Parts]:
    tables = [*SECTIONS, "effects", *KINDS]
    parts = {kind: read_tables(kind, content[kind]) for kind in KINDS if kind in content}
    _check_sections(content, parts)
    for key, value in content.items():
        if key == "preset" or key in KINDS:
            continue
        if key not in tables:
            raise InputError(f"unknown key {shown(key)}{did_you_mean(key, ['preset', *tables])}; allowed are "
                             f"preset, {', '.join(tables)}")  # fmt: skip
        if not isinstance(value, dict):
            raise InputError(f"{key} = {shown(value)}: allowed is a table, written [{key}]")
    return _preset(content), {f"{section}.{name}": value for section, name, value in _entries(content)}, parts


def _check_sections(content: Mapping[str, Any], parts: Parts) -> None:
    """Refuse sections beside the parts that stand in their place."""
    if ("segment" in parts or "tendon" in parts) and "tendons" in content:
        raise InputError("[tendons], the pair of a neck, beside [[segment]] or [[tendon]]: allowed is one of them")
    beam = content.get("beam", {})
    if parts.get("segment") and isinstance(beam, dict) and set(beam) - {"axial_law"}:
        raise InputError(f"beam.{key_shown(min(set(beam) - {'axial_law'}))} beside [[segment]]: allowed of [beam] is "
                         "axial_law alone")  # fmt: skip


def _preset(content: Mapping[str, Any]) -> str:
    name = content.get("preset", "")
    if not isinstance(name, str) or (not name and "preset" in content):
        raise InputError(f"preset = {shown(name)}: allowed is {' or '.join(map(repr, PRESETS))}")
    return name


def _entries(content: Mapping[str, Any]) -> Iterator[tuple[str, str, Any]]:
    """Yield (section, name, value) of every entry given, sub-tables of effects flattened."""
    for section, cls in SECTIONS.items():
        names = list(cls.__dataclass_fields__)
        for name, value in content.get(section, {}).items():
            if name not in names:
                raise InputError(f"unknown key {section}.{key_shown(name)}{did_you_mean(name, names)}; allowed are "
                                 f"{', '.join(names)}")  # fmt: skip
            yield section, name, value
    for name, value in content.get("effects", {}).items():
        if name not in CATALOGUE:
            raise InputError(f"unknown effect effects.{key_shown(name)}{did_you_mean(name, CATALOGUE)}; "
                             "the command 'effects' lists them")  # fmt: skip
        if not isinstance(value, dict):
            yield "effects", CATALOGUE[name].size.name, value
            continue
        allowed = {entry.name.removeprefix(f"{name}."): entry.name for entry in CATALOGUE[name]}
        for part, number in value.items():
            if part not in allowed:
                raise InputError(f"unknown key effects.{name}.{key_shown(part)}{did_you_mean(part, allowed)}; "
                                 f"allowed are {', '.join(allowed)}")  # fmt: skip
            yield "effects", allowed[part], number


def write_values(
    values: Mapping[str, float | str], path: str | os.PathLike[str], remarks: Iterable[str] = (), parts: Parts = EMPTY
) -> None:
    """Write every value of a mechanism, by its full name, with its unit and meaning; reading it gives the same values.

    remarks : what else a reader should know, for comments at the top
    parts : segments, tendons and markers
    """
    text = _text(values, {entry.key: entry for entry in PARAMETERS}, with_source=False) + _part_text(parts)
    title, rest = text.split("\n", 1)
    write_whole(path, "\n".join([title, *(f"# {_printable(remark)}" for remark in remarks), rest]))


def robot_file(name: str) -> str:
    """Return the commented mechanism file of a robot with tendons along its body, one of `ROBOTS`."""
    if name not in ROBOTS:
        raise InputError(f"robot = {shown(name)}: allowed is {' or '.join(map(repr, ROBOTS))}"
                         f"{did_you_mean(str(name), ROBOTS)}")  # fmt: skip
    return ROBOTS[name].read_text(encoding="utf-8")


def template(preset: str = "slender") -> str:
    """Return a mechanism file with a preset's values, commented with unit, meaning and where each comes from."""
    if preset not in PRESETS:
        raise InputError(f"preset = {shown(preset)}: allowed is {' or '.join(map(repr, PRESETS))}")
    entries = {entry.key: entry for entry in PARAMETERS} | PRESETS[preset]
    defaults = {f"{name}.{item.name}": item.default for name, section in SECTIONS.items() for item in fields(section)}
    values: dict[str, Any] = defaults | {key: entry.default for key, entry in PRESETS[preset].items()}
    return _text(values, entries, with_source=True)


def _text(values: Mapping[str, float | str], entries: Mapping[str, Quantity], *, with_source: bool) -> str:
    lines = ["# A mechanism of ecm-fast: SI units, angles in radians. Every key is optional."]
    for section, cls in SECTIONS.items():
        names = [name for name in cls.__dataclass_fields__ if f"{section}.{name}" in values]
        lines += ["", f"[{section}]"] if names else []
        for name in names:
            entry, value = entries[f"{section}.{name}"], values[f"{section}.{name}"]
            source = f" ({entry.status}: {entry.source})" if with_source else ""
            lines.append(f"{name} = {_literal(value)}  # {_unit(entry)}{entry.meaning}{source}")
    lines += ["", "[effects]  # absent means 0; below 0 is the other way round than said"]
    for key, value in values.items():
        if key.startswith("effects."):
            entry = entries[key]
            lines.append(f"{entry.name} = {_literal(value)}  # {_unit(entry)}{entry.meaning}")
    return "\n".join(lines) + "\n"


def _part_text(parts: Parts) -> str:
    lines = []
    for kind, several in parts.items():
        for table in write_tables(kind, several):
            lines += ["", f"[[{kind}]]", *(f"{key} = {_toml(value)}" for key, value in table.items())]
    return "".join(f"{line}\n" for line in lines)


def _toml(value: object) -> str:
    return f"[{', '.join(map(_toml, value))}]" if isinstance(value, list) else _literal(value)


def _printable(text: str) -> str:
    return "".join(letter if letter.isprintable() else " " for letter in text)


def _unit(entry: Quantity) -> str:
    return "" if entry.unit == "-" else f"[{entry.unit}] "


def _literal(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else repr(value)
