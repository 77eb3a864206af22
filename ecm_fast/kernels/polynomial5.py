"""Three polynomials of degree 5 in two or three variables, written out. Do not edit.

Written by `tools/write_polynomial.py`; what each function takes is explained in `polynomial`.
"""

from ._jit import call_kernel, kernel, step_kernel

__all__ = ["hoist2", "hoist3", "many2", "many3", "many_slopes2", "many_slopes3", "one2", "one3", "one_with_slopes2", "one_with_slopes3", "slopes2", "slopes3", "values2", "values3"]


@step_kernel
def hoist2(con):
    """Constants as locals: read inside a loop that writes an array, they would be read again for every point."""
    return con[0], con[1], con[2], con[3], con[4], con[5], con[6], con[7], con[8], con[9], con[10], con[11], con[12], con[13], con[14], con[15], con[16], con[17], con[18], con[19], con[20], con[21], con[22], con[23], con[24], con[25], con[26], con[27], con[28], con[29], con[30], con[31], con[32], con[33], con[34], con[35], con[36], con[37], con[38], con[39], con[40], con[41], con[42], con[43], con[44], con[45], con[46], con[47], con[48], con[49], con[50], con[51], con[52], con[53], con[54], con[55], con[56], con[57], con[58], con[59], con[60], con[61], con[62], con[63], con[64]


@step_kernel
def values2(c, u, v):
    """Three outputs at one point."""
    u, v = u - c[0], v - c[1]
    f0 = c[2] + v * (c[4] + v * (c[7] + v * (c[11] + v * (c[16] + v * (c[22]))))) + u * (c[3] + v * (c[6] + v * (c[10] + v * (c[15] + v * (c[21])))) + u * (c[5] + v * (c[9] + v * (c[14] + v * (c[20]))) + u * (c[8] + v * (c[13] + v * (c[19])) + u * (c[12] + v * (c[18]) + u * (c[17])))))
    f1 = c[23] + v * (c[25] + v * (c[28] + v * (c[32] + v * (c[37] + v * (c[43]))))) + u * (c[24] + v * (c[27] + v * (c[31] + v * (c[36] + v * (c[42])))) + u * (c[26] + v * (c[30] + v * (c[35] + v * (c[41]))) + u * (c[29] + v * (c[34] + v * (c[40])) + u * (c[33] + v * (c[39]) + u * (c[38])))))
    f2 = c[44] + v * (c[46] + v * (c[49] + v * (c[53] + v * (c[58] + v * (c[64]))))) + u * (c[45] + v * (c[48] + v * (c[52] + v * (c[57] + v * (c[63])))) + u * (c[47] + v * (c[51] + v * (c[56] + v * (c[62]))) + u * (c[50] + v * (c[55] + v * (c[61])) + u * (c[54] + v * (c[60]) + u * (c[59])))))
    return f0, f1, f2


