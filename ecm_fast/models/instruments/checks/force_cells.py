"""Faults of the force cells, of tendons and wrench: dead, stuck, saturated, dropped out.

Such a cell shows one and the same number, to the last digit, in rows where the poses ask for other forces. The number
alone proves nothing, since commanded loads repeat as well; nor do the poses alone, which a missing effect moves. Both
together do: rows of one reading that another force of that cell explains, beside rows of other readings that need none.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....data.columns import CAMERA_SIGMA, COLUMNS, PAIR
from ....data.measurements import Measurements
from ....mechanism.mechanism import Mechanism
from ....mechanism.mesh.discretization import Discretization
from ....mechanism.vector import pack
from ...equilibrium import Status
from ..measuring_chain import MeasuringChain
from .calibration import CELLS, Calibration, calibrate, moved_force, newtons, scales, with_force
from .finding import Finding, places

__all__ = ["force_cell_findings"]

Array = NDArray[np.float64]
Places = NDArray[np.int64]
Mask = NDArray[np.bool_]

_KINDS = (*(range(len(PAIR)),) * len(PAIR), *(range(len(PAIR), len(CELLS)),) * (len(CELLS) - len(PAIR)))
"""For each cell the cells of its kind, tendons or wrench."""
_UNUSED = 0.02  # of the largest load: less is the noise of a cell whose load is off
_MOST = 1500  # rows that are looked at, evenly over the order of measurement
_FEWEST_TIES, _FEWEST_OTHERS = 3, 8  # equal readings that make a stuck cell, and rows that a model is fitted to
_MORE_TIES = 2.0  # times as often as other readings repeat
_FAR = 8.0  # scales of the residual from which on a row is not explained
_CURED = 3.0  # factor by which another force must reduce the residual
_LEAST = 0.06
"""Share of the largest force by which a reading must be off: more than any effect of twice its typical size asks."""
_OTHERS_LESS = 3.0  # factor by which rows of similar loads and other readings must need less
_NEIGHBORS = 3  # rows of the nearest loads: their median outvotes one bad row
_MUCH = 0.2
"""Share of the other cell's largest force by which a column that holds one number must be off: a neck that is bent by
itself by twice what is usual asks for a tenth."""
_SHARE = 0.25  # of the rows of a column that holds one number, which must ask for another
_CLIPPED = 0.8  # of the rows that ask for another force: so many for a larger one
_STEPS = 8  # Newton steps for a force
_USUAL_NOISE = np.array(CAMERA_SIGMA)  # the least that a residual is compared with
_LAST_STEP = 1e-14  # squared, of Newton: far below the misfit of a broken cell


class _Asked(NamedTuple):
    """Forces that the poses ask of one cell.

    force : (n,) [N]
    before, after : (n,) largest residual of a row in scales, with the force read and with that one
    """

    force: Array
    before: Array
    after: Array


def force_cell_findings(mechanism: Mechanism, data: Measurements) -> list[Finding]:
    """Return which force cells show one number where the poses ask for others."""
    rows = np.flatnonzero(data.measured.sum(axis=1) > 1)
    rows = rows[np.unique(np.linspace(0, rows.size - 1, min(_MOST, rows.size)).astype(int))]
    if rows.size < _FEWEST_OTHERS:
        return []
    sizes = np.abs(_loads(mechanism, data, rows)).max(axis=0)
    used = [cell for cell, kind in enumerate(_KINDS) if sizes[list(kind)].max() > _UNUSED * sizes.max()]
    suspects = {cell: list(_suspects(getattr(data, CELLS[cell])[rows])) for cell in used}
    ties = [np.isin(getattr(data, CELLS[cell])[rows], readings) for cell, readings in suspects.items()]
    clean = ~np.any([tied for tied in ties if not tied.all()] or [np.zeros(rows.size, dtype=bool)], axis=0)
    found = list[Finding]()
    for cell, readings in suspects.items():
        for reading in readings:
            tied = getattr(data, CELLS[cell])[rows] == reading
            believed = clean & ~tied if (clean & ~tied).sum() >= _FEWEST_OTHERS else ~tied
            if believed.sum() >= _FEWEST_OTHERS:
                found += _some_alike(mechanism, data, rows, cell, tied, believed)
            elif tied.all() and (
                cell < len(PAIR) or 0 not in used
            ):  # a couple stands for much that bends a pulled neck
                found += _all_alike(mechanism, data, rows, cell)
    return found


def _loads(mechanism: Mechanism, data: Measurements, rows: Places) -> Array:
    """Return the readings of the cells, (n, 5), couples as forces at the arm of the beam's length [N]."""
    return np.column_stack([getattr(data, cell)[rows] / newtons(mechanism, i) for i, cell in enumerate(CELLS)])


def _suspects(values: Array) -> Iterator[float]:
    """Yield readings that a faulty cell may have shown: zero, and what repeats far more often than others."""
    distinct, counts = np.unique(values, return_counts=True)
    often = np.maximum(_FEWEST_TIES, np.where(distinct == 0.0, 0.0, _MORE_TIES * np.median(counts)))
    yield from (float(reading) for reading in distinct[(counts >= often) | (distinct.size == 1)])


