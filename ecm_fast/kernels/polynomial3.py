"""Three polynomials of degree 3 in two or three variables, written out. Do not edit.

Written by `tools/write_polynomial.py`; what each function takes is explained in `polynomial`.
"""

from ._jit import call_kernel, kernel, step_kernel

__all__ = ["hoist2", "hoist3", "many2", "many3", "many_slopes2", "many_slopes3", "one2", "one3", "one_with_slopes2", "one_with_slopes3", "slopes2", "slopes3", "values2", "values3"]


@step_kernel
def hoist2(con):
    """Constants as locals: read inside a loop that writes an array, they would be read again for every point."""
    return con[0], con[1], con[2], con[3], con[4], con[5], con[6], con[7], con[8], con[9], con[10], con[11], con[12], con[13], con[14], con[15], con[16], con[17], con[18], con[19], con[20], con[21], con[22], con[23], con[24], con[25], con[26], con[27], con[28], con[29], con[30], con[31]


@step_kernel
def values2(c, u, v):
    """Three outputs at one point."""
    u, v = u - c[0], v - c[1]
    f0 = c[2] + v * (c[4] + v * (c[7] + v * (c[11]))) + u * (c[3] + v * (c[6] + v * (c[10])) + u * (c[5] + v * (c[9]) + u * (c[8])))
    f1 = c[12] + v * (c[14] + v * (c[17] + v * (c[21]))) + u * (c[13] + v * (c[16] + v * (c[20])) + u * (c[15] + v * (c[19]) + u * (c[18])))
    f2 = c[22] + v * (c[24] + v * (c[27] + v * (c[31]))) + u * (c[23] + v * (c[26] + v * (c[30])) + u * (c[25] + v * (c[29]) + u * (c[28])))
    return f0, f1, f2


@step_kernel
def slopes2(c, u, v):
    """Derivatives of the three outputs by the variables at one point, row by row."""
    u, v = u - c[0], v - c[1]
    f0_u = c[3] + v * (c[6] + v * (c[10])) + u * (2.0 * c[5] + v * (2.0 * c[9]) + u * (3.0 * c[8]))
    f0_v = c[4] + v * (2.0 * c[7] + v * (3.0 * c[11])) + u * (c[6] + v * (2.0 * c[10]) + u * (c[9]))
    f1_u = c[13] + v * (c[16] + v * (c[20])) + u * (2.0 * c[15] + v * (2.0 * c[19]) + u * (3.0 * c[18]))
    f1_v = c[14] + v * (2.0 * c[17] + v * (3.0 * c[21])) + u * (c[16] + v * (2.0 * c[20]) + u * (c[19]))
    f2_u = c[23] + v * (c[26] + v * (c[30])) + u * (2.0 * c[25] + v * (2.0 * c[29]) + u * (3.0 * c[28]))
    f2_v = c[24] + v * (2.0 * c[27] + v * (3.0 * c[31])) + u * (c[26] + v * (2.0 * c[30]) + u * (c[29]))
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
    return con[0], con[1], con[2], con[3], con[4], con[5], con[6], con[7], con[8], con[9], con[10], con[11], con[12], con[13], con[14], con[15], con[16], con[17], con[18], con[19], con[20], con[21], con[22], con[23], con[24], con[25], con[26], con[27], con[28], con[29], con[30], con[31], con[32], con[33], con[34], con[35], con[36], con[37], con[38], con[39], con[40], con[41], con[42], con[43], con[44], con[45], con[46], con[47], con[48], con[49], con[50], con[51], con[52], con[53], con[54], con[55], con[56], con[57], con[58], con[59], con[60], con[61], con[62]