@step_kernel
def slopes2(c, u, v):
    """Derivatives of the three outputs by the variables at one point, row by row."""
    u, v = u - c[0], v - c[1]
    f0_u = c[3] + v * (c[6] + v * (c[10] + v * (c[15] + v * (c[21])))) + u * (2.0 * c[5] + v * (2.0 * c[9] + v * (2.0 * c[14] + v * (2.0 * c[20]))) + u * (3.0 * c[8] + v * (3.0 * c[13] + v * (3.0 * c[19])) + u * (4.0 * c[12] + v * (4.0 * c[18]) + u * (5.0 * c[17]))))
    f0_v = c[4] + v * (2.0 * c[7] + v * (3.0 * c[11] + v * (4.0 * c[16] + v * (5.0 * c[22])))) + u * (c[6] + v * (2.0 * c[10] + v * (3.0 * c[15] + v * (4.0 * c[21]))) + u * (c[9] + v * (2.0 * c[14] + v * (3.0 * c[20])) + u * (c[13] + v * (2.0 * c[19]) + u * (c[18]))))
    f1_u = c[24] + v * (c[27] + v * (c[31] + v * (c[36] + v * (c[42])))) + u * (2.0 * c[26] + v * (2.0 * c[30] + v * (2.0 * c[35] + v * (2.0 * c[41]))) + u * (3.0 * c[29] + v * (3.0 * c[34] + v * (3.0 * c[40])) + u * (4.0 * c[33] + v * (4.0 * c[39]) + u * (5.0 * c[38]))))
    f1_v = c[25] + v * (2.0 * c[28] + v * (3.0 * c[32] + v * (4.0 * c[37] + v * (5.0 * c[43])))) + u * (c[27] + v * (2.0 * c[31] + v * (3.0 * c[36] + v * (4.0 * c[42]))) + u * (c[30] + v * (2.0 * c[35] + v * (3.0 * c[41])) + u * (c[34] + v * (2.0 * c[40]) + u * (c[39]))))
    f2_u = c[45] + v * (c[48] + v * (c[52] + v * (c[57] + v * (c[63])))) + u * (2.0 * c[47] + v * (2.0 * c[51] + v * (2.0 * c[56] + v * (2.0 * c[62]))) + u * (3.0 * c[50] + v * (3.0 * c[55] + v * (3.0 * c[61])) + u * (4.0 * c[54] + v * (4.0 * c[60]) + u * (5.0 * c[59]))))
    f2_v = c[46] + v * (2.0 * c[49] + v * (3.0 * c[53] + v * (4.0 * c[58] + v * (5.0 * c[64])))) + u * (c[48] + v * (2.0 * c[52] + v * (3.0 * c[57] + v * (4.0 * c[63]))) + u * (c[51] + v * (2.0 * c[56] + v * (3.0 * c[62])) + u * (c[55] + v * (2.0 * c[61]) + u * (c[60]))))
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
    return con[0], con[1], con[2], con[3], con[4], con[5], con[6], con[7], con[8], con[9], con[10], con[11], con[12], con[13], con[14], con[15], con[16], con[17], con[18], con[19], con[20], con[21], con[22], con[23], con[24], con[25], con[26], con[27], con[28], con[29], con[30], con[31], con[32], con[33], con[34], con[35], con[36], con[37], con[38], con[39], con[40], con[41], con[42], con[43], con[44], con[45], con[46], con[47], con[48], con[49], con[50], con[51], con[52], con[53], con[54], con[55], con[56], con[57], con[58], con[59], con[60], con[61], con[62], con[63], con[64], con[65], con[66], con[67], con[68], con[69], con[70], con[71], con[72], con[73], con[74], con[75], con[76], con[77], con[78], con[79], con[80], con[81], con[82], con[83], con[84], con[85], con[86], con[87], con[88], con[89], con[90], con[91], con[92], con[93], con[94], con[95], con[96], con[97], con[98], con[99], con[100], con[101], con[102], con[103], con[104], con[105], con[106], con[107], con[108], con[109], con[110], con[111], con[112], con[113], con[114], con[115], con[116], con[117], con[118], con[119], con[120], con[121], con[122], con[123], con[124], con[125], con[126], con[127], con[128], con[129], con[130], con[131], con[132], con[133], con[134], con[135], con[136], con[137], con[138], con[139], con[140], con[141], con[142], con[143], con[144], con[145], con[146], con[147], con[148], con[149], con[150], con[151], con[152], con[153], con[154], con[155], con[156], con[157], con[158], con[159], con[160], con[161], con[162], con[163], con[164], con[165], con[166], con[167], con[168], con[169], con[170]


