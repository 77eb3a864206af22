"""Write the straight-line Newton steps of the fast path, `ecm_fast/kernels/condensed3.py` to `condensed6.py`.

    python tools/write_condensed.py [--check]

The step is written out, without loops, because only then does the compiler vectorize a loop over load cases around
it. What the step computes is stated in `ecm_fast/kernels/condensed.py`; read it here, where the loops still are loops.
"""

import argparse
import math
from fractions import Fraction
from pathlib import Path

from ecm_fast.kernels.layout import N_SLOPE, N_STRETCH

FOLDER = Path(__file__).resolve().parent.parent / "ecm_fast" / "kernels"
ORDERS = (3, 4, 5, 6)
# angles up to this are fitted without reduction by multiples of pi/2; beyond it the robust path takes over
MAX_ANGLE, N_SIN, N_COS = 1.6, 8, 9

HEADER = '''\
"""Newton's step of the condensed formulation for one element of order {p}, written out. Do not edit.

Written by `tools/write_condensed.py`; the formulation is explained in `condensed`.
"""

import math

import numpy as np

from ._jit import kernel, step_kernel
from .condensed import LARGEST2, MAX_STEPS, SHRINK2, TOLERANCE2, largest_step, restart_lane, start_lane, vouches
from .layout import (
    C_INV_FORCE2,
    C_INV_LENGTH2,
    C_SHIFT,
    C_SLOPE,
    C_STATION,
    C_STRETCH,
    C_THETA0,
    CONVERGED,
    INVALID_INPUT,
    LANES,
    NOT_CONVERGED,
    R_EXTREME,
    R_FORCE_X,
    R_FORCE_Z,
    R_FX,
    R_FZ,
    R_KAPPA,
    R_LAM_L,
    R_LAM_R,
    R_PIVOT,
    R_SIZE,
    R_TAU,
    R_THETA,
    R_X,
    R_Z,
    T_ATTACH_LX,
    T_ATTACH_LZ,
    T_ATTACH_RX,
    T_ATTACH_RZ,
    T_COM_X,
    T_COM_Z,
    T_PULLEY_LX,
    T_PULLEY_LZ,
    T_PULLEY_RX,
    T_PULLEY_RZ,
    T_RADIUS,
    T_WEIGHT_X,
    T_WEIGHT_Z,
)

__all__ = ["advance", "solve_block", "step", "sweep"]


@step_kernel
def step(con, state, j):
    """Take one Newton step for the load case in column `j`; see `condensed`."""
'''

FOOTER = '''

@kernel
def sweep(con, state):
    """Take one Newton step for every lane; the compiler turns this loop into vector instructions."""
    for j in range(LANES):
        step(con, state, j)


@kernel
def solve_block(con, loads, state, pose, status):
    """Solve load cases from the straight beam, LANES at a time.

    loads : (n, N_LOADS)
    state : (state_size,)   work space
    pose : (n, 3), status : (n,)   overwritten; CONVERGED, or NOT_CONVERGED where the robust solver must decide
    """
    n = loads.shape[0]
    for first in range(0, n, LANES):
        for j in range(LANES):
            start_lane(con, loads[min(first + j, n - 1)], state, j)
        for _ in range(MAX_STEPS):
            sweep(con, state)
            if largest_step(state) < TOLERANCE2:
                break
        for j in range(min(LANES, n - first)):
            i = first + j
            pose[i, 0], pose[i, 1], pose[i, 2] = state[R_X + j], state[R_Z + j], state[R_THETA + j]
            status[i] = CONVERGED if vouches(state, j) else NOT_CONVERGED


@kernel
def advance(con, state, lam_l, lam_r):
    """Follow one load case, lane 0, to new tendon forces; starts again from the straight beam where that fails.

    Returns x, z, theta, status; see `condensed`.
    """
    state[R_LAM_L], state[R_LAM_R] = lam_l, lam_r
    if not (0.0 <= lam_l < np.inf and 0.0 <= lam_r < np.inf):
        return np.nan, np.nan, np.nan, INVALID_INPUT
    warm = vouches(state, 0)
    for attempt in range(2):
        if attempt == 0 and not warm:
            continue
        if attempt == 1:
            restart_lane(con, state, 0)
        state[R_SIZE], state[R_PIVOT], state[R_EXTREME] = np.inf, np.inf, 0.0
        for _ in range(MAX_STEPS):
            step(con, state, 0)
            if not state[R_SIZE] > TOLERANCE2:
                break
        if vouches(state, 0):
            return state[R_X], state[R_Z], state[R_THETA], CONVERGED
    return np.nan, np.nan, np.nan, NOT_CONVERGED
'''


