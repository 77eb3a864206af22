"""One unit of work: the solved cases of a chunk, determined by the sweep and the chunk's number."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ...mechanism.parameters import index, size
from ...mechanism.vector import pack
from ...models.equilibrium import BatchResult
from ...models.finite_element import FiniteElementModel
from .buffers import ScratchBuffers
from .sampling import cases
from .spec import LOADS, SweepSpec

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
    return SweepSpec.from_text(text)


def solve(spec: SweepSpec, number: int, room: ScratchBuffers | None = None, *, stride: int = 1) -> Solved:
    """Solve the cases of the chunk `number`, on the calling thread; or every so many of them.

    room : where they may lie until it is given to another chunk; none: new memory
    """
    room = ScratchBuffers() if room is None else room
    drawn = cases(spec, number, room.array("inputs", len(spec.varied), spec.chunk))
    inputs = {entry.name: values[::stride] for entry, values in zip(spec.varied, drawn, strict=True)}
    rows = -(-spec.rows(number) // stride)
    known: dict[str, float | Array] = {**spec.fixed, **inputs}
    lam = _together([known.get(name, 0.0) for name in _LAM], room.array("lam", rows, len(_LAM)))
    dead = [known.get(name, 0.0) for name in _WRENCH]
    same = all(np.ndim(value) == 0 for value in dead)
    wrench = np.array(dead) if same else _together(dead, room.array("wrench", rows, len(_WRENCH)))
    columns = {entry.name: inputs[entry.name] for entry in spec.varied if entry.name not in LOADS}
    model, result = room.model(spec.digest, partial(_model, spec, {})), _result(room, rows)
    changes = np.flatnonzero(np.any([values[1:] != values[:-1] for values in columns.values()], axis=0)) + 1
    if not columns:
        model.solve_batch(lam, wrench, tolerance=spec.tolerance, out=result, path=spec.path)
    elif (len(changes) + 1) * WORTH_A_MODEL <= rows:
        _by_mechanism(spec, columns, changes, lam, wrench, result)
    else:
        par = room.array("parameters", rows, size())
        par[:] = pack(model.mechanism)
        for name, values in columns.items():
            par[:, index(name)] = values
        model.solve_batch(lam, wrench, parameters=par, tolerance=spec.tolerance, out=result, path=spec.path)
    return Solved(inputs, result)


def _together(columns: list[float | Array], values: Array) -> Array:
    """Return numbers and columns as one array, (rows, columns), which is overwritten."""
    for place, column in enumerate(columns):
        values[:, place] = column
    return values


def _result(room: ScratchBuffers, rows: int) -> BatchResult:
    x, z, theta, factor = (room.array(name, rows) for name in ("x", "z", "theta", "load_factor"))
    return BatchResult(x, z, theta, room.array("status", rows, dtype=np.int64), factor)


def _model(spec: SweepSpec, changes: Mapping[str, float]) -> FiniteElementModel:
    """Return the model of a sweep's mechanism with what is the same in every case, and with some changes."""
    fixed = {name: value for name, value in spec.fixed.items() if name not in LOADS}
    return FiniteElementModel(spec.mechanism.replace(**fixed, **changes), spec.elements, spec.order or None)


def _by_mechanism(
    spec: SweepSpec,
    columns: Mapping[str, Array],
    changes: NDArray[np.intp],
    lam: Array,
    wrench: Array,
    result: BatchResult,
) -> None:
    """Solve runs of cases that share a mechanism, as a grid has them whose loads change fastest."""
    for rows in map(slice, [0, *changes], [*changes, len(lam)]):
        model = _model(spec, {name: float(values[rows.start]) for name, values in columns.items()})
        out = BatchResult(
            result.x[rows], result.z[rows], result.theta[rows], result.status[rows], result.load_factor[rows]
        )
        dead = wrench if wrench.ndim == 1 else wrench[rows]
        model.solve_batch(lam[rows], dead, tolerance=spec.tolerance, out=out, path=spec.path)
