"""One Newton step of the condensed formulation after the sections, written out for an order by `unroll`.

`formulation` states the equations, and how constants and state are addressed. Names here: h, stiffness of the load at
the tip; c, compliance of the sections; j = (1 + h c)^-1; gap, what the closure lacks; e, what the tip force lacks;
X and Z, by Gauss point, less the tip displacement by its angle; t, its share in the tip's angle; o, its angle.
"""

import functools
import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from ...mechanism.mesh.families.quadrature import integrals
from .. import layout
from ..unroll import BlockFactor, Code, cofactor, determinant, dot, function, invariants, total
from .formulation import record_step

__all__ = ["written_out"]

DIRECTIONS = ("x", "z")
LANE = ("points", "con", "cr", "cl", "state", "sr", "j")
"""Arguments of a step in one lane; the first is a tuple whose length is the order."""
# of the bound of the discretization error, by order. In 1640 worlds of `bench/robustness/random_worlds.py` it was above
# the error wherever that exceeded 1e-6; rough compliances: 1.5 covers soft spots and bonded ends there
MARGIN = {3: 3e2, 4: 3e3, 5: 3e4, 6: 1e6}
ROUGH = 1.5
PIVOT_SIZE = 2  # unknowns to a division: the adjugate of two costs three products, of three already twenty


@functools.cache
def written_out(order: int) -> dict[str, Callable[..., Any]]:
    """Return the functions of one order by name.

    assemble, tangent, solve, move : take `LANE`, solve also whether to keep the factor. One after the other they are
        the step; apart, because the compiler vectorizes a loop over lanes only while it has few enough arrays to tell
        from one another, and for order 6 all in one has too many
    tip_columns : takes points, con, state and compliance (6,), overwritten with the compliance at Q, lower triangle
        xx, zx, zz, tx, tz, tt; from the factor that solve kept
    doubt : takes `LANE`; a bound of the discretization error, in rad and shares of the length, into the state. It
        costs little and often exceeds the error a thousand times: where it keeps an accuracy, the error does
    """
    writers: dict[str, tuple[Callable[[_Step], None], tuple[str, ...]]] = {
        "assemble": (_Step.assemble, LANE),
        "tangent": (_Step.tangent, LANE),
        "solve": (_Step.solve, (*LANE, "keep")),
        "move": (_Step.move, LANE),
        "tip_columns": (_Step.tip_columns, ("points", "con", "state", "compliance")),
        "doubt": (_Step.doubt, LANE),
    }
    functions = {}
    for name, (write, arguments) in writers.items():
        step = _Step(order)
        write(step)
        functions[name] = function(name, arguments, step.lines, {"record_step": record_step, "sqrt": np.sqrt})
    return functions


def _row(name: str) -> str:
    """Return where a quantity of the lane stands, by its name in `layout`."""
    return f"state[sr * {getattr(layout, f'R_{name}')} + j]"


def _con(place: int) -> str:
    """Return a constant of the formulation."""
    return f"con[cr * {place} + cl]"


def _symmetric(stem: str, a: str, b: str) -> str:
    return f"{stem}_{min(a, b)}{max(a, b)}"


def _h(a: str, b: str) -> str:
    return _symmetric("h", a, b)


def _c(a: str, b: str) -> str:
    return _symmetric("c", a, b)


def _s(a: str, b: str) -> str:
    return _symmetric("s", a, b)


def _each(stem: str) -> list[str]:
    """Return the names of a vector's components."""
    return [f"{stem}_{d}" for d in DIRECTIONS]


_PAIRS = [(a, b) for i, a in enumerate(DIRECTIONS) for b in DIRECTIONS[i:]]
# what the assembly leaves for the other functions, in this order behind the tangent
_COMPLIANCE, _J = [_c(*pair) for pair in _PAIRS], [f"j_{a}{b}" for a in DIRECTIONS for b in DIRECTIONS]
KEPT = [*_COMPLIANCE, *_J, *_each("g"), *_each("gap")]
assert len(KEPT) == layout.N_KEPT


