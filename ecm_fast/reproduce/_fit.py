"""Least squares on measured poses with exact derivatives: how the sections find parameters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data import Measurements
from ..mechanism import Mechanism
from ..model import FiniteElementModel

__all__ = ["Fit", "fitted"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Fit:
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
    neck: Mechanism, data: Measurements, start: Mapping[str, float], channels: Sequence[int], **division: int
) -> Fit:
    """Return the parameters at which the model meets the measured channels best, by least squares (42).

    Parameters
    ----------
    neck : all that is known
    start : values by the names of the parameters to find
    channels : 0 to 2, for x, z, theta
    division : elements and order, see `FiniteElementModel`
    """
    from scipy.optimize import least_squares

    names, size, picked = list(start), np.array(list(start.values())), list(channels)
    sigma = np.column_stack([data.sigma_x, data.sigma_z, data.sigma_theta])[:, picked]

    def solved(share: Array) -> Any:
        model = FiniteElementModel(neck.replace(**dict(zip(names, share * size, strict=True))), **division)
        return model.sensitivities(names, data.lam, data.wrench)

    def misfit(share: Array) -> Array:
        return np.asarray((solved(share).pose - data.pose)[:, picked] / sigma).ravel()

    def slope(share: Array) -> Array:
        return np.asarray(solved(share).by_parameter[:, picked] / sigma[:, :, None] * size).reshape(-1, len(size))

    found = least_squares(misfit, np.ones(len(size)), slope, method="lm", xtol=1e-12, ftol=1e-12, gtol=1e-12)
    final = slope(found.x)
    covariance = np.linalg.inv(final.T @ final)
    residual = data.pose - solved(found.x).pose
    rms = float(np.sqrt(np.mean((residual[:, picked] / sigma) ** 2)))
    return Fit(found.x * size, np.sqrt(np.diag(covariance)) * size, residual, rms)
