"""Write the parts of the fast path that depend on the order, `ecm_fast/kernels/condensed/order3.py` to `order6.py`.

    python tools/write_condensed.py [--check]

They are written out, without loops, because only then does the compiler vectorize a loop over load cases around them.
`ecm_fast/kernels/condensed/formulation.py` states what they compute; read it here, where loops still are loops.
"""

import argparse
import math
from collections.abc import Iterable
from pathlib import Path

from ecm_fast.kernels import layout
from ecm_fast.kernels.condensed import control_step as stepper

FOLDER = Path(__file__).resolve().parent.parent / "ecm_fast" / "kernels" / "condensed"
ORDERS = (3, 4, 5, 6)

HEADER = '''\
"""The condensed formulation for one element of order {p}, written out. Do not edit.

Written by `tools/write_condensed.py`; the formulation is explained in `condensed`.
"""

import numpy as np

from .._jit import array_at, kernel, step_kernel, wide
from ..layout import (
    CONVERGED,
    LANES,
    NOT_CONVERGED,
    R_EXTREME,
    R_LAM_L,
    R_LAM_R,
    R_THETA,
    R_X,
    R_Z,
)
from ..prepare import prepare
from .control_step import rescue, unfold
from .formulation import MAX_STEPS, collect, condense, judge, nodes_of, put_load, settled, straighten, vouches
from .initial_guess import extrapolate, guess, lane_inside, lanes_inside, remember
from .physics import plate, section

__all__ = ["advance", "solve_loads", "solve_mechanisms", "solve_nodes", "sweep", "sweep_mechanisms"]

ORDER = {p}
'''