@step_kernel
def values3(c, u, v, w):
    """Three outputs at one point."""
    u, v, w = u - c[0], v - c[1], w - c[2]
    f0 = c[3] + w * (c[6] + w * (c[12] + w * (c[22] + w * (c[37] + w * (c[58]))))) + v * (c[5] + w * (c[11] + w * (c[21] + w * (c[36] + w * (c[57])))) + v * (c[10] + w * (c[20] + w * (c[35] + w * (c[56]))) + v * (c[19] + w * (c[34] + w * (c[55])) + v * (c[33] + w * (c[54]) + v * (c[53]))))) + u * (c[4] + w * (c[9] + w * (c[18] + w * (c[32] + w * (c[52])))) + v * (c[8] + w * (c[17] + w * (c[31] + w * (c[51]))) + v * (c[16] + w * (c[30] + w * (c[50])) + v * (c[29] + w * (c[49]) + v * (c[48])))) + u * (c[7] + w * (c[15] + w * (c[28] + w * (c[47]))) + v * (c[14] + w * (c[27] + w * (c[46])) + v * (c[26] + w * (c[45]) + v * (c[44]))) + u * (c[13] + w * (c[25] + w * (c[43])) + v * (c[24] + w * (c[42]) + v * (c[41])) + u * (c[23] + w * (c[40]) + v * (c[39]) + u * (c[38])))))
    f1 = c[59] + w * (c[62] + w * (c[68] + w * (c[78] + w * (c[93] + w * (c[114]))))) + v * (c[61] + w * (c[67] + w * (c[77] + w * (c[92] + w * (c[113])))) + v * (c[66] + w * (c[76] + w * (c[91] + w * (c[112]))) + v * (c[75] + w * (c[90] + w * (c[111])) + v * (c[89] + w * (c[110]) + v * (c[109]))))) + u * (c[60] + w * (c[65] + w * (c[74] + w * (c[88] + w * (c[108])))) + v * (c[64] + w * (c[73] + w * (c[87] + w * (c[107]))) + v * (c[72] + w * (c[86] + w * (c[106])) + v * (c[85] + w * (c[105]) + v * (c[104])))) + u * (c[63] + w * (c[71] + w * (c[84] + w * (c[103]))) + v * (c[70] + w * (c[83] + w * (c[102])) + v * (c[82] + w * (c[101]) + v * (c[100]))) + u * (c[69] + w * (c[81] + w * (c[99])) + v * (c[80] + w * (c[98]) + v * (c[97])) + u * (c[79] + w * (c[96]) + v * (c[95]) + u * (c[94])))))
    f2 = c[115] + w * (c[118] + w * (c[124] + w * (c[134] + w * (c[149] + w * (c[170]))))) + v * (c[117] + w * (c[123] + w * (c[133] + w * (c[148] + w * (c[169])))) + v * (c[122] + w * (c[132] + w * (c[147] + w * (c[168]))) + v * (c[131] + w * (c[146] + w * (c[167])) + v * (c[145] + w * (c[166]) + v * (c[165]))))) + u * (c[116] + w * (c[121] + w * (c[130] + w * (c[144] + w * (c[164])))) + v * (c[120] + w * (c[129] + w * (c[143] + w * (c[163]))) + v * (c[128] + w * (c[142] + w * (c[162])) + v * (c[141] + w * (c[161]) + v * (c[160])))) + u * (c[119] + w * (c[127] + w * (c[140] + w * (c[159]))) + v * (c[126] + w * (c[139] + w * (c[158])) + v * (c[138] + w * (c[157]) + v * (c[156]))) + u * (c[125] + w * (c[137] + w * (c[155])) + v * (c[136] + w * (c[154]) + v * (c[153])) + u * (c[135] + w * (c[152]) + v * (c[151]) + u * (c[150])))))
    return f0, f1, f2