def fit_in_square(first: int, n: int) -> list[float]:
    """Return n coefficients, in t^2, of cos t (`first` 0) or sin t / t (`first` 1), interpolated up to MAX_ANGLE.

    At Chebyshev points rounded to six digits, and in fractions, so that every machine writes the same digits.
    """
    places = [0.5 * MAX_ANGLE**2 * (1.0 + math.cos(math.pi * (k + 0.5) / n)) for k in range(n)]
    square = [Fraction(round(place * 1e6), 10**6) for place in places]
    table = [sum(Fraction((-1) ** k, math.factorial(2 * k + first)) * s**k for k in range(25)) for s in square]
    for k in range(1, n):
        for i in range(n - 1, k - 1, -1):
            table[i] = (table[i] - table[i - 1]) / (square[i] - square[i - k])
    powers = [Fraction(0)] * n
    for value, place in zip(reversed(table), reversed(square), strict=True):
        powers = [below - place * own for below, own in zip([Fraction(0), *powers[:-1]], powers, strict=True)]
        powers[0] += value
    return [float(value) for value in powers]


def estrin(coefficients: list[str], variable: str) -> str:
    """Return a polynomial in x as two interleaved Horner chains in x^2, named `{variable}2`: half as deep."""
    even, odd = horner(coefficients[0::2], f"{variable}2"), horner(coefficients[1::2], f"{variable}2")
    return f"({even}) + {variable} * ({odd})"


def row(name: str) -> str:
    """Return where a quantity of the load case in lane `j` stands."""
    return f"state[R_{name} + j]"


def dot(left: list[str], right: list[str]) -> str:
    """Return the sum of products of two lists of names."""
    return " + ".join(f"{a} * {b}" for a, b in zip(left, right, strict=True))


def horner(coefficients: list[str], variable: str) -> str:
    """Return a polynomial in Horner form."""
    text = coefficients[-1]
    for value in reversed(coefficients[:-1]):
        text = f"{value} + {variable} * ({text})"
    return text


SIN = [repr(value) for value in fit_in_square(1, N_SIN)]
COS = [repr(value) for value in fit_in_square(0, N_COS)]


def K(i: int, j: int) -> str:
    """Return the name of an entry of the tangent: the tip position's rows are stored below the curvatures'."""
    return f"K{max(i, j)}_{min(i, j)}"


