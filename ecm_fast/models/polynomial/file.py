"""Files of fitted polynomials: JSON in SI units and radians, with names and exponents."""

import json
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from ...data.columns import COLUMNS
from ...errors import InputError, shown, why
from ...files import read_whole, write_whole
from ...kernels.polynomial import DEGREES, exponents
from .multivariate import Polynomial

__all__ = ["read_fields", "write_fields"]

Array = NDArray[np.float64]
Names = tuple[tuple[str, ...], tuple[str, ...]]


def write_fields(fields: Mapping[str, Any], kind: str, names: Names, path: str | os.PathLike[str]) -> Path:
    """Write the fields of a fitted polynomial of a `kind`, with the `names` of its inputs and outputs."""
    polynomial, energy = fields["polynomial"], fields["energy_coefficients"]
    inputs, outputs = names
    found = {"coefficients": polynomial.coefficients} if energy is None else {"energy": energy}
    content = {
        "kind": kind,
        "inputs": _columns(inputs),
        "outputs": _columns(outputs),
        "degree": polynomial.degree,
        **{name: fields[name] for name in ("rows", "condition")},
        **{name: fields[name].tolist() for name in ("rms", "lower", "upper")},
        "center": polynomial.center.tolist(),
        "exponents": exponents(len(inputs), polynomial.degree + (energy is not None)),
        **{name: values.tolist() for name, values in found.items()},
    }
    lines = ",\n".join(f" {json.dumps(key)}: {json.dumps(value, allow_nan=False)}" for key, value in content.items())
    return write_whole(path, f"{{\n{lines}\n}}\n")


def read_fields(
    kind: str, ways_in: Sequence[tuple[str, ...]], outputs: tuple[str, ...], path: str | os.PathLike[str]
) -> dict[str, Any]:
    """Return the fields of a fitted polynomial of a `kind` with one of `ways_in` for its inputs.

    Raises
    ------
    InputError : the file cannot be read, is damaged, or holds something else; names it and what is wrong.
    """
    try:
        content = json.loads(read_whole(path), parse_constant=_no_constant)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({why(error)})") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not a JSON file ({str(error).splitlines()[0]})") from None
    try:
        return _fields(content, kind, ways_in, outputs)
    except InputError as error:
        raise InputError(f"{path}: not a whole {kind} ({error})") from None


def _fields(content: Any, kind: str, ways_in: Sequence[tuple[str, ...]], outputs: tuple[str, ...]) -> dict[str, Any]:
    if not isinstance(content, dict):
        raise InputError("allowed is one JSON object")
    _one_of(content, "kind", [kind])
    inputs = _one_of(content, "inputs", [_columns(names) for names in ways_in])
    _one_of(content, "outputs", [_columns(outputs)])
    degree, k = _one_of(content, "degree", DEGREES), len(inputs)
    conservative = k == 3 and "energy" in content
    terms = exponents(k, degree + conservative)
    _one_of(content, "exponents", [[list(powers) for powers in terms]])
    lower, upper, center = (_array(content, name, (k,)) for name in ("lower", "upper", "center"))
    if not (lower < upper).all():
        raise InputError("lower is not below upper")
    energy = _array(content, "energy", (len(terms),)) if conservative else None
    if energy is None:
        polynomial = Polynomial(center, _array(content, "coefficients", (3, len(terms))))
    else:
        polynomial = Polynomial.gradient(center, energy)
    rows = _array(content, "rows", ())
    if not (rows > 0 and rows == int(rows)):
        raise InputError(f"rows = {shown(content['rows'])}: allowed is a whole number > 0")
    return {
        "polynomial": polynomial,
        "lower": lower,
        "upper": upper,
        "rms": _array(content, "rms", (3,)),
        "condition": float(_array(content, "condition", ())),
        "rows": int(rows),
        "energy_coefficients": energy,
    }


def _columns(names: Sequence[str]) -> list[str]:
    """Return quantities as the columns of a measurement file, with their units."""
    return [COLUMNS[name].names[0] for name in names]


def _value(content: Mapping[str, Any], key: str) -> Any:
    if key not in content:
        raise InputError(f"{key} is missing")
    return content[key]


def _one_of(content: Mapping[str, Any], key: str, allowed: Sequence[Any]) -> Any:
    value = _value(content, key)
    if isinstance(value, bool) or value not in allowed:
        raise InputError(f"{key} = {shown(value)}: allowed is {' or '.join(map(shown, allowed))}")
    return value


def _array(content: Mapping[str, Any], key: str, shape: tuple[int, ...]) -> Array:
    """Return finite numbers of that shape; NumPy alone would take texts and truth values for numbers."""
    value = _value(content, key)
    if not _holds(value, shape):
        raise InputError(f"{key} = {shown(value)}: allowed are finite numbers of shape {shape}")
    return np.array(value, dtype=np.float64)


def _holds(value: Any, shape: tuple[int, ...]) -> bool:
    if shape:
        return isinstance(value, list) and len(value) == shape[0] and all(_holds(entry, shape[1:]) for entry in value)
    if isinstance(value, int) and not isinstance(value, bool):
        return abs(value) < 2**53
    return isinstance(value, float) and math.isfinite(value)


def _no_constant(word: str) -> NoReturn:
    raise ValueError(f"{word} is not a number")
