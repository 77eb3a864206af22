"""Meanings of a file's columns, told beside it: a small TOML file, or words such as ``"F_left [N]=lam_l_N"``."""

import math
import os
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, Self

from ..errors import InputError, did_you_mean, shown, why
from ..files import read_whole, write_whole
from .columns import column_of, foreign, is_known, is_note, unit_in
from .grid import Layout

__all__ = ["NOTE", "REST", "ZEROED", "ColumnMap", "Told", "told_as"]

NOTE = "note"
"""Name of a column that is ignored."""
REST = "*"
"""Stands for every column of a file that the map does not name."""
_TOLD = re.compile(r"(?:(?P<factor>[+-]?[0-9.]+(?:[eE][+-]?[0-9]+)?)\s*\*|(?P<minus>-))?\s*(?P<name>.+)")
ZEROED = ("first", "session", "unloaded")
"""Poses that are zero by convention: of the first row, of the first row of each session, without any load."""
_LAYOUT = ("decimal", "header", "sheet")
_KEYS = ("columns", *_LAYOUT, "zeroed", "slack")
_KINDS: Mapping[str, tuple[type | tuple[type, ...], str]] = {
    "columns": (dict, "a table"),
    "header": (int, "a line number"),
    "slack": ((int, float), "a number of newtons"),
}


class Told(NamedTuple):
    """A column's name with its unit, and the factor before it."""

    name: str
    scale: float = 1.0


