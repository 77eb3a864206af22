"""Outliers: alarms that rest on single rows, and noise above the declared level."""

from dataclasses import replace

import numpy as np

from ...identification.noise import DECLARED
from ..problem.linearization import Linearization
from ..results.diagnosis import LackOfFit
from ..statistics.robust_noise import orthonormal, removal
from .initial_values import largest_evidence

__all__ = ["drop_single_row_alarms", "excess_noise"]

_ALONE, _FAR_OUT = 3, 25.0
"""Most rows that an alarm may rest on and still be theirs, and what each one must take off the sum of squares."""
_SLIPS, _BY_CHANCE = 0.01, 1e-3
"""Share of rows whose readings slip, and the chance below which there are more than that."""
_ASTRAY = 3.0 * np.log1p(10.0**2) - 2.0 * np.log(_SLIPS)
"""Evidence that a row must bring to count as one that is off by some ten sigma in every channel."""
_LOUD = 5.5
"""Noise seen over noise declared, less 1, times the root of the readings: eight standard deviations of white noise. In
1200 clean sets of 81 rows, white and not, one had 0.6, where 0.7 alarms."""


def drop_single_row_alarms(view: Linearization, alpha: float, seed: int) -> tuple[Linearization, tuple[LackOfFit, ...]]:
    """Return the tests of a view without rows on each of which an alarm rests alone: they are outliers.

    Unless one effect makes them all at once: a stop touches few rows, and these as no accident would.
    """
    first = view.gates(alpha, seed)
    for most, smooth in ((_ALONE, True), (1, False)):
        gates, reduced, dropped = first, view, 0
        while any(gate.alarm for gate in gates) and dropped < most:
            row, gain = _worst(reduced, smooth=smooth)
            if gain < _FAR_OUT:
                break
            reduced, dropped = _without(reduced, row), dropped + 1
            gates = reduced.gates(alpha, seed)
        if not any(gate.alarm for gate in gates):
            whole, rest = view.rest[2], reduced.rest[2]
            as_outliers = whole.left - rest.left - _ASTRAY * dropped
            named = dropped and largest_evidence(view) > as_outliers
            return (view, first) if named else (reduced, gates)
    return view, first


def _worst(view: Linearization, *, smooth: bool) -> tuple[int, float]:
    """Return the row whose removal takes most off the sum of squares, and how much.

    smooth : whether smooth functions are let free; a row that they bend to hides from them
    """
    residual, columns, _ = view.rest
    below = len(residual) - 3 * len(view.rows)
    if smooth:
        columns = np.hstack([columns, np.pad(view.smoothed(), ((0, below), (0, 0)))])
    gain = removal(residual, orthonormal(columns), below=below)
    return int(np.argmax(gain)), float(gain.max())


def _without(view: Linearization, row: int) -> Linearization:
    """Return the view with one more of its rows left out, the cleaned residuals of the others kept."""
    kept = np.arange(len(view.rows)) != row
    before, rows = view.cleaned, view.rows[kept]
    cleaned = replace(before, residual=before.residual[kept], outlier=before.outlier[kept])
    lost = np.append(view.outliers, view.rows[row])
    return replace(view, rows=rows, chain=view.problem.chain(rows), cleaned=cleaned, outliers=lost)


def excess_noise(view: Linearization) -> tuple[str, ...]:
    """Return lines where what looks like noise is far more than the measurements declare, or has too many outliers."""
    from scipy.stats import binom

    lines, lost = list[str](), len(view.outliers)
    count = ((view.noise.origin[view.rows] == DECLARED) & view.used).sum(axis=0)
    scale = np.where(count > 0, view.cleaned.scale, 0.0)
    if (scale > 1.0 + _LOUD / np.sqrt(np.maximum(count, 1))).any():
        lines.append(f"what is left scatters {scale.max():.2g} times as much as the noise that is declared: either "
                     "that is wrong, or something is missing that looks like no effect of the catalogue")  # fmt: skip
    if binom.sf(lost - 1, lost + len(view.rows), _SLIPS) < _BY_CHANCE:
        lines.append(f"{lost} of {lost + len(view.rows)} rows are far from all that effects and smooth functions "
                     "say: readings slip often, or something is missing that acts there alone")  # fmt: skip
    return tuple(lines)