FOOTER = '''

@step_kernel
def step(con, state, keep):
    """Take one Newton step for the one load case that `state` holds; with `keep`, leave the factor to `tip_columns`."""
{sections}
    plate(con, 1, 0, state, 1, 0)
    assemble(con, 1, 0, state, 1, 0)
    solve(con, 1, 0, state, 1, 0, keep)


@step_kernel
def _sweep(con, cr, own, state):
    wide()
    # one loop after the other: each body fits the window in which a processor reorders instructions
{loops}
    for j in range(LANES):
        plate(con, cr, own * j, state, LANES, j)
    for j in range(LANES):
        assemble(con, cr, own * j, state, LANES, j)
    for j in range(LANES):
        solve(con, cr, own * j, state, LANES, j, False)


@kernel
def sweep(con, state):
    """Take one Newton step in every lane: many loads, one mechanism."""
    wide()
    _sweep(con, 1, 0, state)


@kernel
def sweep_mechanisms(con, state):
    """Take one Newton step in every lane, each with constants of its own: `con` holds lanes as `state` does."""
    wide()
    _sweep(con, LANES, 1, state)


@kernel
def solve_loads(con, coefficients, lam_max, lam, wrench, last2, state, x, z, theta, status):
    \"\"\"Solve load cases on one mechanism, LANES at a time.

    coefficients, lam_max : see `start.guess`, used where both tendon forces are at most `lam_max`; else, and for
        lam_max = 0 always, the beam starts straight
    lam : (n, 2), wrench : (n, 3) or (1, 3), last2 : largest squared last step
    state : (LANES * state_size,)   work space
    x, z, theta, status : (n,)   overwritten; CONVERGED, or NOT_CONVERGED where the robust solver must decide
    \"\"\"
    n, last_wrench = lam.shape[0], wrench.shape[0] - 1
    for first in range(0, n, LANES):
        for j in range(LANES):
            i = min(first + j, n - 1)
            put_load(state, LANES, j, lam[i], wrench[min(i, last_wrench)])
        inside = lanes_inside(state, lam_max)
        if inside > 0:
            guess(coefficients, lam_max, state, LANES, LANES, ORDER)
        if inside < LANES:
            for j in range(LANES):
                if not lane_inside(state, lam_max, j):
                    straighten(con, 1, 0, state, LANES, j, ORDER)
        for _ in range(MAX_STEPS):
            sweep(con, state)
            if settled(state, last2):
                break
        end = min(first + LANES, n)
        collect(state, last2, x[first:end], z[first:end], theta[first:end], status[first:end])


@kernel
def solve_mechanisms(
    par, mesh, nodes, turn, slopes, stretch, lam, wrench, last2, system, con, lanes, state, x, z, theta, status
):
    \"\"\"Solve cases that each have a mechanism of their own, from the straight beam, LANES at a time.

    par : (n, n_parameters)
    mesh, nodes, turn, slopes, stretch : see `prepare` and `condensed.condense`
    system : work arrays of one thread: stations, tip, q_rest; con : (constants_size,), lanes : LANES times that
    the rest as in `solve_loads`
    \"\"\"
    n, last_wrench = lam.shape[0], wrench.shape[0] - 1
    stations, tip, q_rest = system
    for first in range(0, n, LANES):
        for j in range(LANES):
            i = min(first + j, n - 1)
            prepare(par[i], mesh, nodes, stations, tip, q_rest)
            applies = condense(stations, tip, q_rest, turn, slopes, stretch, con)
            for k in range(con.shape[0]):
                lanes[LANES * k + j] = con[k]
            put_load(state, LANES, j, lam[i], wrench[min(i, last_wrench)])
            straighten(lanes, LANES, j, state, LANES, j, ORDER)
            if not applies:
                state[LANES * R_EXTREME + j] = 2.0
        for _ in range(MAX_STEPS):
            sweep_mechanisms(lanes, state)
            if settled(state, last2):
                break
        end = min(first + LANES, n)
        collect(state, last2, x[first:end], z[first:end], theta[first:end], status[first:end])


@step_kernel
def _iterate(con, state, last2, keep):
    for _ in range(MAX_STEPS):
        step(con, state, keep)
        if vouches(state, 1, 0, last2):
            return True
    return False


@kernel
def solve_nodes(par, mesh, nodes, turn, slopes, stretch, tables, lam, wrench, last2, system, con, state, q, status):
    """Solve cases one after the other, each from the straight beam, into their nodes.

    par : (1 or n, n_parameters)   one mechanism for all, or one for each
    tables : (3, p, p + 1); the other arguments as in `solve_mechanisms`, of one lane
    q : (n, 3 n_nodes), status : (n,)   overwritten; CONVERGED, or NOT_CONVERGED where the robust solver must decide
    """
    n, last_wrench = lam.shape[0], wrench.shape[0] - 1
    stations, tip, q_rest = system
    applies = False
    for i in range(n):
        if i < par.shape[0]:
            prepare(par[i], mesh, nodes, stations, tip, q_rest)
            applies = condense(stations, tip, q_rest, turn, slopes, stretch, con)
        put_load(state, 1, 0, lam[i], wrench[min(i, last_wrench)])
        straighten(con, 1, 0, state, 1, 0, ORDER)
        found = _iterate(con, state, last2, False) and applies
        status[i] = CONVERGED if found else NOT_CONVERGED
        nodes_of(con, state, tables, slopes, ORDER, q[i])


@step_kernel
def _follow(con, coefficients, settings, state, before, lam_l, lam_r):
    last2, keep, lam_max = settings[0], settings[1] > 0.0, settings[2]
    if lam_max == 0.0 and vouches(state, 1, 0, last2):
        extrapolate(state, before, lam_l, lam_r, ORDER)
        if _iterate(con, state, last2, keep):
            return True
    state[R_LAM_L], state[R_LAM_R] = lam_l, lam_r
    if lam_l <= lam_max and lam_r <= lam_max and lam_max > 0.0:
        guess(coefficients, lam_max, state, 1, 1, ORDER)
    else:
        straighten(con, 1, 0, state, 1, 0, ORDER)
    found = _iterate(con, state, last2, keep)
    remember(state, before, ORDER)
    return found


@kernel
def advance(address, lam_l, lam_r):
    """Take a control step: to new tendon forces, from where the memory at `address` stands; see `stepper`.

    Returns x, z, theta, status.
    """
    memory = array_at(address, {total})
{pieces}
    possible = 0.0 <= lam_l < np.inf and 0.0 <= lam_r < np.inf
    if possible and _follow(con, coefficients, settings, state, before, lam_l, lam_r):
        if settings[1] > 0.0:
            tip_columns(con, state, columns)
            unfold(con, state, columns, compliance, jacobian)
        return state[R_X], state[R_Z], state[R_THETA], CONVERGED
    afresh = settings[2] != 0.0
    return rescue(tables, stations, tip, q_rest, loads, q, work, out, compliance, jacobian, afresh, lam_l, lam_r)
'''


# what a step keeps beside its factor
KEPT = ("c_xx", "c_xz", "c_zz", "j_xx", "j_xz", "j_zx", "j_zz", "g_x", "g_z", "gap_x", "gap_z")