class _Step(Code):
    """The lines of one function of the step."""

    def __init__(self, order: int) -> None:
        super().__init__()
        self.order, self.points, self.matrix = order, range(order), BlockFactor(order, PIVOT_SIZE)
        kept = [self.matrix.entry(*place) for place in self.matrix.lower_triangle()] + KEPT
        first = layout.R_POINT + layout.N_SECTION * order
        self.rows = {name: f"state[sr * {first + place} + j]" for place, name in enumerate(kept)}

    def assemble(self) -> None:
        """Write the residual of the angles, tip force and position eliminated."""
        for a, b in _PAIRS:
            self.set(_c(a, b), total(self._point(g, f"{a}{b}".upper()) for g in self.points))
        self._read("X", "BX")
        self._read("Z", "BZ")
        self._read("o", "THETA")
        self._read_shares()
        self._read_stiffness()
        self._eliminate_tip()
        for name in KEPT:
            self.set(self.rows[name], name)
        for d in DIRECTIONS:
            self.set(_row(f"W{d.upper()}"), f"e_{d}")
        for h in self.points:
            bending = dot([self._bending(h, k) for k in self.points], self._names("o"))
            inner = f"{bending} - {self._station(h, 6)} + {self._point(h, 'COUPLE')}"
            by_force = "".join(f" - {d.upper()}{h} * p_{d}" for d in DIRECTIONS)
            self.set(self._point(h, "COUPLE"), f"t{h} * pull - ({inner}){by_force}")

    def _eliminate_tip(self) -> None:
        """Write the elimination of tip force and position.

        j has no inverse of the compliance c, so rigid sections do no harm.
        """
        for d in DIRECTIONS:
            self.set(f"gap_{d}", f"{_row(d.upper())} - ({total(self._point(g, f'D{d.upper()}') for g in self.points)})")
            self.set(f"e_{d}", f"{_row(f'W{d.upper()}')} - {_row(f'FORCE_{d.upper()}')}")
        rows = [[f"m_{a}{b}" for b in DIRECTIONS] for a in DIRECTIONS]
        for a in DIRECTIONS:
            for b in DIRECTIONS:
                product = dot([_h(a, d) for d in DIRECTIONS], [_c(d, b) for d in DIRECTIONS])
                self.set(f"m_{a}{b}", f"1.0 + {product}" if a == b else product)
        self.set("pivot", determinant(rows))
        self.set("inv", "1.0 / pivot")
        for invariant in invariants(rows):
            self.lower("pivot", invariant)
        self.set(_row("PIVOT"), f"pivot if pivot < {_row('PIVOT')} else {_row('PIVOT')}")
        for i, a in enumerate(DIRECTIONS):
            for k, b in enumerate(DIRECTIONS):
                self.set(f"j_{a}{b}", f"{cofactor(rows, k, i)} * inv")
        for a in DIRECTIONS:
            self.set(f"g_{a}", dot([f"j_{a}{d}" for d in DIRECTIONS], [_h(d, "t") for d in DIRECTIONS]))
        self._stiffness_with_rod()
        for a in DIRECTIONS:
            compliance = [_c(a, d) for d in DIRECTIONS]
            self.set(f"q_{a}", f"{dot(compliance, _each('e'))} - gap_{a}")
            shares = [f"j_{a}{d}" for d in DIRECTIONS], [_s(a, d) for d in DIRECTIONS]
            self.set(f"p_{a}", f"{dot(shares[0], _each('e'))} + {dot(shares[1], _each('gap'))}")
        self.set("pull", f"{_row('WTAU')}" + "".join(f" - g_{d} * q_{d}" for d in DIRECTIONS))

    def _stiffness_with_rod(self) -> None:
        """Write s = j h, the load's stiffness as the angles meet it: behind the compliance of the sections."""
        for a, b in _PAIRS:
            self.set(_s(a, b), dot([f"j_{a}{d}" for d in DIRECTIONS], [_h(d, b) for d in DIRECTIONS]))

    def tangent(self) -> None:
        """Write the tangent of the angles."""
        self._read("X", "BX")
        self._read("Z", "BZ")
        self._read_shares()
        self._read_stiffness()
        self._take([*_COMPLIANCE, *_J, *_each("g")])
        self._stiffness_with_rod()
        given = "".join(f" - {_h(a, 't')} * ({dot([_c(a, d) for d in DIRECTIONS], _each('g'))})" for a in DIRECTIONS)
        self.set("g_tt", f"{_row('TT')}{given}")
        for h in self.points:
            for a in DIRECTIONS:
                moved = dot([_s(a, d) for d in DIRECTIONS], [f"{d.upper()}{h}" for d in DIRECTIONS])
                self.set(f"by_{a}", f"{moved} - g_{a} * t{h}")
            self.set("by_t", f"g_tt * t{h}" + "".join(f" - g_{d} * {d.upper()}{h}" for d in DIRECTIONS))
            for k in range(h + 1):
                by_load = dot([f"by_{d}" for d in DIRECTIONS], [f"{d.upper()}{k}" for d in DIRECTIONS])
                entry = f"{self._bending(h, k)} + {by_load} + by_t * t{k}"
                entry = f"{entry} + {self._point(h, 'TURN')}" if h == k else entry
                self.set(self.rows[self.matrix.entry(h, k)], entry)

    def solve(self) -> None:
        """Write the factorization, and the solution for the change of the angles."""
        self._read("b", "COUPLE")
        self._take(self.matrix.entry(*place) for place in self.matrix.lower_triangle())
        self.set("pivot", _row("PIVOT"))
        self.matrix.factorize(self)
        self.matrix.solve(self, "b")
        self.set(_row("PIVOT"), "pivot")
        for h in self.points:
            self.set(self._point(h, "COUPLE"), f"b{h}")
        self.lines.append("if keep:")
        for place in self.matrix.lower_triangle():
            self.set(f"    {self.rows[self.matrix.entry(*place)]}", self.matrix.factor(*place))

    def move(self) -> None:
        """Write the step of angles, tip and tip force."""
        self._read("b", "COUPLE")
        self._read("X", "BX")
        self._read("Z", "BZ")
        self._read("o", "THETA")
        self._read_shares()
        self._read_stiffness()
        self._take([*_COMPLIANCE, *_J, *_each("gap")])
        for d in DIRECTIONS:
            self.set(f"e_{d}", _row(f"W{d.upper()}"))
        self._displace(_each("e"), [f" - gap_{d}" for d in DIRECTIONS])
        for a in DIRECTIONS:
            self.set(f"f_{a}", f"e_{a}" + "".join(f" - {_h(a, d)} * d_{d}" for d in DIRECTIONS))
        for g in self.points:
            self.set(f"o{g}", f"o{g} + b{g}")
            self.set(self._point(g, "THETA"), f"o{g}")
        self.set(_row("THETA"), f"{_con(layout.C_TIP)} + {dot(self._names('t'), self._names('o'))}")
        for d in DIRECTIONS:
            self.set(_row(d.upper()), f"{_row(d.upper())} + d_{d}")
            self.set(_row(f"FORCE_{d.upper()}"), f"{_row(f'FORCE_{d.upper()}')} + f_{d}")
        turns = f"{dot(self._names('b'), self._names('b'))} + turned * turned"
        moved, changed = dot(_each("d"), _each("d")), dot(_each("f"), _each("f"))
        scaled = f"({moved}) * {_con(layout.C_INV_LENGTH2)} + ({changed}) * {_con(layout.C_INV_FORCE2)}"
        self.lines.append(f"record_step(state, sr, j, {turns} + {scaled})")

    def tip_columns(self) -> None:
        """Write the derivatives of the tip pose by a unit force in each direction and by a unit moment."""
        self.lines.append("cr, cl, sr, j = 1, 0, 1, 0")
        self._read("X", "BX")
        self._read("Z", "BZ")
        self._read_shares()
        for place in self.matrix.lower_triangle():
            self.set(self.matrix.factor(*place), self.rows[self.matrix.entry(*place)])
        self._take([*_COMPLIANCE, *_J, *_each("g")])
        for d in DIRECTIONS:
            self.set(_h(d, "t"), _row(f"{d}t".upper()))
        for column, loaded in enumerate([*DIRECTIONS, "t"]):
            for h in self.points:
                by_force = "".join(f" - j_{d}{loaded} * {d.upper()}{h}" for d in DIRECTIONS)
                by_turn = dot(_each("g"), [_c(d, loaded) for d in DIRECTIONS])
                self.set(f"b{h}", f"t{h}" if loaded == "t" else f"-({by_turn}) * t{h}{by_force}")
            self.matrix.solve(self, "b")
            self._displace(["1.0" if d == loaded else "0.0" for d in DIRECTIONS], ["" for _ in DIRECTIONS])
            for i, value in enumerate([*_each("d"), "turned"]):
                if i >= column:
                    self.set(f"compliance[{i * (i + 1) // 2 + column}]", value)

    def doubt(self) -> None:
        """Write the bound: what the Gauss rule leaves of a circle with the highest rate of the beam, times `MARGIN`.

        The angles obey a pendulum's equation, so their derivatives grow with its speed, the curvature, and with its
        frequency, the root of force by bending stiffness. A rough compliance adds what it turns the sections by.
        """
        p = self.order
        points, _ = np.polynomial.legendre.leggauss(p)
        slopes = np.linalg.inv(integrals(p, 0.5 * (1.0 + points)))
        for g in self.points:
            self.set(f"o{g}", f"{self._point(g, 'THETA')} - {_con(layout.C_THETA0)}")
        self.set("curved", "0.0")
        for row in slopes.tolist():
            self.set("kappa", dot([f"({value!r})" for value in row], self._names("o")))
            self.set("curved", "kappa * kappa if kappa * kappa > curved else curved")
        self.set("pulled", "0.0")
        for g in (0, p - 1):
            self.set("n_x", f"{_row('FORCE_X')} + {self._station(g, 3)}")
            self.set("n_z", f"{_row('FORCE_Z')} + {self._station(g, 4)}")
            self.set("square", "n_x * n_x + n_z * n_z")
            self.set("pulled", "square if square > pulled else pulled")
        self.set("rate", f"curved + sqrt(pulled) / {_con(layout.T_BENDING_FORCE)}")
        circle = math.factorial(p) ** 4 / ((2 * p + 1) * math.factorial(2 * p) ** 3)
        rough = f"{ROUGH / (2 * p + 1)!r} * sqrt(curved) * {_con(layout.C_ROUGH)}"
        self.set(_row("DOUBT"), f"{circle * MARGIN[p]!r} * {' * '.join(['rate'] * p)} + {rough}")

    def _displace(self, e: list[str], less_gap: list[str]) -> None:
        """Write tip turn and displacement that go with the angles b."""
        self.set("turned", dot(self._names("t"), self._names("b")))
        for d, value in zip(DIRECTIONS, e, strict=True):
            self.set(f"e_{d}", f"{value} - {_h(d, 't')} * turned")
        for a, gap in zip(DIRECTIONS, less_gap, strict=True):
            stretched = dot([_c(a, d) for d in DIRECTIONS], _each("e"))
            self.set(f"q_{a}", f"{stretched}{gap} - ({dot(self._names(a.upper()), self._names('b'))})")
        for a in DIRECTIONS:
            self.set(f"d_{a}", dot([f"j_{d}{a}" for d in DIRECTIONS], _each("q")))

    def _names(self, stem: str) -> list[str]:
        return [f"{stem}{g}" for g in self.points]

    def _read(self, stem: str, name: str) -> None:
        for g in self.points:
            self.set(f"{stem}{g}", self._point(g, name))

    def _read_shares(self) -> None:
        for g in self.points:
            self.set(f"t{g}", self._station(g, 7))

    def _read_stiffness(self) -> None:
        for a, b in [*_PAIRS, *((d, "t") for d in DIRECTIONS)]:
            self.set(_h(a, b), _row(f"{a}{b}".upper()))

    def _take(self, names: Iterable[str]) -> None:
        """Write the reading of what another function left, by the names it had there."""
        for name in names:
            self.set(name, self.rows[name])

    def _point(self, g: int, name: str) -> str:
        return f"state[sr * {layout.R_POINT + layout.N_SECTION * g + getattr(layout, f'P_{name}')} + j]"

    def _station(self, g: int, column: int) -> str:
        return _con(layout.C_STATION + layout.N_POINT * g + column)

    def _bending(self, h: int, k: int) -> str:
        i, j = max(h, k), min(h, k)
        return _con(layout.C_STATION + layout.N_POINT * self.order + i * (i + 1) // 2 + j)
