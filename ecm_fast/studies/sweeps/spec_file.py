"""Sweep specifications from TOML files or dicts, validated."""

import math
import os
from collections.abc import Mapping
from numbers import Real
from pathlib import Path
from typing import Any

from ...errors import InputError, did_you_mean, key_shown, shown
from ...mechanism.catalogue import CATALOGUE
from ...mechanism.mechanism import Mechanism
from ...mechanism.parameters import find
from ...mechanism.toml_file import read_toml
from ...mechanism.vector import pack
from ...models.instruments.history import path_effects
from ...models.loads import MIN_TOLERANCE
from ...models.path_state import check_order
from .spec import CHUNK, LOADS, OUTPUTS, Input, SweepSpec, limits

__all__ = ["read_spec"]

SAMPLES = ("grid", "random", "sobol")
KEEPS = ("rows", "statistics")
MOST = {"grid": 10**12, "random": 10**12, "sobol": 2**30}  # cases; Sobol's sequence repeats itself there
_SETTINGS = ("sample", "cases", "seed", "mechanism", "elements", "order", "tolerance", "keep", "chunk", "path")
_FORMS = "a number, [from, to], or a table with from and to (in a grid also steps), with values, or with mean and std"


def read_spec(source: str | os.PathLike[str] | Mapping[str, Any]) -> SweepSpec:
    """Return the sweep of a TOML file or of a dict.

    Notes
    -----
    ::

        [sweep]
        sample = "sobol"          # or "random", "grid"
        cases = 1_000_000         # a grid has as many as its inputs make
        seed = 0
        keep = "rows"             # or "statistics"
        mechanism = "neck.toml"   # beside this file; default: the preset "slender"
        path = "ignore"           # leaves out friction and other effects of the path; else they are refused

        [inputs]                  # loads, parameters and effects; in a grid the last one changes fastest
        lam_l = [0.0, 160.0]                      # uniform
        EI = { mean = 3.0, std = 0.03 }           # normal
        plate_half_width = { values = [0.06, 0.07] }
        lam_r = { from = 0.0, to = 160.0, steps = 41 }    # in a grid
        fx = -5.0                                 # the same in every case

        [statistics]
        bins = 200
        theta_rad = [-0.6, 0.6]   # range of a histogram; one that is not given is found

    Raises
    ------
    InputError : one line with file, key, value and what is allowed.
    """
    if isinstance(source, Mapping):
        return _spec(source, Path())
    content = read_toml(source)
    try:
        return _spec(content, Path(source).parent)
    except InputError as error:
        raise InputError(f"{source}: {error}") from None


def _spec(content: Mapping[str, Any], folder: Path) -> SweepSpec:
    tables = {name: _table(content, name) for name in ("sweep", "inputs", "statistics")}
    _known(content, tables, "")
    given, kept = tables["sweep"], tables["statistics"]
    _known(given, _SETTINGS, "sweep.")
    _known(kept, ("bins", *OUTPUTS), "statistics.")
    sample = _one_of("sweep.sample", given.get("sample", "random"), SAMPLES)
    inputs = tuple(_input(str(name), value, sample) for name, value in tables["inputs"].items())
    _distinct(inputs)
    chunk = _whole("sweep.chunk", given.get("chunk", CHUNK), 64, 1 << 20)
    if chunk & (chunk - 1):
        raise InputError(f"sweep.chunk = {chunk}: allowed is a power of two")
    neck, path = _mechanism(given.get("mechanism"), folder), given.get("path")
    if path is not None:
        _one_of("sweep.path", path, ("ignore",))
    on_path = {item.size.key: item.name for item in CATALOGUE.values() if item.enters == "path"}
    effects = path_effects(pack(neck)) + [on_path[entry.name] for entry in inputs if entry.name in on_path]
    check_order(effects, path, "a sweep")
    return SweepSpec(
        inputs=inputs,
        sample=sample,
        cases=_cases(given, sample, inputs),
        seed=_whole("sweep.seed", given.get("seed", 0), 0, 2**63 - 1),
        mechanism=neck,
        elements=_whole("sweep.elements", given.get("elements", 1), 1, 100_000),
        order=_whole("sweep.order", given.get("order", 0), 0, 6),
        tolerance=_number("sweep.tolerance", given.get("tolerance", 1e-9), MIN_TOLERANCE, 1e-3),
        keep=_one_of("sweep.keep", given.get("keep", "rows"), KEEPS),
        chunk=chunk,
        bins=_whole("statistics.bins", kept.get("bins", 200), 1, 100_000),
        path=path,
        ranges=tuple(
            (name, *_span(f"statistics.{name}", kept[name], -math.inf, math.inf)) for name in OUTPUTS if name in kept
        ),
    )


