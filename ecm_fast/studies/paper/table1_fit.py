"""Parameter fits for the sections of the reproduction."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...data.measurements import Measurements
from ...identification.identify import identify
from ...mechanism.mechanism import Mechanism

__all__ = ["StiffnessFit", "fitted"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StiffnessFit:
    """Parameters that meet measurements best.

    Attributes
    ----------
    value, std : (k,) of the parameters, and one standard deviation that the known noise leaves
    residual : (n, 3) measured less predicted, in all channels [m, m, rad]
    rms : of the channels that were fitted, in standard deviations of their noise
    """

    value: Array
    std: Array
    residual: Array
    rms: float


def fitted(
    neck: Mechanism,
    data: Measurements,
    start: Mapping[str, float],
    channels: Sequence[str],
    *,
    elements: int = 1,
    order: int = 5,
) -> StiffnessFit:
    """Return the parameters at which the model meets the measured channels best, by least squares (42).

    Parameters
    ----------
    neck : all that is known
    start : values by the names of the parameters to find
    channels : of x, z, theta
    elements, order : the discretization, see `FiniteElementModel`
    """
    found = identify(neck.replace(**start), data, list(start), channels=channels, elements=elements, order=order)
    std = np.array([estimate.std for estimate in found.parameters.values()])
    return StiffnessFit(found.values, std, found.residual, float(np.sqrt(found.chi2 / found.used.sum())))
