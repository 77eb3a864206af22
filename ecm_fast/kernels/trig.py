"""Sine and cosine of one angle as plain arithmetic, real or complex, without a library call."""

import numpy as np

from ._jit import ordered_kernel, step_kernel

__all__ = ["NEAR", "sincos", "sincos_near"]

_TWO_OVER_PI = 2.0 / np.pi
# pi/2 in three parts of 33 bits and less (Cody & Waite 1980, section 8.1), so that n * part is exact for |n| < 2^20
_HALF_PI_1 = 1.57079632673412561417e00
_HALF_PI_2 = 6.07710050630396597660e-11
_HALF_PI_3 = 2.02226624879595063154e-21
# coefficients of the Taylor series of sine and cosine, on [-pi/4, pi/4]
_S3, _S5, _S7, _S9 = -1 / 6, 1 / 120, -1 / 5040, 1 / 362880
_S11, _S13, _S15 = -1 / 39916800, 1 / 6227020800, -1 / 1307674368000
_C4, _C6, _C8, _C10 = 1 / 24, -1 / 720, 1 / 40320, -1 / 3628800
_C12, _C14, _C16 = 1 / 479001600, -1 / 87178291200, 1 / 20922789888000

# `sincos_near` holds up to this angle [rad]; its coefficients interpolate sin t / t and cos t, in t^2, at Chebyshev
# points of [0, NEAR^2]
NEAR = 1.6
_N3, _N5, _N7 = -0.166666666666659, 0.00833333333327031, -0.000198412698215638
_N9, _N11, _N13, _N15 = 2.7557316196951017e-06, -2.505185572558516e-08, 1.6047346685140787e-10, -7.364331601228968e-13
_N2, _N4, _N6 = -0.49999999999999967, 0.04166666666666307, -0.0013888888888744474
_N8, _N10, _N12 = 2.4801587272556152e-05, -2.755731594453267e-07, 2.087653924157399e-09
_N14, _N16 = -1.1462309288889073e-11, 4.602690920668355e-14


@ordered_kernel
def sincos(t):
    """Sine and cosine of `t`, to 2e-16 for |t| < 1e5.

    t : [rad], real or complex (the range is reduced by the real part, so the complex step passes through)

    Taylor series on |r| <= pi/4 after reduction by multiples of pi/2: the first term left out is below 5e-17.
    Far outside the range, and for a non-finite angle, the result is not a sine; `newton` never steps that far.
    """
    n = np.rint(t.real * _TWO_OVER_PI)
    r = ((t - n * _HALF_PI_1) - n * _HALF_PI_2) - n * _HALF_PI_3
    r2 = r * r
    s = r + r * r2 * (_S3 + r2 * (_S5 + r2 * (_S7 + r2 * (_S9 + r2 * (_S11 + r2 * (_S13 + r2 * _S15))))))
    c = 1.0 - 0.5 * r2 + r2 * r2 * (_C4 + r2 * (_C6 + r2 * (_C8 + r2 * (_C10 + r2 * (_C12 + r2 * (_C14 + r2 * _C16))))))
    # n mod 4 without integers, which would not vectorize on every machine: 0, 1, 2 or 3
    quadrant = n - 4.0 * np.floor(0.25 * n)
    odd = quadrant - 2.0 * np.floor(0.5 * quadrant)
    sine = s if odd == 0.0 else c
    cosine = c if odd == 0.0 else s
    sine = -sine if quadrant >= 2.0 else sine
    cosine = -cosine if (quadrant == 1.0) or (quadrant == 2.0) else cosine
    return sine, cosine


@step_kernel
def sincos_near(t):
    """Sine and cosine to 1e-15 for |t| <= NEAR, without reduction: half the arithmetic, and two short chains each."""
    r = t * t
    v = r * r
    s = 1.0 + v * (_N5 + v * (_N9 + v * _N13)) + r * (_N3 + v * (_N7 + v * (_N11 + v * _N15)))
    even = 1.0 + v * (_N4 + v * (_N8 + v * (_N12 + v * _N16)))
    return t * s, even + r * (_N2 + v * (_N6 + v * (_N10 + v * _N14)))
