"""The layout of the kernels' flat arrays, column by column.

loads (6,)      what acts, in the order of `L_*`
stations (n, S) one row per Gauss point: the section there, premultiplied (`S_*`)
tip (T,)        everything that acts at the head plate (`T_*`)
out (O,)        what a solve leaves (`O_*`)
"""

from ..mechanism.body import MOST

# fmt: off
# status of a solve; up to UNSTABLE there is an equilibrium. `equilibrium.Status` says what each means for a user
CONVERGED, UNSTABLE, NOT_CONVERGED, TENDON_ZERO_LENGTH, INVALID_INPUT, SECTION_UNSTABLE = range(6)

# loads: forces of the first two tendons [N], dead wrench at Q [N, N, N m]; then what acts without them, 1 but for load
# stepping: share of the weight, of the side force and of the zeros of the force cells, and share of what strains the
# beam (its curvature as built and the user's laws); then the forces of further tendons [N]
L_LAM_L, L_LAM_R, L_FX, L_FZ, L_TAU, L_GRAVITY, L_PRESTRAIN, L_LAM_3 = range(8)
N_TENDONS = MOST["tendon"]
N_LOADS = L_LAM_3 + N_TENDONS - 2

# stations: quadrature weight [m], 1/element length [1/m], EA, GA, EI, curvature as built [1/m],
# neutral axis offset [m], axial law (0 neo-Hookean, 1 Hooke), dead load per length in x and z [N/m]; 1 where any of
# what follows is there; sizes of the effects of the section's laws, see `effects.section`; place as a share of the
# length, number of the user's
# laws or 0, and the values of the user's effects; then how many guided tendons there are, and for each the place of
# its force among the loads, offset of the guide [m] and its slope [-], 1 + gain and zero [N] of its force cell
(S_WEIGHT, S_INV_H, S_EA, S_GA, S_EI, S_KAPPA0, S_OFFSET, S_HOOKE, S_LOAD_X, S_LOAD_Z, S_FURTHER, S_CUBIC,
 S_AMPLITUDE, S_ONE_SIDED, S_BIMODULUS, S_NEO_HOOKEAN, S_MOONEY, S_OGDEN, S_SHEAR_CUBIC, S_SHEAR_COMPRESSION,
 S_PLACE, S_LAW, S_USER) = range(23)
N_USER = 8  # values of effects of the user's own that a station has room for
S_GUIDES = S_USER + N_USER
S_GUIDE, N_GUIDE = S_GUIDES + 1, 5  # the five that are listed above
N_STATION = S_GUIDE + N_GUIDE * N_TENDONS


# tip: attachment of left and right tendon in the head frame [m], pulley centers [m], pulley radius at either tendon,
# above 0 where it turns the tendon's line from x towards z [m], center of mass in the head frame [m], head's weight in
# x and z [N], length of the beam [m], EI/length^2 [N], largest last Newton step [rad, shares of the length]; from force
# readings to forces: 1 + gain and zero [N] of either cell,
# nonlinearity [1/N], crosstalk; side force [N], springs across [N/m] and against turning [N m/rad]; 1 where any of
# what follows is there; stops on both sides and on one [N m/rad, rad], compliance of the plate's joint [rad/(N m)]
# and of the clamp in x, z, theta [m/N, m/N, rad/(N m)], tilt of the clamp [rad]; number of the user's laws or 0, and
# the values of the user's effects; then how many chords there are beside the first two tendons, and for each the place
# of its force among the loads, attachment and pulley center [m], radius with its sign [m], 1 + gain and zero [N]
(T_ATTACH_LX, T_ATTACH_LZ, T_ATTACH_RX, T_ATTACH_RZ, T_PULLEY_LX, T_PULLEY_LZ, T_PULLEY_RX, T_PULLEY_RZ,
 T_REACH_L, T_REACH_R, T_COM_X, T_COM_Z, T_WEIGHT_X, T_WEIGHT_Z, T_LENGTH, T_BENDING_FORCE,
 T_TOLERANCE, T_GAIN_L, T_GAIN_R, T_ZERO_L, T_ZERO_R, T_NONLINEARITY, T_CROSSTALK, T_SIDE, T_SPRING_Z, T_SPRING_T,
 T_FURTHER, T_STOP, T_STOP_ANGLE, T_STOP_1, T_STOP_1_ANGLE, T_JOINT, T_CLAMP_X, T_CLAMP_Z, T_CLAMP_T, T_CLAMP_TILT,
 T_LAW, T_USER) = range(38)
N_PAIR_TIP = T_USER + N_USER
T_CHORDS, T_CHORD, N_CHORD = N_PAIR_TIP, N_PAIR_TIP + 1, 8
N_TIP = T_CHORD + N_CHORD * (N_TENDONS - 2)


# past of a path, what a row inherits from the rows before it: lengths of both tendons [m] and tip angle [rad] at the
# last one, in which direction either tendon last travelled (1 pulled in, -1 let out), slider [-], tip angle that is
# remembered [rad], how far the tip is from it [rad]; of the row itself: time since the first one [h], time held [s],
# largest load so far as a share of the full one; and the time stamp of the first one [s], inf before it
(M_LENGTH_L, M_LENGTH_R, M_THETA, M_WAY_L, M_WAY_R, M_SLIDER, M_REMEMBERED, M_GAP, M_HOURS, M_HELD, M_PEAK,
 M_FIRST, N_PAST) = range(13)

