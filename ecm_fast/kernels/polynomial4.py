"""Three polynomials of degree 4 in two or three variables, written out. Do not edit.

Written by `tools/write_polynomial.py`; what each function takes is explained in `polynomial`.
"""

from ._jit import call_kernel, kernel, step_kernel

__all__ = ["hoist2", "hoist3", "many2", "many3", "many_slopes2", "many_slopes3", "one2", "one3", "one_with_slopes2", "one_with_slopes3", "slopes2", "slopes3", "values2", "values3"]


@step_kernel
def hoist2(con):
    """Constants as locals: read inside a loop that writes an array, they would be read again for every point."""
    return con[0], con[1], con[2], con[3], con[4], con[5], con[6], con[7], con[8], con[9], con[10], con[11], con[12], con[13], con[14], con[15], con[16], con[17], con[18], con[19], con[20], con[21], con[22], con[23], con[24], con[25], con[26], con[27], con[28], con[29], con[30], con[31], con[32], con[33], con[34], con[35], con[36], con[37], con[38], con[39], con[40], con[41], con[42], con[43], con[44], con[45], con[46]


@step_kernel
def values2(c, u, v):
    """Three outputs at one point."""
    u, v = u - c[0], v - c[1]
    f0 = c[2] + v * (c[4] + v * (c[7] + v * (c[11] + v * (c[16])))) + u * (c[3] + v * (c[6] + v * (c[10] + v * (c[15]))) + u * (c[5] + v * (c[9] + v * (c[14])) + u * (c[8] + v * (c[13]) + u * (c[12]))))
    f1 = c[17] + v * (c[19] + v * (c[22] + v * (c[26] + v * (c[31])))) + u * (c[18] + v * (c[21] + v * (c[25] + v * (c[30]))) + u * (c[20] + v * (c[24] + v * (c[29])) + u * (c[23] + v * (c[28]) + u * (c[27]))))
    f2 = c[32] + v * (c[34] + v * (c[37] + v * (c[41] + v * (c[46])))) + u * (c[33] + v * (c[36] + v * (c[40] + v * (c[45]))) + u * (c[35] + v * (c[39] + v * (c[44])) + u * (c[38] + v * (c[43]) + u * (c[42]))))
    return f0, f1, f2


@step_kernel
def slopes2(c, u, v):
    """Derivatives of the three outputs by the variables at one point, row by row."""
    u, v = u - c[0], v - c[1]
    f0_u = c[3] + v * (c[6] + v * (c[10] + v * (c[15]))) + u * (2.0 * c[5] + v * (2.0 * c[9] + v * (2.0 * c[14])) + u * (3.0 * c[8] + v * (3.0 * c[13]) + u * (4.0 * c[12])))
    f0_v = c[4] + v * (2.0 * c[7] + v * (3.0 * c[11] + v * (4.0 * c[16]))) + u * (c[6] + v * (2.0 * c[10] + v * (3.0 * c[15])) + u * (c[9] + v * (2.0 * c[14]) + u * (c[13])))
    f1_u = c[18] + v * (c[21] + v * (c[25] + v * (c[30]))) + u * (2.0 * c[20] + v * (2.0 * c[24] + v * (2.0 * c[29])) + u * (3.0 * c[23] + v * (3.0 * c[28]) + u * (4.0 * c[27])))
    f1_v = c[19] + v * (2.0 * c[22] + v * (3.0 * c[26] + v * (4.0 * c[31]))) + u * (c[21] + v * (2.0 * c[25] + v * (3.0 * c[30])) + u * (c[24] + v * (2.0 * c[29]) + u * (c[28])))
    f2_u = c[33] + v * (c[36] + v * (c[40] + v * (c[45]))) + u * (2.0 * c[35] + v * (2.0 * c[39] + v * (2.0 * c[44])) + u * (3.0 * c[38] + v * (3.0 * c[43]) + u * (4.0 * c[42])))
    f2_v = c[34] + v * (2.0 * c[37] + v * (3.0 * c[41] + v * (4.0 * c[46]))) + u * (c[36] + v * (2.0 * c[40] + v * (3.0 * c[45])) + u * (c[39] + v * (2.0 * c[44]) + u * (c[43])))
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
    return con[0], con[1], con[2], con[3], con[4], con[5], con[6], con[7], con[8], con[9], con[10], con[11], con[12], con[13], con[14], con[15], con[16], con[17], con[18], con[19], con[20], con[21], con[22], con[23], con[24], con[25], con[26], con[27], con[28], con[29], con[30], con[31], con[32], con[33], con[34], con[35], con[36], con[37], con[38], con[39], con[40], con[41], con[42], con[43], con[44], con[45], con[46], con[47], con[48], con[49], con[50], con[51], con[52], con[53], con[54], con[55], con[56], con[57], con[58], con[59], con[60], con[61], con[62], con[63], con[64], con[65], con[66], con[67], con[68], con[69], con[70], con[71], con[72], con[73], con[74], con[75], con[76], con[77], con[78], con[79], con[80], con[81], con[82], con[83], con[84], con[85], con[86], con[87], con[88], con[89], con[90], con[91], con[92], con[93], con[94], con[95], con[96], con[97], con[98], con[99], con[100], con[101], con[102], con[103], con[104], con[105], con[106], con[107]


