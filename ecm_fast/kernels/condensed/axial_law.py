"""The inverse of the axial law: stretch by axial force, as polynomials that hold in the range of a neck."""

import numpy as np

from .._jit import step_kernel
from ..layout import C_SLOPE, C_STRETCH, N_SLOPE, N_STRETCH

__all__ = ["HALF", "SHIFT", "stretch_at", "stretch_polynomials"]

# N/EA over which the polynomials for the stretch hold: from 9 % shortening to 4 % stretch
LOWEST, HIGHEST = -0.10, 0.04
HALF = 0.5 * (HIGHEST - LOWEST)
SHIFT = -0.5 * (HIGHEST + LOWEST) / HALF


def stretch_polynomials() -> np.ndarray:
    """Return the inverse axial law, one row for each law: stretch by scaled axial force, then its slope by N/EA.

    Shape (2, N_STRETCH + N_SLOPE): the neo-Hookean law's, then Hooke's. Interpolated at Chebyshev points.
    """
    u = np.cos(np.pi * (np.arange(N_STRETCH) + 0.5) / N_STRETCH)
    share = HALF * (u - SHIFT)
    stretch = np.ones(N_STRETCH)
    for _ in range(50):  # Newton's method for the law (19): share = (stretch - stretch^-2) / 3
        stretch -= (stretch**3 - 3.0 * share * stretch**2 - 1.0) / (3.0 * stretch**2 - 6.0 * share * stretch)
    slope = 3.0 * stretch**3 / (stretch**3 + 2.0)
    to_stretch = np.linalg.inv(np.vander(u, increasing=True))
    to_slope = np.linalg.pinv(np.vander(u, N_SLOPE, increasing=True))
    hooke = np.zeros(N_STRETCH + N_SLOPE)
    hooke[0], hooke[1], hooke[N_STRETCH] = 1.0 - HALF * SHIFT, HALF, 1.0
    return np.stack([np.concatenate([to_stretch @ stretch, to_slope @ slope]), hooke])


@step_kernel
def stretch_at(con, cr, cl, u):
    """Stretch and its slope at the scaled axial force `u`: two polynomials, each as two short Horner chains."""
    a, b = cr * C_STRETCH + cl, cr * C_SLOPE + cl
    v = u * u
    even = con[a + cr * 8] + v * (con[a + cr * 10] + v * con[a + cr * 12])
    even = con[a] + v * (con[a + cr * 2] + v * (con[a + cr * 4] + v * (con[a + cr * 6] + v * even)))
    odd = con[a + cr * 5] + v * (con[a + cr * 7] + v * (con[a + cr * 9] + v * con[a + cr * 11]))
    odd = con[a + cr] + v * (con[a + cr * 3] + v * odd)
    slope_even = con[b + cr * 4] + v * (con[b + cr * 6] + v * con[b + cr * 8])
    slope_even = con[b] + v * (con[b + cr * 2] + v * slope_even)
    slope_odd = con[b + cr] + v * (con[b + cr * 3] + v * (con[b + cr * 5] + v * con[b + cr * 7]))
    return even + u * odd, slope_even + u * slope_odd