# out: pose, Newton steps taken, share of tendon forces and wrench reached on the stable branch, share of the weight
# reached without them, tangent stiffness at Q (lower triangle xx, zx, zz, tx, tz, tt)
(O_X, O_Z, O_THETA, O_ITERATIONS, O_FACTOR, O_PRELOAD, O_KXX, O_KZX, O_KZZ, O_KTX, O_KTZ, O_KTT, N_OUT) = range(13)

# constants of the condensed formulation, one flat array: the tip's come first, then the clamp's angle [rad], the share
# of it in the tip's angle [rad], 1/length^2, 1/force^2 (a tip force that changes by this force counts as a turn of
# 1 rad), the shift of the scaled axial force, how rough the compliance is along the beam [-], the polynomials in the
# scaled axial force for the stretch and its slope, then eight
# numbers a Gauss point (weight [m], scale of the axial force [1/N], 1/EA, dead load beyond the point in x and z [N],
# 1/GA, the couple of clamp and curvature as built [N m], share of its angle in the tip's), then the stiffness of the
# angles [N m], lower triangle
N_STRETCH, N_SLOPE, N_POINT = 13, 9, 8
C_THETA0, C_TIP, C_INV_LENGTH2, C_INV_FORCE2, C_SHIFT, C_ROUGH, C_TOP_HEAVY, C_STRETCH = range(
    N_PAIR_TIP, N_PAIR_TIP + 8
)
C_SLOPE = C_STRETCH + N_STRETCH
C_STATION = C_SLOPE + N_SLOPE

# state of the condensed formulation, quantity after quantity: the load, what is solved for beside the angles, the
# verdict on the step; the wrench on the tip section, its stiffness, and each tendon's wrench by unit force; a bound
# of the discretization error; ...
(R_LAM_L, R_LAM_R, R_FX, R_FZ, R_TAU, R_X, R_Z, R_FORCE_X, R_FORCE_Z, R_THETA, R_SIZE, R_PIVOT, R_EXTREME,
 R_WX, R_WZ, R_WTAU, R_XX, R_XZ, R_ZZ, R_XT, R_ZT, R_TT, R_LX, R_LZ, R_LT, R_RX, R_RZ, R_RT, R_DOUBT,
 R_POINT) = range(30)
# ... then for each Gauss point its angle, and what the section there leaves for the step: stiffness against turning,
# couple of the contact force, less the tip displacement by angle in x and z, part of the tip position, compliance; ...
P_THETA, P_TURN, P_COUPLE, P_BX, P_BZ, P_DX, P_DZ, P_XX, P_XZ, P_ZZ, N_SECTION = range(11)
# ... then what the step keeps for derivatives: its factor and N_KEPT more. LANES load cases lie side by side in a
# batch, one alone in a control loop
LANES, N_KEPT = 64, 11

# The chain of elements: COLUMNS elements side by side, one quantity after the other, block after block.
# Its constants begin like those of the condensed formulation; then the order, the number of elements and the shape
# functions' values and derivatives by xi at the Gauss points; then the blocks
COLUMNS = 64
C_ORDER, C_COUNT, C_BASIS = range(C_STATION, C_STATION + 3)
# for each Gauss point of an element: weight [m], scale of the axial force [1/N], 1/EA, 1/GA, dead load beyond the
# point in x and z [N], weight * EI / element length^2 [N m], weight * EI * curvature as built / element length [N m];
# with the first point also the element's 1/(EI/length) [1/(N m)], and its EI/length as a share of the next element's
(B_WEIGHT, B_SCALE, B_BY_N, B_BY_Q, B_BEYOND_X, B_BEYOND_Z, B_BEND, B_CURVED, B_UNIT, B_RATIO,
 N_BEAM) = range(0, 11 * COLUMNS, COLUMNS)

# state of the chain, first what there is once: loads, tip pose, tip force, squared size of the last step, the number
# of pivots and angles not to be trusted so far, of negative pivots in this step; sums over the elements: closure
# [m], compliance at fixed angles, then what eliminating the angles adds to compliance and closure; wrench and load
# stiffness at the tip
(H_X, H_Z, H_THETA, H_FORCE_X, H_FORCE_Z, H_SIZE, H_DOUBT, H_NEGATIVE, H_DX, H_DZ, H_CXX, H_CXZ, H_CZZ,
 H_XX, H_XZ, H_ZZ, H_XR, H_ZR, H_WRENCH) = range(N_LOADS, N_LOADS + 19)
H_STIFFNESS = H_WRENCH + 3
N_HEAD = H_STIFFNESS + 6
# then block by block: the angles' stiffness at both ends of an element as shares of EI/length, the residual there
# [N m] and its derivatives by the tip force [m], the angle at the right end; then what the elimination of the left end
# leaves: its coupling to the right end, its residual and the tip force's columns, each divided by the pivot
(E_LL, E_LR, E_RR, E_RES_L, E_RES_R, E_X_L, E_X_R, E_Z_L, E_Z_R, E_RIGHT, E_COUPLING, E_RES, E_X, E_Z,
 N_ENDS) = range(0, 15 * COLUMNS, COLUMNS)
# and for each Gauss point, in the same block: the angle there, derivative of the residual by it, residual, and its
# derivatives by the tip force; and the angle at the node of that number, 0 the element's left end
(G_ANGLE, G_SLOPE, G_RES, G_X, G_Z, G_NODE, N_SAMPLES) = range(0, 7 * COLUMNS, COLUMNS)
# fmt: on
