"""One unit of work: the cases of a chunk, solved. It depends on the sweep and the chunk's number alone."""

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..equilibrium import BatchResult
from ..mechanism import Mechanism
from ..model import FiniteElementModel
from ..parameters import index, pack, unpack
from .design import cases
from .spec import LOADS, Input, SweepSpec

__all__ = ["Solved", "solve", "spec_of"]

Array = NDArray[np.float64]
# a mechanism that this many cases in a row share is worth a model of its own
WORTH_A_MODEL = 512
_LAM, _WRENCH = tuple(LOADS)[:2], tuple(LOADS)[2:]


@dataclass(frozen=True)
class Solved:
    """The cases of a chunk: what varies, (rows,) each, and what came out."""

    inputs: dict[str, Array]
    result: BatchResult

    def __repr__(self) -> str:
        return f"Solved({self.result!r})"


@functools.lru_cache(maxsize=8)
def spec_of(text: str) -> SweepSpec:
    """Return the sweep of a text; a worker gets the same one with every chunk."""
    return SweepSpec.of_text(text)


def solve(spec: SweepSpec, number: int, stride: int = 1) -> Solved:
    """Solve the cases of the chunk `number`, on the calling thread; or every so many of them."""
    inputs = {entry.name: own[::stride] for entry, own in zip(spec.varied, cases(spec, number), strict=True)}
    rows = -(-spec.rows(number) // stride)
    known: dict[str, float | Array] = {**spec.fixed, **inputs}
    lam = _together([known.get(name, 0.0) for name in _LAM], rows)
    dead = [known.get(name, 0.0) for name in _WRENCH]
    wrench = np.array(dead) if all(np.ndim(value) == 0 for value in dead) else _together(dead, rows)
    neck = spec.mechanism.replace(**{name: value for name, value in spec.fixed.items() if name not in LOADS})
    parameters = [entry for entry in spec.varied if entry.name not in LOADS]
    if not parameters:
        return Solved(inputs, _model(spec, neck).solve_batch(lam, wrench, tolerance=spec.tolerance))
    columns = [inputs[entry.name] for entry in parameters]
    changes = np.flatnonzero(np.any([own[1:] != own[:-1] for own in columns], axis=0)) + 1
    if (len(changes) + 1) * WORTH_A_MODEL <= rows:
        return Solved(inputs, _by_mechanism(spec, neck, parameters, columns, changes, lam, wrench))
    par = _vectors(neck, parameters, columns, slice(None))
    return Solved(inputs, _model(spec, neck).solve_batch(lam, wrench, parameters=par, tolerance=spec.tolerance))


def _together(columns: list[float | Array], rows: int) -> Array:
    """Return numbers and columns as one array, (rows, columns)."""
    values = np.empty((rows, len(columns)))
    for place, own in enumerate(columns):
        values[:, place] = own
    return values


def _model(spec: SweepSpec, neck: Mechanism) -> FiniteElementModel:
    return FiniteElementModel(neck, spec.elements, spec.order or None)


def _vectors(neck: Mechanism, parameters: list[Input], columns: list[Array], rows: slice) -> Array:
    """Return a parameter vector for each of some rows."""
    par = np.tile(pack(neck), (len(columns[0][rows]), 1))
    for entry, values in zip(parameters, columns, strict=True):
        par[:, index(entry.name)] = values[rows]
    return par


def _by_mechanism(
    spec: SweepSpec,
    neck: Mechanism,
    parameters: list[Input],
    columns: list[Array],
    changes: NDArray[np.intp],
    lam: Array,
    wrench: Array,
) -> BatchResult:
    """Solve runs of cases that share a mechanism, as a grid has them whose loads change fastest."""
    parts = []
    for rows in map(slice, [0, *changes], [*changes, len(lam)]):
        own = unpack(_vectors(neck, parameters, columns, slice(rows.start, rows.start + 1))[0])
        dead = wrench if wrench.ndim == 1 else wrench[rows]
        parts.append(_model(spec, own).solve_batch(lam[rows], dead, tolerance=spec.tolerance))
    together = zip(*((part.x, part.z, part.theta, part.status, part.load_factor) for part in parts), strict=True)
    return BatchResult(*map(np.concatenate, together))
