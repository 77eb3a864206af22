"""The specification of a sweep: every number it depends on, as one canonical line of text."""

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ... import __version__
from ...mechanism.mechanism import Mechanism
from ...mechanism.parameters import PARAMETERS, find, index
from ...mechanism.vector import pack, unpack
from ...models.user_effects import make_effects, sources

__all__ = ["CHUNK", "LOADS", "OUTPUTS", "Input", "SweepSpec", "column", "limits"]

Array = NDArray[np.float64]

LOADS: dict[str, tuple[str, float]] = {
    "lam_l": ("lam_l_N", 0.0),
    "lam_r": ("lam_r_N", 0.0),
    "fx": ("fx_N", -math.inf),
    "fz": ("fz_N", -math.inf),
    "tau": ("tau_Nm", -math.inf),
}
"""The loads of a case: the column each is stored in, named as in a measurement file, and its least value."""
OUTPUTS = ("x_m", "z_m", "theta_rad")
"""The columns of the pose."""
CHUNK = 1 << 17
"""Cases of one unit of work, and rows of one file: a power of two, so that it is a block of Sobol's sequence."""


def column(name: str) -> str:
    """Return the column in which an input is stored: a load as in a measurement file, a parameter by its full key."""
    return LOADS[name][0] if name in LOADS else find(name).key


def limits(name: str) -> tuple[float, float]:
    """Return the least and the largest value that an input may have."""
    if name in LOADS:
        return LOADS[name][1], math.inf
    entry = find(name)
    return entry.lower, entry.upper


@dataclass(frozen=True)
class Input:
    """One input of a sweep, and which values it takes.

    Attributes
    ----------
    name : a load of `LOADS`, or the full key of a parameter such as ``beam.EI``
    kind : fixed, the same value in every case; values, those given; uniform, from one number to another;
        normal, cut off at the limits of the input
    numbers : (value,), the values, (from, to), or (mean, standard deviation)
    steps : of a uniform input in a grid, ends included; else 0
    """

    name: str
    kind: Literal["fixed", "values", "uniform", "normal"]
    numbers: tuple[float, ...]
    steps: int = 0

    def grid(self) -> Array:
        """Return the values of the input in a grid."""
        values = np.array(self.numbers)
        return np.linspace(values[0], values[1], self.steps) if self.kind == "uniform" else values

    def quantile(self, u: Array) -> Array:
        """Return the values at numbers from 0 up to 1, 1 itself excluded; `u` may be overwritten."""
        if self.kind == "uniform":
            low, high = self.numbers
            u *= high - low
            if low:
                u += low
            return u
        if self.kind == "values":
            values = np.array(self.numbers)
            return values[np.minimum((u * len(values)).astype(np.intp), len(values) - 1)]
        from scipy.special import ndtr, ndtri

        (mean, std), (lower, upper) = self.numbers, limits(self.name)
        low, high = ndtr((lower - mean) / std), ndtr((upper - mean) / std)
        values = mean + std * ndtri(low + (high - low) * np.maximum(u, 2.0**-54))
        return np.clip(values, lower, upper)


@dataclass(frozen=True)
class SweepSpec:
    """A sweep; see `spec_file.read_spec` for the file it is read from.

    Attributes
    ----------
    inputs : what varies and what is set, the slowest of a grid first; other numbers are the mechanism's
    sample : grid, random or sobol
    cases : how many
    seed : of random and sobol
    mechanism : what is built where no input says otherwise
    elements, order : of the discretization; order 0 is the model's default
    tolerance, path : as for `FiniteElementModel.solve_batch`; cases have no order
    keep : rows, every case in a file; or statistics alone
    chunk : cases of one unit of work
    bins : of the histograms
    ranges : of the histograms, (column, from, to); those not given are found by a few cases
    """

    inputs: tuple[Input, ...]
    sample: Literal["grid", "random", "sobol"]
    cases: int
    seed: int = 0
    mechanism: Mechanism = field(default_factory=Mechanism)
    elements: int = 1
    order: int = 0
    tolerance: float = 1e-9
    keep: Literal["rows", "statistics"] = "rows"
    chunk: int = CHUNK
    bins: int = 200
    ranges: tuple[tuple[str, float, float], ...] = ()
    path: Literal["ignore"] | None = None

    @cached_property
    def text(self) -> str:
        """Everything the results depend on, on one line; `from_text` reads it."""
        content = {name: getattr(self, name) for name in self.__dataclass_fields__}
        if self.path is None:
            del content["path"]  # as in sweeps that were begun before there was this choice
        content["inputs"] = [[i.name, i.kind, list(i.numbers), i.steps] for i in self.inputs]
        keys = [entry.key for entry in PARAMETERS]  # those of effects that a user adds come last, and behind them
        content["mechanism"] = dict(zip(keys, pack(self.mechanism).tolist(), strict=False))  # what belongs to a process
        added = sources()
        return json.dumps({"ecm_fast": __version__, **content, **({"user_effects": added} if added else {})})

    @classmethod
    def from_text(cls, text: str) -> "SweepSpec":
        """Return the sweep whose `text` this is."""
        content: dict[str, Any] = json.loads(text)
        del content["ecm_fast"]
        make_effects(content.pop("user_effects", {}))
        content["inputs"] = tuple(Input(n, kind, tuple(numbers), s) for n, kind, numbers, s in content["inputs"])
        par = pack(Mechanism())
        for key, value in content["mechanism"].items():
            par[index(key)] = value
        content["mechanism"] = unpack(par)
        content["ranges"] = tuple(tuple(entry) for entry in content["ranges"])
        return cls(**content)

    @cached_property
    def digest(self) -> str:
        """A short name of the sweep: two that differ in anything have different ones."""
        return hashlib.sha256(self.text.encode()).hexdigest()[:16]

    @property
    def varied(self) -> tuple[Input, ...]:
        """The inputs that are not the same in every case."""
        return tuple(entry for entry in self.inputs if entry.kind != "fixed")

    @property
    def fixed(self) -> Mapping[str, float]:
        """The inputs that are the same in every case, and their values."""
        return {entry.name: entry.numbers[0] for entry in self.inputs if entry.kind == "fixed"}

    @property
    def chunks(self) -> int:
        """Number of units of work."""
        return -(-self.cases // self.chunk)

    def rows(self, number: int) -> int:
        """Return how many cases the unit of work `number` has."""
        return min(self.chunk, self.cases - number * self.chunk)

    def __repr__(self) -> str:
        names = ", ".join(entry.name for entry in self.varied)
        return f"SweepSpec({self.cases} cases, {self.sample} over {names}; keeps {self.keep})"