@dataclass(frozen=True)
class ColumnMap:
    """The columns of a file by their names there.

    Attributes
    ----------
    columns : name in the file -> name as in `COLUMNS` with its unit, with a sign or a factor before it where the file's
        numbers need one: ``-z_mm``, ``12.5*lam_l_N``; ``note`` for a column that is ignored. A column without a name
        goes by its place, from 1 on, and ``*`` stands for all that are not named.
    layout : what is told of the file's layout
    zeroed : "first", "session" or "unloaded" where poses are relative to that of the first row, of the first row of
        each session, or of the neck without any load; empty where they are relative to the clamp
    slack : force [N] up to which the reading of a cell, either side of zero, is that of a slack tendon, which pulls
        nothing whatever its cell's zero is; None where small readings are readings
    """

    columns: Mapping[str, str]
    layout: Layout = field(default_factory=Layout)
    zeroed: str = ""
    slack: float | None = None

    def __post_init__(self) -> None:
        for name, told in self.columns.items():
            if name == REST and told != NOTE:
                raise InputError(f"{REST} = {shown(told)}: allowed is {NOTE!r}, to have all other columns ignored")
            try:
                told_as(told)
            except InputError as error:
                raise InputError(f"{shown(name)} = {shown(told)}: {error}") from None
        if self.layout.decimal not in ("", ".", ","):
            raise InputError(f"decimal = {shown(self.layout.decimal)}: allowed is ',' or '.'")
        if self.zeroed not in ("", *ZEROED):
            raise InputError(f"zeroed = {shown(self.zeroed)}: allowed is {', '.join(ZEROED)}")
        if self.slack is not None and not 0.0 <= self.slack < math.inf:
            raise InputError(f"slack = {shown(self.slack)}: allowed is a number of newtons >= 0")

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> Self:
        """Read a map.

        Raises
        ------
        InputError : it cannot be read, or a key or name cannot be; names the file.
        """
        try:
            return cls.from_dict(tomllib.loads(read_whole(path).decode("utf-8-sig")))
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
        except OSError as error:
            raise InputError(f"{path}: cannot be read ({why(error)})") from None
        except (ValueError, RecursionError) as error:
            raise InputError(f"{path}: not a TOML file ({str(error).splitlines()[0]})") from None

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> Self:
        """Return the map that `to_dict` gave, or that a file holds."""
        for key, value in content.items():
            kind, allowed = _KINDS.get(key, (str, "text"))
            if key not in _KEYS:
                raise InputError(f"unknown key {shown(key)}{did_you_mean(key, _KEYS)}; allowed are {', '.join(_KEYS)}")
            if not isinstance(value, kind) or isinstance(value, bool):
                raise InputError(f"{key} = {shown(value)}: allowed is {allowed}")
        columns = content.get("columns", {})
        for name, told in columns.items():
            if not isinstance(told, str):
                raise InputError(f'columns.{name} = {shown(told)}: allowed is text, such as "lam_l_N"')
        layout = Layout(**{key: content[key] for key in _LAYOUT if key in content})
        return cls(columns, layout, content.get("zeroed", ""), content.get("slack"))

    @classmethod
    def of(cls, given: "ColumnMap | Mapping[str, str] | str | os.PathLike[str] | None") -> "ColumnMap | None":
        """Return the map that is given as such, as columns, or as the path of its file; None for None."""
        if given is None or isinstance(given, ColumnMap):
            return given
        return cls(given) if isinstance(given, Mapping) else cls.from_toml(given)

    def with_words(self, words: Iterable[str]) -> Self:
        """Return the map with columns told as ``"F_left [N]=lam_l_N"``, in the place of what it says of them."""
        told = dict[str, str]()
        for word in words:
            name, equals, meaning = word.rpartition("=")
            if not equals or not name.strip():
                raise InputError(f'{shown(word)}: allowed is COLUMN=NAME, such as "F_left [N]=lam_l_N"')
            told[name.strip()] = meaning.strip()
        return replace(self, columns={**self.columns, **told})

    def to_dict(self) -> dict[str, Any]:
        """Return the map as plain values."""
        told: dict[str, Any] = {key: value for key in _LAYOUT if (value := getattr(self.layout, key))}
        told |= {"zeroed": self.zeroed} if self.zeroed else {}
        told |= {} if self.slack is None else {"slack": self.slack}
        return {**told, "columns": dict(self.columns)}

    def to_toml(
        self, path: str | os.PathLike[str], comment: str = "", reasons: Mapping[str, str] | None = None
    ) -> Path:
        """Write the map; `reasons` stand behind the columns, and `comment` above all."""
        lines = [f"# {line}".rstrip() for line in comment.splitlines()]
        lines += [f"{key} = {_quoted(value)}" for key, value in self.to_dict().items() if key != "columns"]
        lines += ["", "[columns]"]
        for name, told in self.columns.items():
            reason = (reasons or {}).get(name, "")
            lines.append(f"{_quoted(name)} = {_quoted(told)}" + (f"  # {' '.join(reason.split())}" if reason else ""))
        return write_whole(path, "\n".join(lines) + "\n")

    def read(self, names: Sequence[str]) -> tuple[list[Told], list[str]]:
        """Return what each column of a file is, in its order, and the names of those that are ignored unsaid.

        Raises
        ------
        InputError : the map names a column that the file has not, or with another unit than its name there, or leaves
            out one that has a unit of ours.
        """
        named = [name or str(i + 1) for i, name in enumerate(names)]
        absent = [name for name, told in self.columns.items() if name not in named and name != REST and told != NOTE]
        if absent:
            raise InputError(f"has no column {shown(absent[0])}{did_you_mean(absent[0], named)}, which the map names; "
                             f"it has {', '.join(map(shown, named))}")  # fmt: skip
        told, ignored = list[Told](), list[str]()
        for name in named:
            meant = self.columns.get(name, name if is_known(name) or is_note(name) else "")
            if not meant:
                hint = foreign(name)
                if REST not in self.columns and (hint or unit_in(name)):
                    raise InputError(f"column {shown(name)} is not in the map{hint}; add it, or \"*\" = \"note\" to "
                                     "have all others ignored")  # fmt: skip
                meant = NOTE
                ignored += [name] * (REST not in self.columns)
            own = told_as(meant)
            unit = "" if is_note(own.name) else column_of(own.name)[1]
            if (written := unit_in(name)) and unit and unit != written:
                raise InputError(f"column {shown(name)} has the unit {written} in its name, and {unit} is told; where "
                                 f"the name is wrong rename it, or tell {written} with a factor")  # fmt: skip
            told.append(own)
        return told, ignored


def told_as(text: str) -> Told:
    """Return the name and the factor in what is told of a column."""
    found = _TOLD.fullmatch(text.strip())
    if found is None:
        raise InputError('says nothing; "note" has a column ignored')
    name = found["name"].strip()
    try:
        scale = -1.0 if found["minus"] else float(found["factor"] or 1.0)
    except ValueError:
        raise InputError(f"{found['factor']} is no number") from None
    if not is_note(name) and not column_of(name)[0].units and scale != 1.0:
        raise InputError("text takes no sign and no factor")
    return Told(name, scale)


def _quoted(value: str | float) -> str:
    if isinstance(value, (int, float)):
        return str(value)
    body = value.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(letter if letter.isprintable() else f"\\u{ord(letter):04x}" for letter in body) + '"'