class Writer:
    """Collects the lines of one step."""

    def __init__(self, p: int) -> None:
        self.p, self.lines = p, []
        self.points = range(p)

    def say(self, comment: str) -> None:
        self.lines.append(f"    # {comment}")

    def set(self, name: str, value: str) -> None:
        self.lines.append(f"    {name} = {value}")

    def station(self, g: int, column: int) -> str:
        return f"con[C_STATION + {8 * g + column}]"

    def turn(self, g: int, h: int) -> str:
        return f"con[C_STATION + {8 * self.p + self.p * g + h}]"

    def names(self, stem: str) -> list[str]:
        return [f"{stem}{g}" for g in self.points]

    def read(self) -> None:
        self.say("state: curvatures at the Gauss points, tip position, tip force")
        for g in self.points:
            self.set(f"k{g}", row(f"KAPPA + {g} * LANES"))
        self.set("x, z, f_x, f_z", ", ".join(map(row, ("X", "Z", "FORCE_X", "FORCE_Z"))))
        for g in self.points:
            self.set(f"w{g}", self.station(g, 0))
        self.say("angles: the clamp's plus the integral of the curvature")
        for g in self.points:
            self.set(f"t{g}", "con[C_THETA0] + " + dot([self.turn(g, h) for h in self.points], self.names("k")))
        self.set("t_tip", "con[C_THETA0] + " + dot(self.names("w"), self.names("k")))

    def sincos(self, angle: str) -> None:
        self.set("r2", f"{angle} * {angle}")
        self.set("r22", "r2 * r2")
        self.set("s", f"{angle} * ({estrin(SIN, 'r2')})")
        self.set("c", estrin(COS, "r2"))
        self.set("extreme", f"r2 * {1.0 / MAX_ANGLE**2!r} if r2 * {1.0 / MAX_ANGLE**2!r} > extreme else extreme")

    def sections(self) -> None:
        stretch = [f"con[C_STRETCH + {k}]" for k in range(N_STRETCH)]
        slope = [f"con[C_SLOPE + {k}]" for k in range(N_SLOPE)]
        self.set("extreme", row("EXTREME"))
        for g in self.points:
            self.say(f"Gauss point {g}: the force there is known, so stretch and shear follow from it")
            self.sincos(f"t{g}")
            self.set("n_x, n_z", f"f_x + {self.station(g, 5)}, f_z + {self.station(g, 6)}")
            self.set("N, Q", "n_x * c - n_z * s, n_x * s + n_z * c")
            self.set("u", f"N * {self.station(g, 1)} + con[C_SHIFT]")
            self.set("u2", "u * u")
            self.set("stretch", estrin(stretch, "u"))
            self.set("by_N", f"{self.station(g, 2)} * ({estrin(slope, 'u')})")
            self.set("extreme", "u2 if u2 > extreme else extreme")
            self.set("by_Q", self.station(g, 7))
            self.set("shear", "Q * by_Q")
            self.set(f"a{g}", f"w{g} * (Q * (shear - Q * by_N) + N * (stretch - N * by_Q))")
            self.set("along, across", f"w{g} * (Q * by_N - shear), w{g} * (stretch - N * by_Q)")
            self.set(f"bx{g}, bz{g}", "along * c + across * s, across * c - along * s")
            self.set(f"m{g}", f"w{g} * (Q * stretch - N * shear)")
            self.set(f"dx{g}, dz{g}", f"w{g} * (stretch * c + shear * s), w{g} * (shear * c - stretch * s)")
            self.set(f"cxx{g}", f"w{g} * (c * c * by_N + s * s * by_Q)")
            self.set(f"cxz{g}", f"w{g} * s * c * (by_Q - by_N)")
            self.set(f"czz{g}", f"w{g} * (s * s * by_N + c * c * by_Q)")
        for name in ("cxx", "cxz", "czz", "dx", "dz"):
            self.set(name, " + ".join(self.names(name)))

    def tip(self) -> None:
        self.say("head plate: tendons, head's weight, dead wrench, and their stiffness")
        self.sincos("t_tip")
        self.lines += [
            "    r_x, r_z = con[T_COM_X] * c + con[T_COM_Z] * s, con[T_COM_Z] * c - con[T_COM_X] * s",
            "    weight_x, weight_z = con[T_WEIGHT_X], con[T_WEIGHT_Z]",
            "    F_x, F_z = state[R_FX + j] + weight_x, state[R_FZ + j] + weight_z",
            "    tau = state[R_TAU + j] + r_z * weight_x - r_x * weight_z",
            "    H_tt = r_x * weight_x + r_z * weight_z",
        ]
        for name, tension, side in (("L", "LAM_L", "-"), ("R", "LAM_R", "")):
            a_x, a_z, c_x, c_z = (f"con[T_{kind}_{name}{axis}]" for kind in ("ATTACH", "PULLEY") for axis in "XZ")
            self.lines += [
                f"    r_x, r_z = {a_x} * c + {a_z} * s, {a_z} * c - {a_x} * s",
                f"    v_x, v_z, reach = {c_x} - x - r_x, {c_z} - z - r_z, {side}con[T_RADIUS]",
                "    square = v_x * v_x + v_z * v_z",
                "    free = math.sqrt(square - reach * reach)",
                "    inv = 1.0 / (square * free)",
                "    by_square = inv * free",
                "    e_x, e_z = (free * v_x - reach * v_z) * by_square, (free * v_z + reach * v_x) * by_square",
                f"    lam = {row(tension)}",
                "    pull_x, pull_z, stiff = lam * e_x, lam * e_z, lam * inv * square",
                "    e_t = -e_z * r_z - e_x * r_x",
            ]
            first = name == "L"
            for target, value in (
                ("H_xx", "stiff * e_z * e_z"),
                ("H_xz", "-stiff * e_z * e_x"),
                ("H_zz", "stiff * e_x * e_x"),
                ("H_xt", "-stiff * e_z * e_t"),
                ("H_zt", "stiff * e_x * e_t"),
            ):
                self.set(target, value if first else f"{target} + {value}")
            self.set("H_tt", "H_tt + stiff * e_t * e_t + pull_x * r_x + pull_z * r_z")
            self.set("F_x, F_z", "F_x + pull_x, F_z + pull_z")
            self.set("tau", "tau + r_z * pull_x - r_x * pull_z")

    def system(self) -> None:
        p = self.p
        self.say("eliminate the tip force: its 2 x 2 compliance is positive, so what is left is positive where stable")
        self.set("inv", "1.0 / (cxx * czz - cxz * cxz)")
        self.set("i_xx, i_xz, i_zz", "czz * inv, -cxz * inv, cxx * inv")
        self.set("gap_x, gap_z", "x - (dx), z - (dz)")
        self.set("g_x, g_z", "i_xx * gap_x + i_xz * gap_z, i_xz * gap_x + i_zz * gap_z")
        for h in self.points:
            column = [self.turn(g, h) for g in self.points]
            self.set(f"X{h}, Z{h}", f"{dot(column, self.names('bx'))}, {dot(column, self.names('bz'))}")
            self.set(f"Y{h}, V{h}", f"i_xx * X{h} + i_xz * Z{h}, i_xz * X{h} + i_zz * Z{h}")
            bending = f"{self.station(h, 3)} * k{h} - {self.station(h, 4)}"
            force = f"{dot(column, self.names('m'))} - w{h} * tau + X{h} * g_x + Z{h} * g_z"
            self.set(f"b{h}", f"-({bending} + {force})")
        self.set(f"b{p}, b{p + 1}", "F_x - f_x - g_x, F_z - f_z - g_z")
        self.say("tangent by the curvatures and the tip position, lower triangle")
        for h in self.points:
            for g in self.points:
                self.set(f"A{g}", f"{self.turn(g, h)} * a{g}")
            self.set(f"u{h}", f"w{h} * H_tt")
            for k in range(h + 1):
                terms = [self.station(h, 3)] if h == k else []
                terms += [f"A{g} * {self.turn(g, k)}" for g in self.points]
                terms += [f"Y{h} * X{k}", f"V{h} * Z{k}", f"u{h} * w{k}"]
                self.set(f"K{h}_{k}", " + ".join(terms))
        self.set_rows()

    def set_rows(self) -> None:
        p = self.p
        for k in self.points:
            self.set(f"K{p}_{k}", f"Y{k} + w{k} * H_xt")
            self.set(f"K{p + 1}_{k}", f"V{k} + w{k} * H_zt")
        self.set(f"K{p}_{p}", "i_xx + H_xx")
        self.set(f"K{p + 1}_{p}", "i_xz + H_xz")
        self.set(f"K{p + 1}_{p + 1}", "i_zz + H_zz")

    def solve(self) -> None:
        p = self.p
        self.say("factor by blocks of two, tip position first; the pivots' signs certify stability")
        blocks = [[p, p + 1]] + [list(range(k, min(k + 2, p))) for k in range(0, p, 2)]
        remaining = [*range(p)]
        self.set("pivot", row("PIVOT"))
        for block in blocks:
            remaining = [m for m in remaining if m not in block]
            self.invert(block)
            for m in remaining:
                for i in block:
                    self.set(f"L{m}_{i}", " + ".join(f"{K(m, k)} * I{max(i, k)}_{min(i, k)}" for k in block))
            for m in remaining:
                for n in [n for n in remaining if n <= m]:
                    self.set(K(m, n), K(m, n) + "".join(f" - L{m}_{i} * {K(n, i)}" for i in block))
                self.set(f"b{m}", f"b{m}" + "".join(f" - L{m}_{i} * b{i}" for i in block))
        later: list[int] = []
        for block in reversed(blocks):
            values = []
            for i in block:
                own = " + ".join(f"I{max(i, k)}_{min(i, k)} * b{k}" for k in block)
                values.append(own + "".join(f" - L{m}_{i} * b{m}" for m in later))
            self.set(", ".join(f"b{i}" for i in block), ", ".join(values))
            later = [*block, *later]

    def invert(self, block: list[int]) -> None:
        i, j = block[0], block[-1]
        smaller = "{0} if {0} < pivot else pivot"
        if i == j:
            self.set(f"I{i}_{i}", f"1.0 / {K(i, i)}")
            self.set("pivot", smaller.format(K(i, i)))
            return
        self.set("det", f"{K(i, i)} * {K(j, j)} - {K(j, i)} * {K(j, i)}")
        self.set("inv", "1.0 / det")
        self.set(f"I{i}_{i}, I{j}_{i}, I{j}_{j}", f"{K(j, j)} * inv, -{K(j, i)} * inv, {K(i, i)} * inv")
        self.set("pivot", smaller.format(K(i, i)))
        self.set("pivot", smaller.format("det"))

    def write(self) -> None:
        p = self.p
        own = self.names("b")
        self.say("step, and the tip force that goes with it")
        self.set("step_x", f"b{p} + gap_x + {dot(self.names('X'), own)}")
        self.set("step_z", f"b{p + 1} + gap_z + {dot(self.names('Z'), own)}")
        for g in self.points:
            self.set(row(f"KAPPA + {g} * LANES"), f"k{g} + b{g}")
        self.set(row("X"), f"x + b{p}")
        self.set(row("Z"), f"z + b{p + 1}")
        self.set("b_x, b_z", "i_xx * step_x + i_xz * step_z, i_xz * step_x + i_zz * step_z")
        self.set(row("FORCE_X"), "f_x + b_x")
        self.set(row("FORCE_Z"), "f_z + b_z")
        self.set("turned", dot(self.names("w"), own))
        self.set(row("THETA"), "t_tip + turned")
        self.say("squared size of the step: turns in rad, positions as shares of the length, and the tip force")
        squares = [f"(w{g} * b{g}) * (w{g} * b{g})" for g in self.points]
        squares += [f"(b{p} * b{p} + b{p + 1} * b{p + 1}) * con[C_INV_LENGTH2]"]
        squares += ["(b_x * b_x + b_z * b_z) * con[C_INV_FORCE2]"]
        squares += ["turned * turned"]
        self.set("size", " + ".join(squares))
        self.say("a step that does not shrink, or a large first one, may lead to another branch: not vouched for")
        self.set("astray", f"size > min(LARGEST2, SHRINK2 * {row('SIZE')}) and size > TOLERANCE2")
        self.set("extreme", "2.0 if astray else extreme")
        self.set(row("SIZE"), "size")
        self.set(row("PIVOT"), "pivot")
        self.set(row("EXTREME"), "extreme")


def module(p: int) -> str:
    """Return the text of one module."""
    writer = Writer(p)
    writer.read()
    writer.sections()
    writer.tip()
    writer.system()
    writer.solve()
    writer.write()
    return HEADER.format(p=p) + "\n".join(writer.lines) + "\n" + FOOTER


def main() -> int:
    """Write the modules, or with --check say whether they are up to date."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="only compare; exit 1 when a module is out of date")
    check = parser.parse_args().check
    stale = 0
    for p in ORDERS:
        path, text = FOLDER / f"condensed{p}.py", module(p)
        if check:
            stale += not path.exists() or path.read_text() != text
        else:
            path.write_text(text)
    return int(stale > 0)


if __name__ == "__main__":
    raise SystemExit(main())