@step_kernel
def values3(c, u, v, w):
    """Three outputs at one point."""
    u, v, w = u - c[0], v - c[1], w - c[2]
    f0 = c[3] + w * (c[6] + w * (c[12] + w * (c[22] + w * (c[37])))) + v * (c[5] + w * (c[11] + w * (c[21] + w * (c[36]))) + v * (c[10] + w * (c[20] + w * (c[35])) + v * (c[19] + w * (c[34]) + v * (c[33])))) + u * (c[4] + w * (c[9] + w * (c[18] + w * (c[32]))) + v * (c[8] + w * (c[17] + w * (c[31])) + v * (c[16] + w * (c[30]) + v * (c[29]))) + u * (c[7] + w * (c[15] + w * (c[28])) + v * (c[14] + w * (c[27]) + v * (c[26])) + u * (c[13] + w * (c[25]) + v * (c[24]) + u * (c[23]))))
    f1 = c[38] + w * (c[41] + w * (c[47] + w * (c[57] + w * (c[72])))) + v * (c[40] + w * (c[46] + w * (c[56] + w * (c[71]))) + v * (c[45] + w * (c[55] + w * (c[70])) + v * (c[54] + w * (c[69]) + v * (c[68])))) + u * (c[39] + w * (c[44] + w * (c[53] + w * (c[67]))) + v * (c[43] + w * (c[52] + w * (c[66])) + v * (c[51] + w * (c[65]) + v * (c[64]))) + u * (c[42] + w * (c[50] + w * (c[63])) + v * (c[49] + w * (c[62]) + v * (c[61])) + u * (c[48] + w * (c[60]) + v * (c[59]) + u * (c[58]))))
    f2 = c[73] + w * (c[76] + w * (c[82] + w * (c[92] + w * (c[107])))) + v * (c[75] + w * (c[81] + w * (c[91] + w * (c[106]))) + v * (c[80] + w * (c[90] + w * (c[105])) + v * (c[89] + w * (c[104]) + v * (c[103])))) + u * (c[74] + w * (c[79] + w * (c[88] + w * (c[102]))) + v * (c[78] + w * (c[87] + w * (c[101])) + v * (c[86] + w * (c[100]) + v * (c[99]))) + u * (c[77] + w * (c[85] + w * (c[98])) + v * (c[84] + w * (c[97]) + v * (c[96])) + u * (c[83] + w * (c[95]) + v * (c[94]) + u * (c[93]))))
    return f0, f1, f2


