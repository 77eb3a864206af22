"""Readings that are rounded to coarse steps."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ....data.columns import CAMERA_SIGMA, CHANNELS
from ....data.measurements import Measurements
from .finding import Finding

__all__ = ["resolution_findings"]

_FEWEST = 20  # readings; fewer may be multiples of one step by chance
_TIED = 0.8  # share of distinct readings; rounding makes many alike, evenly spaced loads do not
_COARSE = 2.0  # times the noise: rounding then adds a third of its variance and is no longer random from row to row
_ROUND = 1e-6  # of a step: how exactly readings are multiples of it
_UNITS = ("mm", "mm", "mrad")


def resolution_findings(data: Measurements) -> list[Finding]:
    """Return which channels of the pose are rounded to steps coarser than their noise."""
    return list(_coarse(data))


def _coarse(data: Measurements) -> Iterator[Finding]:
    for name, usual, unit in zip(CHANNELS, CAMERA_SIGMA, _UNITS, strict=True):
        values, sigma = getattr(data, name), getattr(data, f"sigma_{name}")
        step = _step(values[np.isfinite(values)])
        noise = float(np.median(sigma[sigma > 0.0])) if (sigma > 0.0).any() else usual
        if step > _COARSE * noise:
            sentence = f"{name}: all readings are multiples of {1e3 * step:.4g} {unit}, {step / noise:.2g} times the "
            sentence += f"{'declared' if (sigma > 0.0).any() else 'usual'} noise"
            cure = f"record more digits, or declare a noise of {1e3 * step / math.sqrt(12.0):.2g} {unit} (--noise)"
            yield Finding("quantized", (), sentence, cure)


def _step(values: NDArray[np.float64]) -> float:
    """Return the largest step of which the differences of all values are multiples, 0 where there is none."""
    distinct = np.unique(values)
    if values.size < _FEWEST or not 2 <= distinct.size <= _TIED * values.size:
        return 0.0
    step = float(np.diff(distinct).min())
    many = (distinct - distinct[0]) / step
    return step if np.abs(many - np.round(many)).max() < _ROUND * max(many[-1], 1.0) else 0.0