def _some_alike(
    mechanism: Mechanism, data: Measurements, rows: Places, cell: int, tied: Mask, believed: Mask
) -> Iterator[Finding]:
    """Yield a finding where other forces explain rows of one reading; the rows `believed` calibrate the model."""
    calibration = calibrate(mechanism, data, rows[believed])
    scale = np.maximum(scales(calibration.residual), _USUAL_NOISE)
    asked = _asked(mechanism, calibration, data, rows, cell, scale)
    loads = _loads(mechanism, data, rows)
    off = np.abs(asked.force / newtons(mechanism, cell) - loads[:, cell])
    cured = (asked.before > _FAR) & (asked.after * _CURED < asked.before)
    least, others = _LEAST * np.abs(loads[:, _KINDS[cell]]).max(), np.delete(loads, cell, axis=1)
    low, high = others[believed].min(axis=0) - least, others[believed].max(axis=0) + least
    far = (off > least) & ((others >= low) & (others <= high)).all(axis=1)  # else no row that is believed is like it
    bad = tied & cured & far
    if bad.sum() < _FEWEST_TIES:
        return
    near = _of_neighbors(loads, np.flatnonzero(bad), np.flatnonzero(believed), off)
    if np.median(off[bad] / np.maximum(near, 1e-9)) >= _OTHERS_LESS:
        bad = tied & (asked.after < asked.before) & far
        yield _worded(data, rows, cell, tied, bad, asked.force)


def _asked(
    mechanism: Mechanism, calibration: Calibration, data: Measurements, rows: Places, cell: int, scale: Array
) -> _Asked:
    """Return the force of a cell that meets the pose of each row best."""
    par = pack(mechanism.replace(**calibration.stiffnesses))
    force, measured, first = getattr(data, CELLS[cell])[rows].copy(), data.pose[rows], np.zeros(len(rows))
    for count in range(_STEPS):
        chain = MeasuringChain(Discretization.from_elements(1, 5), with_force(data, rows, cell, force), rows)
        found = chain.sensitivities((), par, _LAST_STEP)
        use = np.isfinite(measured) & (found.status == Status.CONVERGED)[:, None]
        off = np.where(use, measured - np.nan_to_num(found.pose), 0.0) / scale
        slope = np.where(use, np.nan_to_num(found.by_load[:, :, cell]), 0.0) / scale
        last = np.where(use.any(axis=1), np.abs(off).max(axis=1), np.inf)
        first = last if count == 0 else first
        step = (off * slope).sum(axis=1) / np.maximum((slope**2).sum(axis=1), 1e-12)
        if count < _STEPS - 1:
            force = moved_force(mechanism, cell, force, step)
    return _Asked(force, first, last)


def _of_neighbors(loads: Array, of: Places, among: Places, off: Array) -> Array:
    """Return the median of `off` in the rows `among` nearest to each of the rows `of`, (k,)."""
    from scipy.spatial import KDTree

    count = min(_NEIGHBORS, len(among))
    nearest = KDTree(loads[among]).query(loads[of], list(range(1, count + 1)))[1]
    return np.asarray(np.median(off[among][nearest], axis=1))


def _all_alike(mechanism: Mechanism, data: Measurements, rows: Places, cell: int) -> Iterator[Finding]:
    """Yield a finding where other forces explain what one reading in all rows does not."""
    read, blind = calibrate(mechanism, data, rows), calibrate(mechanism, data, rows, blind=cell)
    before, after = scales(read.residual), scales(blind.residual)
    loads = _loads(mechanism, data, rows)
    asked = blind.force / newtons(mechanism, cell)
    other = float(np.abs(loads[:, [i for i in _KINDS[cell] if i != cell]]).max())  # 0 where the kind is off
    off = np.minimum(np.abs(asked - loads[:, cell]), np.abs(asked - np.median(asked)))  # a constant is an origin
    bad = off > _MUCH * other
    unexplained = data.measured[rows].any(axis=0) & (before > _FAR * _USUAL_NOISE)
    if other > 0.0 and unexplained.any() and (after * _FAR < before)[unexplained].all() and bad.mean() > _SHARE:
        yield _worded(data, rows, cell, np.ones(rows.size, dtype=bool), bad, blind.force)


def _worded(data: Measurements, rows: Places, cell: int, tied: Mask, bad: Mask, force: Array) -> Finding:
    name, unit = CELLS[cell], "N m" if CELLS[cell] == "tau" else "N"
    column = next((given for given in data.columns if given.startswith(f"{name}_")), COLUMNS[name].names[0])
    values = getattr(data, name)[rows]
    reading, low, high = float(values[tied][0]) + 0.0, float(force[bad].min()), float(force[bad].max())
    asked = f"where the poses ask for {low:.3g} to {high:.3g} {unit}"
    if tied.all():
        kind = "stuck" if reading else "dead"
        sentence = f"{column}: {reading:g} {unit} in all {rows.size} rows {asked}"
        return Finding(kind, (), sentence, f"the cell is {kind}: mend it and measure again", True)
    outward = force[bad] > reading if reading == values.max() else force[bad] < reading
    clipped = reading in (values.min(), values.max()) and reading != 0.0 and np.mean(outward) > _CLIPPED
    lines = tuple(int(data.rows[i]) for i in rows[tied if clipped else bad])
    if reading == 0.0:
        kind, why = "dropped out", "the cell dropped out, and its gaps were written as zeros: leave these rows out"
    elif clipped:
        kind, why = "saturated", "the cell is saturated there: leave these rows out, or take a cell with a wider range"
    else:
        kind, why = "stuck", "the cell stood still there: leave these rows out"
    return Finding(kind, lines, f"{column}: {reading:g} {unit} in {places(data, lines)} {asked}", why, True)