# eliminate tip force and position; j = (1 + h c)^-1 has no inverse of the compliance c, so rigid sections do no harm
TIP = """\
    gap_x, gap_z = {X} - c_dx, {Z} - c_dz
    e_x, e_z = {wx} - {fx}, {wz} - {fz}
    m_xx, m_xz = 1.0 + h_xx * c_xx + h_xz * c_xz, h_xx * c_xz + h_xz * c_zz
    m_zx, m_zz = h_xz * c_xx + h_zz * c_xz, 1.0 + h_xz * c_xz + h_zz * c_zz
    pivot = m_xx * m_zz - m_xz * m_zx
    inv = 1.0 / pivot
    pivot = m_xx + m_zz if m_xx + m_zz < pivot else pivot
    j_xx, j_xz, j_zx, j_zz = m_zz * inv, -m_xz * inv, -m_zx * inv, m_xx * inv
    s_xx, s_xz, s_zz = j_xx * h_xx + j_xz * h_xz, j_xx * h_xz + j_xz * h_zz, j_zx * h_xz + j_zz * h_zz
    g_x, g_z = j_xx * h_xt + j_xz * h_zt, j_zx * h_xt + j_zz * h_zt
    q_x, q_z = c_xx * e_x + c_xz * e_z - gap_x, c_xz * e_x + c_zz * e_z - gap_z
    g_tt = h_tt - h_xt * (c_xx * g_x + c_xz * g_z) - h_zt * (c_xz * g_x + c_zz * g_z)
    p_x = j_xx * e_x + j_xz * e_z + s_xx * gap_x + s_xz * gap_z
    p_z = j_zx * e_x + j_zz * e_z + s_xz * gap_x + s_zz * gap_z
    pull = {tau} - g_x * q_x - g_z * q_z
"""


def row(name: str) -> str:
    """Return where a quantity of the lane stands, by its name in `layout`."""
    return f"state[sr * {getattr(layout, f'R_{name}')} + j]"


def con(place: int) -> str:
    """Return a constant of the formulation."""
    return f"con[cr * {place} + cl]"


def dot(left: Iterable[str], right: Iterable[str]) -> str:
    """Return the sum of products of two lists of names."""
    return " + ".join(f"{a} * {b}" for a, b in zip(left, right, strict=True))


def K(i: int, j: int) -> str:
    """Return the name of an entry of the tangent, of which only the lower triangle is kept."""
    return f"K{max(i, j)}_{min(i, j)}"


