"""The discretization of measured rows: its error is to stay below the noise of the readings."""

import numpy as np
from numpy.typing import NDArray

from ...data.columns import CHANNELS
from ...data.measurements import Measurements
from ...mechanism.parameters import PLACES
from ...mesh.discretization import Discretization
from ..refinement import resolve
from .measuring_chain import MeasuringChain

__all__ = ["mesh_for"]

Array = NDArray[np.float64]
# largest discretization error, as a share of the noise: added to it in quadrature, a tenth changes it by half a percent
SHARE_OF_NOISE = 0.1
# where no noise is declared, in rad and shares of the length: what models promise by default
UNDECLARED = 1e-6


def mesh_for(par: Array, data: Measurements, start: Discretization | None = None) -> tuple[Discretization, Array]:
    """Return the discretization whose error is at most a tenth of the declared noise in every row.

    Parameters
    ----------
    par : (n_parameters,) the mechanism, with the effects of the path that it has
    start : the coarsest that may be returned; default one element of order 5

    Returns
    -------
    The discretization, and by how much the estimated error of each row exceeds what is allowed, (n,): at most 1 where
    it does not, nan where there is no equilibrium. Above 1 only where no discretization is fine enough.
    """
    mesh = Discretization.of(1) if start is None else start
    length = par[PLACES.beam_length] + par[PLACES.effects_beam_length]
    noise = np.column_stack([getattr(data, f"sigma_{name}") for name in CHANNELS]) / [length, length, 1.0]
    declared = np.where(noise > 0.0, noise, np.inf).min(axis=1)
    allowed = np.where(np.isfinite(declared), SHARE_OF_NOISE * declared, UNDECLARED)
    rows = MeasuringChain(mesh, data).rows(par)
    mesh, error = resolve(mesh, rows, data.lam, data.wrench, allowed)
    return mesh, np.asarray(error / allowed)