def _input(name: str, value: Any, sample: str) -> Input:
    key = f"inputs.{name}"
    if name not in LOADS:
        try:
            name = find(name).key
        except InputError as error:
            hint = did_you_mean(name, LOADS)
            raise InputError(f"{key_shown(key)}: {error}{hint}; loads are {', '.join(LOADS)}") from None
    if name == "beam.axial_law":
        raise InputError(f"{key} = {shown(value)}: the law is no number; say it in the mechanism file")
    low, high = limits(name)
    if isinstance(value, list):
        value = dict(zip(("from", "to"), value, strict=True)) if len(value) == 2 else None
    if not isinstance(value, Mapping):
        if isinstance(value, bool) or not isinstance(value, Real):
            raise InputError(f"{key} = {shown(value)}: allowed is {_FORMS}")
        return Input(name, "fixed", (_number(key, value, low, high),))
    words = set(value)
    if words == {"values"}:
        return Input(name, "values", _values(f"{key}.values", value["values"], low, high))
    if words == {"mean", "std"} and sample != "grid":
        return Input(name, "normal", _normal(key, value, low, high))
    if words != ({"from", "to", "steps"} if sample == "grid" else {"from", "to"}):
        raise InputError(f"{key} = {shown(dict(value))}: allowed in a sample that is {sample!r} is {_FORMS}")
    ends = _span(key, [value["from"], value["to"]], low, high)
    steps = _whole(f"{key}.steps", value["steps"], 2, 10**9) if sample == "grid" else 0
    return Input(name, "uniform", ends, steps)


def _normal(key: str, value: Mapping[str, Any], low: float, high: float) -> tuple[float, float]:
    mean = _number(f"{key}.mean", value["mean"], low, high)
    std = _number(f"{key}.std", value["std"], 0.0, math.inf)
    if std == 0.0:
        raise InputError(f"{key}.std = 0: allowed is a positive number; without spread write the mean alone")
    return mean, std


def _values(key: str, value: Any, low: float, high: float) -> tuple[float, ...]:
    if not isinstance(value, list) or not value:
        raise InputError(f"{key} = {shown(value)}: allowed is a list of numbers")
    return tuple(_number(f"{key}[{i}]", entry, low, high) for i, entry in enumerate(value))


def _span(key: str, value: Any, low: float, high: float) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise InputError(f"{key} = {shown(value)}: allowed is [from, to]")
    ends = _number(f"{key}.from", value[0], low, high), _number(f"{key}.to", value[1], low, high)
    if not ends[0] < ends[1]:
        raise InputError(f"{key} = {shown(value)}: allowed is a range that ends above its beginning")
    return ends


def _cases(given: Mapping[str, Any], sample: str, inputs: tuple[Input, ...]) -> int:
    if all(entry.kind == "fixed" for entry in inputs):
        raise InputError("inputs: nothing varies; allowed is at least one input with more than one value")
    if sample != "grid":
        if "cases" not in given:
            raise InputError(f"sweep.cases is missing: a sample that is {sample!r} needs the number of cases")
        return _whole("sweep.cases", given["cases"], 1, MOST[sample])
    if "cases" in given:
        raise InputError(
            f"sweep.cases = {shown(given['cases'])}: allowed is none, a grid has as many as its inputs make"
        )
    cases = math.prod(entry.steps or len(entry.numbers) for entry in inputs if entry.kind != "fixed")
    if cases > MOST[sample]:
        raise InputError(f"inputs: the grid has {cases} cases: allowed is up to {MOST[sample]}; take fewer steps")
    return cases


def _distinct(inputs: tuple[Input, ...]) -> None:
    names = [entry.name for entry in inputs]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"inputs: {name} is given twice, by its short name and in full")


def _mechanism(value: Any, folder: Path) -> Mechanism:
    if value is None:
        return Mechanism.preset()
    if isinstance(value, Mechanism):
        return value
    if not isinstance(value, str):
        raise InputError(f"sweep.mechanism = {shown(value)}: allowed is the name of a mechanism file")
    return Mechanism.from_toml(folder / value)


def _table(content: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    value = content.get(name, {})
    if not isinstance(value, Mapping):
        raise InputError(f"{name} = {shown(value)}: allowed is a table, written [{name}]")
    return value


def _known(given: Mapping[str, Any], allowed: Any, prefix: str) -> None:
    for key in given:
        if key not in allowed:
            raise InputError(
                f"unknown key {prefix}{key_shown(str(key))}{did_you_mean(str(key), allowed)}; allowed are "
                f"{', '.join(allowed)}"
            )


def _one_of(key: str, value: Any, allowed: tuple[str, ...]) -> Any:
    if value not in allowed:
        hint = did_you_mean(value, allowed) if isinstance(value, str) else ""
        raise InputError(f"{key} = {shown(value)}: allowed is {' or '.join(map(repr, allowed))}{hint}")
    return value


def _whole(key: str, value: Any, low: int, high: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise InputError(f"{key} = {shown(value)}: allowed is a whole number from {low} to {high}")
    return value


def _number(key: str, value: Any, low: float, high: float) -> float:
    number = float(value) if isinstance(value, Real) and not isinstance(value, bool) else math.nan
    if not (math.isfinite(number) and low <= number <= high):
        words = "a finite number" + (f" from {low:g}" if low > -math.inf else "")
        raise InputError(f"{key} = {shown(value)}: allowed is {words}{f' to {high:g}' if high < math.inf else ''}")
    return number
