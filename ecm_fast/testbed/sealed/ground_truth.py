"""The ground truth of sealed measurements, kept apart from them."""

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

from ...errors import InputError, shown, why
from ...files import read_whole, write_whole

__all__ = ["Truth"]

Sizes = Mapping[str, float]


@dataclass(frozen=True)
class Truth:
    """Truth that sealed measurements hide.

    Attributes
    ----------
    effects : parameters of the catalogue's effects, sizes and all else they need, by name
    outside : sizes of effects that no catalogue knows
    tolerance : parameters of the catalogue by which the build differs from its drawing, too small to be called effects
    values : EA, GA, EI of what was measured
    design, noise : what was done, and how it was read
    seed : of everything random
    variant : of the test bed that changes the law of the effects, if any
    """

    effects: Sizes = field(default_factory=dict)
    outside: Sizes = field(default_factory=dict)
    tolerance: Sizes = field(default_factory=dict)
    values: Sizes = field(default_factory=dict)
    design: str = "T"
    noise: str = "white"
    seed: int = 0
    variant: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        """The hidden effects of the catalogue, ``contact_stop`` and not its parameters."""
        return tuple(dict.fromkeys(name.partition(".")[0] for name in self.effects))

    @property
    def kind(self) -> str:
        """``clean``, ``effect``, ``pair`` (two or more effects), or ``outside`` where the catalogue cannot hold it."""
        if self.outside:
            return "outside"
        return ("clean", "effect")[len(self.names)] if len(self.names) < 2 else "pair"

    def to_json(self, path: str | os.PathLike[str]) -> Path:
        """Write the truth to a file.

        Raises
        ------
        InputError : the file cannot be written.
        """
        return write_whole(path, json.dumps(asdict(self), indent=1) + "\n")

    @classmethod
    def from_json(cls, path: str | os.PathLike[str]) -> "Truth":
        """Read what `to_json` wrote.

        Raises
        ------
        InputError : the file cannot be read or is no truth; names it and why.
        """
        try:
            found: Any = json.loads(read_whole(path))
        except (OSError, ValueError, RecursionError) as error:
            raise InputError(f"{path}: cannot be read as a truth ({why(error)})") from None
        kinds = {entry.name: type(getattr(cls(), entry.name)) for entry in fields(cls)}
        if not isinstance(found, dict) or set(found) | {"variant"} != set(kinds):
            raise InputError(f"{path}: no truth; allowed is one object with {', '.join(kinds)}")
        found = {"variant": "", **found}
        for name, kind in kinds.items():
            numbers = found[name].values() if isinstance(found[name], dict) else ()
            if not isinstance(found[name], kind) or not all(isinstance(value, (int, float)) for value in numbers):
                raise InputError(f"{path}: {name} = {shown(found[name])}: not what a truth has there")
        return cls(**found)

    def __repr__(self) -> str:
        hidden = {**self.effects, **{f"{name} (in no catalogue)": size for name, size in self.outside.items()}}
        effects = ", ".join(f"{name} = {size:.4g}" for name, size in hidden.items()) or "nothing"
        return f"<Truth: {effects} hidden in design {self.design}, noise {self.noise}, seed {self.seed}>"