@step_kernel
def slopes3(c, u, v, w):
    """Derivatives of the three outputs by the variables at one point, row by row."""
    u, v, w = u - c[0], v - c[1], w - c[2]
    f0_u = c[4] + w * (c[9] + w * (c[18] + w * (c[32] + w * (c[52])))) + v * (c[8] + w * (c[17] + w * (c[31] + w * (c[51]))) + v * (c[16] + w * (c[30] + w * (c[50])) + v * (c[29] + w * (c[49]) + v * (c[48])))) + u * (2.0 * c[7] + w * (2.0 * c[15] + w * (2.0 * c[28] + w * (2.0 * c[47]))) + v * (2.0 * c[14] + w * (2.0 * c[27] + w * (2.0 * c[46])) + v * (2.0 * c[26] + w * (2.0 * c[45]) + v * (2.0 * c[44]))) + u * (3.0 * c[13] + w * (3.0 * c[25] + w * (3.0 * c[43])) + v * (3.0 * c[24] + w * (3.0 * c[42]) + v * (3.0 * c[41])) + u * (4.0 * c[23] + w * (4.0 * c[40]) + v * (4.0 * c[39]) + u * (5.0 * c[38]))))
    f0_v = c[5] + w * (c[11] + w * (c[21] + w * (c[36] + w * (c[57])))) + v * (2.0 * c[10] + w * (2.0 * c[20] + w * (2.0 * c[35] + w * (2.0 * c[56]))) + v * (3.0 * c[19] + w * (3.0 * c[34] + w * (3.0 * c[55])) + v * (4.0 * c[33] + w * (4.0 * c[54]) + v * (5.0 * c[53])))) + u * (c[8] + w * (c[17] + w * (c[31] + w * (c[51]))) + v * (2.0 * c[16] + w * (2.0 * c[30] + w * (2.0 * c[50])) + v * (3.0 * c[29] + w * (3.0 * c[49]) + v * (4.0 * c[48]))) + u * (c[14] + w * (c[27] + w * (c[46])) + v * (2.0 * c[26] + w * (2.0 * c[45]) + v * (3.0 * c[44])) + u * (c[24] + w * (c[42]) + v * (2.0 * c[41]) + u * (c[39]))))
    f0_w = c[6] + w * (2.0 * c[12] + w * (3.0 * c[22] + w * (4.0 * c[37] + w * (5.0 * c[58])))) + v * (c[11] + w * (2.0 * c[21] + w * (3.0 * c[36] + w * (4.0 * c[57]))) + v * (c[20] + w * (2.0 * c[35] + w * (3.0 * c[56])) + v * (c[34] + w * (2.0 * c[55]) + v * (c[54])))) + u * (c[9] + w * (2.0 * c[18] + w * (3.0 * c[32] + w * (4.0 * c[52]))) + v * (c[17] + w * (2.0 * c[31] + w * (3.0 * c[51])) + v * (c[30] + w * (2.0 * c[50]) + v * (c[49]))) + u * (c[15] + w * (2.0 * c[28] + w * (3.0 * c[47])) + v * (c[27] + w * (2.0 * c[46]) + v * (c[45])) + u * (c[25] + w * (2.0 * c[43]) + v * (c[42]) + u * (c[40]))))
    f1_u = c[60] + w * (c[65] + w * (c[74] + w * (c[88] + w * (c[108])))) + v * (c[64] + w * (c[73] + w * (c[87] + w * (c[107]))) + v * (c[72] + w * (c[86] + w * (c[106])) + v * (c[85] + w * (c[105]) + v * (c[104])))) + u * (2.0 * c[63] + w * (2.0 * c[71] + w * (2.0 * c[84] + w * (2.0 * c[103]))) + v * (2.0 * c[70] + w * (2.0 * c[83] + w * (2.0 * c[102])) + v * (2.0 * c[82] + w * (2.0 * c[101]) + v * (2.0 * c[100]))) + u * (3.0 * c[69] + w * (3.0 * c[81] + w * (3.0 * c[99])) + v * (3.0 * c[80] + w * (3.0 * c[98]) + v * (3.0 * c[97])) + u * (4.0 * c[79] + w * (4.0 * c[96]) + v * (4.0 * c[95]) + u * (5.0 * c[94]))))
    f1_v = c[61] + w * (c[67] + w * (c[77] + w * (c[92] + w * (c[113])))) + v * (2.0 * c[66] + w * (2.0 * c[76] + w * (2.0 * c[91] + w * (2.0 * c[112]))) + v * (3.0 * c[75] + w * (3.0 * c[90] + w * (3.0 * c[111])) + v * (4.0 * c[89] + w * (4.0 * c[110]) + v * (5.0 * c[109])))) + u * (c[64] + w * (c[73] + w * (c[87] + w * (c[107]))) + v * (2.0 * c[72] + w * (2.0 * c[86] + w * (2.0 * c[106])) + v * (3.0 * c[85] + w * (3.0 * c[105]) + v * (4.0 * c[104]))) + u * (c[70] + w * (c[83] + w * (c[102])) + v * (2.0 * c[82] + w * (2.0 * c[101]) + v * (3.0 * c[100])) + u * (c[80] + w * (c[98]) + v * (2.0 * c[97]) + u * (c[95]))))
    f1_w = c[62] + w * (2.0 * c[68] + w * (3.0 * c[78] + w * (4.0 * c[93] + w * (5.0 * c[114])))) + v * (c[67] + w * (2.0 * c[77] + w * (3.0 * c[92] + w * (4.0 * c[113]))) + v * (c[76] + w * (2.0 * c[91] + w * (3.0 * c[112])) + v * (c[90] + w * (2.0 * c[111]) + v * (c[110])))) + u * (c[65] + w * (2.0 * c[74] + w * (3.0 * c[88] + w * (4.0 * c[108]))) + v * (c[73] + w * (2.0 * c[87] + w * (3.0 * c[107])) + v * (c[86] + w * (2.0 * c[106]) + v * (c[105]))) + u * (c[71] + w * (2.0 * c[84] + w * (3.0 * c[103])) + v * (c[83] + w * (2.0 * c[102]) + v * (c[101])) + u * (c[81] + w * (2.0 * c[99]) + v * (c[98]) + u * (c[96]))))
    f2_u = c[116] + w * (c[121] + w * (c[130] + w * (c[144] + w * (c[164])))) + v * (c[120] + w * (c[129] + w * (c[143] + w * (c[163]))) + v * (c[128] + w * (c[142] + w * (c[162])) + v * (c[141] + w * (c[161]) + v * (c[160])))) + u * (2.0 * c[119] + w * (2.0 * c[127] + w * (2.0 * c[140] + w * (2.0 * c[159]))) + v * (2.0 * c[126] + w * (2.0 * c[139] + w * (2.0 * c[158])) + v * (2.0 * c[138] + w * (2.0 * c[157]) + v * (2.0 * c[156]))) + u * (3.0 * c[125] + w * (3.0 * c[137] + w * (3.0 * c[155])) + v * (3.0 * c[136] + w * (3.0 * c[154]) + v * (3.0 * c[153])) + u * (4.0 * c[135] + w * (4.0 * c[152]) + v * (4.0 * c[151]) + u * (5.0 * c[150]))))
    f2_v = c[117] + w * (c[123] + w * (c[133] + w * (c[148] + w * (c[169])))) + v * (2.0 * c[122] + w * (2.0 * c[132] + w * (2.0 * c[147] + w * (2.0 * c[168]))) + v * (3.0 * c[131] + w * (3.0 * c[146] + w * (3.0 * c[167])) + v * (4.0 * c[145] + w * (4.0 * c[166]) + v * (5.0 * c[165])))) + u * (c[120] + w * (c[129] + w * (c[143] + w * (c[163]))) + v * (2.0 * c[128] + w * (2.0 * c[142] + w * (2.0 * c[162])) + v * (3.0 * c[141] + w * (3.0 * c[161]) + v * (4.0 * c[160]))) + u * (c[126] + w * (c[139] + w * (c[158])) + v * (2.0 * c[138] + w * (2.0 * c[157]) + v * (3.0 * c[156])) + u * (c[136] + w * (c[154]) + v * (2.0 * c[153]) + u * (c[151]))))
    f2_w = c[118] + w * (2.0 * c[124] + w * (3.0 * c[134] + w * (4.0 * c[149] + w * (5.0 * c[170])))) + v * (c[123] + w * (2.0 * c[133] + w * (3.0 * c[148] + w * (4.0 * c[169]))) + v * (c[132] + w * (2.0 * c[147] + w * (3.0 * c[168])) + v * (c[146] + w * (2.0 * c[167]) + v * (c[166])))) + u * (c[121] + w * (2.0 * c[130] + w * (3.0 * c[144] + w * (4.0 * c[164]))) + v * (c[129] + w * (2.0 * c[143] + w * (3.0 * c[163])) + v * (c[142] + w * (2.0 * c[162]) + v * (c[161]))) + u * (c[127] + w * (2.0 * c[140] + w * (3.0 * c[159])) + v * (c[139] + w * (2.0 * c[158]) + v * (c[157])) + u * (c[137] + w * (2.0 * c[155]) + v * (c[154]) + u * (c[152]))))
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
