"""Tables as laboratories write them, from numbers that a test chose itself."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ecm_fast.data.column_map import ColumnMap
from ecm_fast.data.grid import Layout
from ecm_fast.data.measurements import Measurements, read_measurements
from ecm_fast.data.proposal import propose
from ecm_fast.data.readers import read_table

__all__ = ["PER_SI", "Doubts", "imported", "text"]

PER_SI = {"N": 1.0, "kN": 1e-3, "mN": 1e3, "kgf": 1 / 9.80665, "gf": 1e3 / 9.80665, "lbf": 1 / 4.4482216152605,
          "m": 1.0, "cm": 1e2, "mm": 1e3, "in": 1 / 0.0254, "rad": 1.0, "deg": 180.0 / np.pi, "mrad": 1e3,
          "s": 1.0, "ms": 1e3}  # fmt: skip
"""Numbers in a unit for one in SI, from the units' definitions."""


class Doubts(tuple[str, ...]):
    """Questions of the import, one entry a column."""

    __slots__ = ()


def text(
    header: Sequence[Sequence[str]], rows: Sequence[Sequence[str]], mark: str = ",", decimal: str = ".", end: str = "\n"
) -> str:
    """Return a table as text; numbers get their decimal mark."""
    marked = [[cell.replace(".", decimal) for cell in row] for row in rows]
    return end.join(mark.join(row) for row in [*header, *marked]) + end


def imported(path: Path, told: Mapping[str, str] | None = None, layout: Layout | None = None) -> Measurements | Doubts:
    """Return what a file holds, read with the map that the import proposes, or what the import asks."""
    given = ColumnMap(told or {}, layout or Layout())
    guesses = propose(read_table(path, given.layout, bare=True), given)
    doubts = Doubts(f"{guess.name}: {guess.doubt}" for guess in guesses if not guess.certain)
    if doubts:
        return doubts
    return read_measurements(path, ColumnMap({guess.name: guess.told for guess in guesses}, given.layout))