class Writer:
    """Collects the lines of one module."""

    def __init__(self, p: int) -> None:
        self.p, self.points, self.lines = p, range(p), []
        kept = [K(h, k) for h in self.points for k in range(h + 1)] + list(KEPT)
        first = layout.R_POINT + layout.N_SECTION * p
        self.rows = {name: first + place for place, name in enumerate(kept)}
        self.blocks = [list(range(k, min(k + 2, p))) for k in range(0, p, 2)]

    def function(self, name: str, arguments: str, meaning: str) -> None:
        self.lines += ["", "", "@step_kernel", f"def {name}({arguments}):", f'    """{meaning}"""']

    def set(self, name: str, value: str, indent: str = "    ") -> None:
        self.lines.append(f"{indent}{name} = {value}")

    def own(self, name: str) -> str:
        return f"state[sr * {self.rows[name]} + j]"

    def point(self, g: int, name: str) -> str:
        return f"state[sr * {layout.R_POINT + layout.N_SECTION * g + getattr(layout, f'P_{name}')} + j]"

    def station(self, g: int, column: int) -> str:
        return con(layout.C_STATION + layout.N_POINT * g + column)

    def stiffness(self, h: int, k: int) -> str:
        i, j = max(h, k), min(h, k)
        return con(layout.C_STATION + layout.N_POINT * self.p + i * (i + 1) // 2 + j)

    def names(self, stem: str) -> list[str]:
        return [f"{stem}{g}" for g in self.points]

    def load(self, stem: str, name: str) -> None:
        for g in self.points:
            self.set(f"{stem}{g}", self.point(g, name))

    def take(self, names: Iterable[str]) -> None:
        """Write the reading of what `assemble` left, by the names it had there."""
        for name in names:
            self.set(name, self.own(name))

    def stiffness_at_tip(self, *names: str) -> None:
        for name in ("xx", "xz", "zz", "xt", "zt", *names):
            self.set(f"h_{name}", row(name.upper()))

    def assemble(self) -> None:
        """Write the equations for the angles, tip force and position eliminated."""
        self.function("assemble", "con, cr, cl, state, sr, j", "Equations for the angles alone, see `condensed`.")
        for name in ("XX", "XZ", "ZZ", "DX", "DZ"):
            self.set(f"c_{name.lower()}", " + ".join(self.point(g, name) for g in self.points))
        for stem, name in (("X", "BX"), ("Z", "BZ"), ("o", "THETA")):
            self.load(stem, name)
        for g in self.points:
            self.set(f"t{g}", self.station(g, 7))
        self.stiffness_at_tip("tt")
        self.lines += TIP.format(
            X=row("X"),
            Z=row("Z"),
            tau=row("WTAU"),
            **{name: row(key) for name, key in (("wx", "WX"), ("wz", "WZ"), ("fx", "FORCE_X"), ("fz", "FORCE_Z"))},
        ).splitlines()
        self.set(row("PIVOT"), f"pivot if pivot < {row('PIVOT')} else {row('PIVOT')}")
        self.set(f"{row('WX')}, {row('WZ')}", "e_x, e_z")
        for name in KEPT:
            self.set(self.own(name), name)
        for h in self.points:
            bending = dot([self.stiffness(h, k) for k in self.points], self.names("o"))
            inner = f"{bending} - {self.station(h, 6)} + {self.point(h, 'COUPLE')}"
            self.set(self.point(h, "COUPLE"), f"t{h} * pull - ({inner}) - X{h} * p_x - Z{h} * p_z")
        for h in self.points:
            self.set(f"U{h}", f"s_xx * X{h} + s_xz * Z{h} - g_x * t{h}")
            self.set(f"V{h}", f"s_xz * X{h} + s_zz * Z{h} - g_z * t{h}")
            self.set(f"T{h}", f"g_tt * t{h} - g_x * X{h} - g_z * Z{h}")
            for k in range(h + 1):
                own = f"{self.stiffness(h, k)} + U{h} * X{k} + V{h} * Z{k} + T{h} * t{k}"
                self.set(self.own(K(h, k)), f"{own} + {self.point(h, 'TURN')}" if h == k else own)

    def solve(self) -> None:
        """Write the factorization and the step."""
        self.function("solve", "con, cr, cl, state, sr, j, keep", "Solve for the angles, and take the step.")
        self.load("b", "COUPLE")
        self.take(K(h, k) for h in self.points for k in range(h + 1))
        self.set("pivot", row("PIVOT"))
        remaining = [*self.points]
        for block in self.blocks:
            remaining = [m for m in remaining if m not in block]
            self.eliminate(block, remaining)
        self.substitute("b")
        self.lines.append("    if keep:")
        for h in self.points:
            for k in range(h + 1):
                inverse = any(h in block and k in block for block in self.blocks)
                self.set(self.own(K(h, k)), f"I{h}_{k}" if inverse else f"L{h}_{k}", "        ")
        for stem, name in (("X", "BX"), ("Z", "BZ"), ("o", "THETA")):
            self.load(stem, name)
        for g in self.points:
            self.set(f"t{g}", self.station(g, 7))
        self.stiffness_at_tip()
        self.take(name for name in KEPT if name not in ("g_x", "g_z"))
        self.set("e_x, e_z", f"{row('WX')}, {row('WZ')}")
        self.move()

    def eliminate(self, block: list[int], remaining: list[int]) -> None:
        self.invert(block)
        for m in remaining:
            for i in block:
                self.set(f"L{m}_{i}", " + ".join(f"{K(m, k)} * I{max(i, k)}_{min(i, k)}" for k in block))
        for m in remaining:
            for n in [n for n in remaining if n <= m]:
                self.set(K(m, n), K(m, n) + "".join(f" - L{m}_{i} * {K(n, i)}" for i in block))
            self.set(f"b{m}", f"b{m}" + "".join(f" - L{m}_{i} * b{i}" for i in block))

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

    def substitute(self, b: str) -> None:
        later: list[int] = []
        for block in reversed(self.blocks):
            values = []
            for i in block:
                own = " + ".join(f"I{max(i, k)}_{min(i, k)} * {b}{k}" for k in block)
                values.append(own + "".join(f" - L{m}_{i} * {b}{m}" for m in later))
            self.set(", ".join(f"{b}{i}" for i in block), ", ".join(values))
            later = [*block, *later]

    def displace(self, b: str, e_x: str, e_z: str, gap_x: str, gap_z: str) -> None:
        """Write tip turn and displacement that go with angles `b`."""
        self.set("turned", dot(self.names("t"), self.names(b)))
        self.set("e_x, e_z", f"{e_x} - h_xt * turned, {e_z} - h_zt * turned")
        self.set("q_x", f"c_xx * e_x + c_xz * e_z{gap_x} - ({dot(self.names('X'), self.names(b))})")
        self.set("q_z", f"c_xz * e_x + c_zz * e_z{gap_z} - ({dot(self.names('Z'), self.names(b))})")
        self.set("d_x, d_z", "j_xx * q_x + j_zx * q_z, j_xz * q_x + j_zz * q_z")

    def move(self) -> None:
        b = self.names("b")
        self.displace("b", "e_x", "e_z", " - gap_x", " - gap_z")
        self.set("f_x, f_z", "e_x - h_xx * d_x - h_xz * d_z, e_z - h_xz * d_x - h_zz * d_z")
        for g in self.points:
            self.set(f"o{g}", f"o{g} + b{g}")
            self.set(self.point(g, "THETA"), f"o{g}")
        self.set(row("THETA"), f"{con(layout.C_TIP)} + {dot(self.names('t'), self.names('o'))}")
        for name, change in (("X", "d_x"), ("Z", "d_z"), ("FORCE_X", "f_x"), ("FORCE_Z", "f_z")):
            self.set(row(name), f"{row(name)} + {change}")
        squares = f"{dot(b, b)} + turned * turned + (d_x * d_x + d_z * d_z) * {con(layout.C_INV_LENGTH2)}"
        self.set("size", f"{squares} + (f_x * f_x + f_z * f_z) * {con(layout.C_INV_FORCE2)}")
        self.lines.append("    judge(state, sr, j, pivot, size)")

    def columns(self) -> None:
        """Write the derivatives of the tip pose by a wrench at Q."""
        meaning = (
            "Compliance at Q, lower triangle xx, zx, zz, tx, tz, tt, from the factor that a step with `keep` left."
        )
        self.function("tip_columns", "con, state, compliance", meaning)
        self.lines.append("    cr, cl, sr, j = 1, 0, 1, 0")
        for stem, name in (("X", "BX"), ("Z", "BZ")):
            self.load(stem, name)
        for g in self.points:
            self.set(f"t{g}", self.station(g, 7))
            for k in range(g + 1):
                inverse = any(g in block and k in block for block in self.blocks)
                self.set(f"I{g}_{k}" if inverse else f"L{g}_{k}", self.own(K(g, k)))
        self.take(name for name in KEPT if "gap" not in name)
        self.set("h_xt, h_zt", f"{row('XT')}, {row('ZT')}")
        along = (("j_xx", "j_zx", "g_x * c_xx + g_z * c_xz"), ("j_xz", "j_zz", "g_x * c_xz + g_z * c_zz"))
        for column in range(3):  # unit force along x, along z, unit moment
            for h in self.points:
                value = f"t{h}"
                if column < 2:
                    p_x, p_z, pull = along[column]
                    value = f"-{p_x} * X{h} - {p_z} * Z{h} - ({pull}) * t{h}"
                self.set(f"b{h}", value)
            remaining = [*self.points]
            for block in self.blocks:
                remaining = [m for m in remaining if m not in block]
                for m in remaining:
                    self.set(f"b{m}", f"b{m}" + "".join(f" - L{m}_{i} * b{i}" for i in block))
            self.substitute("b")
            self.displace("b", "1.0" if column == 0 else "0.0", "1.0" if column == 1 else "0.0", "", "")
            for i, value in enumerate(("d_x", "d_z", "turned")):
                if i >= column:
                    self.set(f"compliance[{i * (i + 1) // 2 + column}]", value)

    def module(self) -> str:
        self.assemble()
        self.solve()
        self.columns()
        sections = "\n".join(f"    section(con, 1, 0, state, 1, 0, {g})" for g in self.points)
        loops = "\n".join(
            f"    for j in range(LANES):\n        section(con, cr, own * j, state, LANES, j, {g})" for g in self.points
        )
        body = "\n".join(self.lines) + "\n"
        pieces = stepper.pieces(self.p)
        cuts = "\n".join(
            f"    {name} = memory[{first}:{first + math.prod(shape)}]"
            + (f".reshape({shape})" if len(shape) > 1 else "")
            for name, (first, shape) in pieces.items()
        )
        footer = FOOTER.format(sections=sections, loops=loops, pieces=cuts, total=stepper.memory_size(self.p))
        return HEADER.format(p=self.p) + body + footer


def main() -> int:
    """Write the modules, or with --check say whether they are up to date."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="only compare; exit 1 when a module is out of date")
    check = parser.parse_args().check
    stale = 0
    for p in ORDERS:
        path, text = FOLDER / f"order{p}.py", Writer(p).module()
        if check:
            stale += not path.exists() or path.read_text() != text
        else:
            path.write_text(text)
    return int(stale > 0)


if __name__ == "__main__":
    raise SystemExit(main())