@step_kernel
def slopes3(c, u, v, w):
    """Derivatives of the three outputs by the variables at one point, row by row."""
    u, v, w = u - c[0], v - c[1], w - c[2]
    f0_u = c[4] + w * (c[9] + w * (c[18] + w * (c[32]))) + v * (c[8] + w * (c[17] + w * (c[31])) + v * (c[16] + w * (c[30]) + v * (c[29]))) + u * (2.0 * c[7] + w * (2.0 * c[15] + w * (2.0 * c[28])) + v * (2.0 * c[14] + w * (2.0 * c[27]) + v * (2.0 * c[26])) + u * (3.0 * c[13] + w * (3.0 * c[25]) + v * (3.0 * c[24]) + u * (4.0 * c[23])))
    f0_v = c[5] + w * (c[11] + w * (c[21] + w * (c[36]))) + v * (2.0 * c[10] + w * (2.0 * c[20] + w * (2.0 * c[35])) + v * (3.0 * c[19] + w * (3.0 * c[34]) + v * (4.0 * c[33]))) + u * (c[8] + w * (c[17] + w * (c[31])) + v * (2.0 * c[16] + w * (2.0 * c[30]) + v * (3.0 * c[29])) + u * (c[14] + w * (c[27]) + v * (2.0 * c[26]) + u * (c[24])))
    f0_w = c[6] + w * (2.0 * c[12] + w * (3.0 * c[22] + w * (4.0 * c[37]))) + v * (c[11] + w * (2.0 * c[21] + w * (3.0 * c[36])) + v * (c[20] + w * (2.0 * c[35]) + v * (c[34]))) + u * (c[9] + w * (2.0 * c[18] + w * (3.0 * c[32])) + v * (c[17] + w * (2.0 * c[31]) + v * (c[30])) + u * (c[15] + w * (2.0 * c[28]) + v * (c[27]) + u * (c[25])))
    f1_u = c[39] + w * (c[44] + w * (c[53] + w * (c[67]))) + v * (c[43] + w * (c[52] + w * (c[66])) + v * (c[51] + w * (c[65]) + v * (c[64]))) + u * (2.0 * c[42] + w * (2.0 * c[50] + w * (2.0 * c[63])) + v * (2.0 * c[49] + w * (2.0 * c[62]) + v * (2.0 * c[61])) + u * (3.0 * c[48] + w * (3.0 * c[60]) + v * (3.0 * c[59]) + u * (4.0 * c[58])))
    f1_v = c[40] + w * (c[46] + w * (c[56] + w * (c[71]))) + v * (2.0 * c[45] + w * (2.0 * c[55] + w * (2.0 * c[70])) + v * (3.0 * c[54] + w * (3.0 * c[69]) + v * (4.0 * c[68]))) + u * (c[43] + w * (c[52] + w * (c[66])) + v * (2.0 * c[51] + w * (2.0 * c[65]) + v * (3.0 * c[64])) + u * (c[49] + w * (c[62]) + v * (2.0 * c[61]) + u * (c[59])))
    f1_w = c[41] + w * (2.0 * c[47] + w * (3.0 * c[57] + w * (4.0 * c[72]))) + v * (c[46] + w * (2.0 * c[56] + w * (3.0 * c[71])) + v * (c[55] + w * (2.0 * c[70]) + v * (c[69]))) + u * (c[44] + w * (2.0 * c[53] + w * (3.0 * c[67])) + v * (c[52] + w * (2.0 * c[66]) + v * (c[65])) + u * (c[50] + w * (2.0 * c[63]) + v * (c[62]) + u * (c[60])))
    f2_u = c[74] + w * (c[79] + w * (c[88] + w * (c[102]))) + v * (c[78] + w * (c[87] + w * (c[101])) + v * (c[86] + w * (c[100]) + v * (c[99]))) + u * (2.0 * c[77] + w * (2.0 * c[85] + w * (2.0 * c[98])) + v * (2.0 * c[84] + w * (2.0 * c[97]) + v * (2.0 * c[96])) + u * (3.0 * c[83] + w * (3.0 * c[95]) + v * (3.0 * c[94]) + u * (4.0 * c[93])))
    f2_v = c[75] + w * (c[81] + w * (c[91] + w * (c[106]))) + v * (2.0 * c[80] + w * (2.0 * c[90] + w * (2.0 * c[105])) + v * (3.0 * c[89] + w * (3.0 * c[104]) + v * (4.0 * c[103]))) + u * (c[78] + w * (c[87] + w * (c[101])) + v * (2.0 * c[86] + w * (2.0 * c[100]) + v * (3.0 * c[99])) + u * (c[84] + w * (c[97]) + v * (2.0 * c[96]) + u * (c[94])))
    f2_w = c[76] + w * (2.0 * c[82] + w * (3.0 * c[92] + w * (4.0 * c[107]))) + v * (c[81] + w * (2.0 * c[91] + w * (3.0 * c[106])) + v * (c[90] + w * (2.0 * c[105]) + v * (c[104]))) + u * (c[79] + w * (2.0 * c[88] + w * (3.0 * c[102])) + v * (c[87] + w * (2.0 * c[101]) + v * (c[100])) + u * (c[85] + w * (2.0 * c[98]) + v * (c[97]) + u * (c[95])))
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
