"""Three polynomials of degree 1 in two or three variables, written out. Do not edit.

Written by `tools/write_polynomial.py`; what each function takes is explained in `polynomial`.
"""

from ._jit import call_kernel, kernel, step_kernel

__all__ = ["hoist2", "hoist3", "many2", "many3", "many_slopes2", "many_slopes3", "one2", "one3", "one_with_slopes2", "one_with_slopes3", "slopes2", "slopes3", "values2", "values3"]


@step_kernel
def hoist2(con):
    """Constants as locals: read inside a loop that writes an array, they would be read again for every point."""
    return con[0], con[1], con[2], con[3], con[4], con[5], con[6], con[7], con[8], con[9], con[10]


@step_kernel
def values2(c, u, v):
    """Three outputs at one point."""
    u, v = u - c[0], v - c[1]
    f0 = c[2] + v * (c[4]) + u * (c[3])
    f1 = c[5] + v * (c[7]) + u * (c[6])
    f2 = c[8] + v * (c[10]) + u * (c[9])
    return f0, f1, f2


@step_kernel
def slopes2(c, u, v):
    """Derivatives of the three outputs by the variables at one point, row by row."""
    u, v = u - c[0], v - c[1]
    f0_u = c[3]
    f0_v = c[4]
    f1_u = c[6]
    f1_v = c[7]
    f2_u = c[9]
    f2_v = c[10]
    return f0_u, f0_v, f1_u, f1_v, f2_u, f2_v


@call_kernel
def one2(con, u, v):
    """Three outputs at one point."""
    return values2(hoist2(con), u, v)


@call_kernel
def one_with_slopes2(con, u, v, slopes):
    """Three outputs at one point, and their derivatives into `slopes`."""
    c = hoist2(con)
    slopes[0, 0], slopes[0, 1], slopes[1, 0], slopes[1, 1], slopes[2, 0], slopes[2, 1] = slopes2(c, u, v)
    return values2(c, u, v)


@kernel
def many2(con, points, out):
    """Three outputs at every point; the compiler turns this loop into vector instructions."""
    c = hoist2(con)
    for i in range(points.shape[1]):
        out[0, i], out[1, i], out[2, i] = values2(c, points[0, i], points[1, i])


@kernel
def many_slopes2(con, points, out):
    """Derivatives of the three outputs at every point; the compiler turns this loop into vector instructions."""
    c = hoist2(con)
    for i in range(points.shape[1]):
        out[0, 0, i], out[0, 1, i], out[1, 0, i], out[1, 1, i], out[2, 0, i], out[2, 1, i] = slopes2(c, points[0, i], points[1, i])


@step_kernel
def hoist3(con):
    """Constants as locals: read inside a loop that writes an array, they would be read again for every point."""
    return con[0], con[1], con[2], con[3], con[4], con[5], con[6], con[7], con[8], con[9], con[10], con[11], con[12], con[13], con[14]


@step_kernel
def values3(c, u, v, w):
    """Three outputs at one point."""
    u, v, w = u - c[0], v - c[1], w - c[2]
    f0 = c[3] + w * (c[6]) + v * (c[5]) + u * (c[4])
    f1 = c[7] + w * (c[10]) + v * (c[9]) + u * (c[8])
    f2 = c[11] + w * (c[14]) + v * (c[13]) + u * (c[12])
    return f0, f1, f2


@step_kernel
def slopes3(c, u, v, w):
    """Derivatives of the three outputs by the variables at one point, row by row."""
    u, v, w = u - c[0], v - c[1], w - c[2]
    f0_u = c[4]
    f0_v = c[5]
    f0_w = c[6]
    f1_u = c[8]
    f1_v = c[9]
    f1_w = c[10]
    f2_u = c[12]
    f2_v = c[13]
    f2_w = c[14]
    return f0_u, f0_v, f0_w, f1_u, f1_v, f1_w, f2_u, f2_v, f2_w


@call_kernel
def one3(con, u, v, w):
    """Three outputs at one point."""
    return values3(hoist3(con), u, v, w)


@call_kernel
def one_with_slopes3(con, u, v, w, slopes):
    """Three outputs at one point, and their derivatives into `slopes`."""
    c = hoist3(con)
    slopes[0, 0], slopes[0, 1], slopes[0, 2], slopes[1, 0], slopes[1, 1], slopes[1, 2], slopes[2, 0], slopes[2, 1], slopes[2, 2] = slopes3(c, u, v, w)
    return values3(c, u, v, w)


@kernel
def many3(con, points, out):
    """Three outputs at every point; the compiler turns this loop into vector instructions."""
    c = hoist3(con)
    for i in range(points.shape[1]):
        out[0, i], out[1, i], out[2, i] = values3(c, points[0, i], points[1, i], points[2, i])


@kernel
def many_slopes3(con, points, out):
    """Derivatives of the three outputs at every point; the compiler turns this loop into vector instructions."""
    c = hoist3(con)
    for i in range(points.shape[1]):
        out[0, 0, i], out[0, 1, i], out[0, 2, i], out[1, 0, i], out[1, 1, i], out[1, 2, i], out[2, 0, i], out[2, 1, i], out[2, 2, i] = slopes3(c, points[0, i], points[1, i], points[2, i])
