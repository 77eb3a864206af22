"""The discretization of measured rows: its error is to stay below the noise of the readings."""

import numpy as np
from numpy.typing import NDArray

from ...data.columns import channel_key
from ...data.measurements import Measurements
from ...mechanism.mechanism import Mechanism
from ...mechanism.mesh.discretization import Discretization
from ...mechanism.vector import pack
from .robot_chain import chain_of

__all__ = ["mesh_for"]

Array = NDArray[np.float64]
# largest discretization error, as a share of the noise: added to it in quadrature, a tenth changes it by half a percent
SHARE_OF_NOISE = 0.1
# where no noise is declared, in rad and shares of the length: what models promise by default
UNDECLARED = 1e-6


def mesh_for(
    mechanism: Mechanism, data: Measurements, start: Discretization | None = None
) -> tuple[Discretization, Array]:
    """Return the discretization whose error is at most a tenth of the declared noise in every row.

    Parameters
    ----------
    mechanism : with the effects of the path that it has
    start : the coarsest that may be returned; default one element of order 5, or one for each piece of the body

    Returns
    -------
    The discretization, and by how much the estimated error of each row exceeds what is allowed, (n,): at most 1 where
    it does not, nan where there is no equilibrium. Above 1 only where no discretization is fine enough.
    """
    chain = chain_of(mechanism, data, start)
    unit = [mechanism.length if channel_key(name).endswith("_m") else 1.0 for name in chain.channels]
    noise = data.sigmas(chain.channels) / unit
    declared = np.where(noise > 0.0, noise, np.inf).min(axis=1)
    allowed = np.where(np.isfinite(declared), SHARE_OF_NOISE * declared, UNDECLARED)
    error = chain.refine(pack(mechanism), allowed)
    return chain.mesh, np.asarray(error / allowed)