@step_kernel
def values3(c, u, v, w):
    """Three outputs at one point."""
    u, v, w = u - c[0], v - c[1], w - c[2]
    f0 = c[3] + w * (c[6] + w * (c[12] + w * (c[22]))) + v * (c[5] + w * (c[11] + w * (c[21])) + v * (c[10] + w * (c[20]) + v * (c[19]))) + u * (c[4] + w * (c[9] + w * (c[18])) + v * (c[8] + w * (c[17]) + v * (c[16])) + u * (c[7] + w * (c[15]) + v * (c[14]) + u * (c[13])))
    f1 = c[23] + w * (c[26] + w * (c[32] + w * (c[42]))) + v * (c[25] + w * (c[31] + w * (c[41])) + v * (c[30] + w * (c[40]) + v * (c[39]))) + u * (c[24] + w * (c[29] + w * (c[38])) + v * (c[28] + w * (c[37]) + v * (c[36])) + u * (c[27] + w * (c[35]) + v * (c[34]) + u * (c[33])))
    f2 = c[43] + w * (c[46] + w * (c[52] + w * (c[62]))) + v * (c[45] + w * (c[51] + w * (c[61])) + v * (c[50] + w * (c[60]) + v * (c[59]))) + u * (c[44] + w * (c[49] + w * (c[58])) + v * (c[48] + w * (c[57]) + v * (c[56])) + u * (c[47] + w * (c[55]) + v * (c[54]) + u * (c[53])))
    return f0, f1, f2


@step_kernel
def slopes3(c, u, v, w):
    """Derivatives of the three outputs by the variables at one point, row by row."""
    u, v, w = u - c[0], v - c[1], w - c[2]
    f0_u = c[4] + w * (c[9] + w * (c[18])) + v * (c[8] + w * (c[17]) + v * (c[16])) + u * (2.0 * c[7] + w * (2.0 * c[15]) + v * (2.0 * c[14]) + u * (3.0 * c[13]))
    f0_v = c[5] + w * (c[11] + w * (c[21])) + v * (2.0 * c[10] + w * (2.0 * c[20]) + v * (3.0 * c[19])) + u * (c[8] + w * (c[17]) + v * (2.0 * c[16]) + u * (c[14]))
    f0_w = c[6] + w * (2.0 * c[12] + w * (3.0 * c[22])) + v * (c[11] + w * (2.0 * c[21]) + v * (c[20])) + u * (c[9] + w * (2.0 * c[18]) + v * (c[17]) + u * (c[15]))
    f1_u = c[24] + w * (c[29] + w * (c[38])) + v * (c[28] + w * (c[37]) + v * (c[36])) + u * (2.0 * c[27] + w * (2.0 * c[35]) + v * (2.0 * c[34]) + u * (3.0 * c[33]))
    f1_v = c[25] + w * (c[31] + w * (c[41])) + v * (2.0 * c[30] + w * (2.0 * c[40]) + v * (3.0 * c[39])) + u * (c[28] + w * (c[37]) + v * (2.0 * c[36]) + u * (c[34]))
    f1_w = c[26] + w * (2.0 * c[32] + w * (3.0 * c[42])) + v * (c[31] + w * (2.0 * c[41]) + v * (c[40])) + u * (c[29] + w * (2.0 * c[38]) + v * (c[37]) + u * (c[35]))
    f2_u = c[44] + w * (c[49] + w * (c[58])) + v * (c[48] + w * (c[57]) + v * (c[56])) + u * (2.0 * c[47] + w * (2.0 * c[55]) + v * (2.0 * c[54]) + u * (3.0 * c[53]))
    f2_v = c[45] + w * (c[51] + w * (c[61])) + v * (2.0 * c[50] + w * (2.0 * c[60]) + v * (3.0 * c[59])) + u * (c[48] + w * (c[57]) + v * (2.0 * c[56]) + u * (c[54]))
    f2_w = c[46] + w * (2.0 * c[52] + w * (3.0 * c[62])) + v * (c[51] + w * (2.0 * c[61]) + v * (c[60])) + u * (c[49] + w * (2.0 * c[58]) + v * (c[57]) + u * (c[55]))
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
