"""Reference equilibria by shooting, and the errors of the default and the paper's discretization."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data.datasets import ReferenceSolutions, reference_solutions
from ...mechanism.mechanism import Mechanism
from ...mechanism.vector import pack
from ...models.finite_element import FiniteElementModel
from ...pages.page import Section, Table
from ...pages.plots import random_tendon_forces
from .claims import CHANNEL_KEYS, DEG, MM, PaperClaim, Part, shown, verdict

__all__ = ["reference"]

_DEFAULT, _FINEST, _PAPER = "default, one element of order 5", "one element of order 6", "paper, 20 linear elements"
_DISCRETIZATIONS = {_DEFAULT: (1, 5), _FINEST: (1, 6), _PAPER: (20, 1)}
_DEFAULT_BOUND = 1e-6
"""Error that the default may leave, as a share of the beam's length and in rad."""
_FIG_6 = (0.047, 0.026, 0.018)
"""Errors of the paper's model against its measurements in x, z, theta, as shares of the measured workspace."""
_FIG_6_SHARE = 0.1  # a solver's error may be a tenth of the difference that the paper's Fig. 6 shows


def reference() -> Part:
    """Solve every reference case with both discretizations."""
    known = reference_solutions()
    errors = {name: _errors(known, *division) for name, division in _DISCRETIZATIONS.items()}
    driven = [i for i, loads in enumerate(known.loads) if loads == "tendons"]
    shares = errors[_PAPER][driven].max(axis=0) / _workspace_size()
    lengths = _lengths(known)
    default = (errors[_DEFAULT] / np.column_stack([lengths, lengths, np.ones_like(lengths)])).max()
    claims = (
        PaperClaim(
            f"The default, one element of order 5, meets all {len(known.loads)} solutions to 1e-6 of the length and "
            "1e-6 rad",
            "exact to 1e-11",
            f"largest error {shown(default, '.1e')}",
            verdict(float(default), _DEFAULT_BOUND, shown(default, ".1e")),
        ),
        PaperClaim(
            "The paper's 20 linear elements have no share in the errors of its Fig. 6: for tendon forces they leave "
            "less than a tenth of them",
            _percent(_FIG_6),
            _percent(shares),
            verdict(float((shares / _FIG_6).max()), _FIG_6_SHARE, f"{shown((shares / _FIG_6).max(), '.2f')} of them"),
        ),
    )
    table, numbers = _table(known, errors)
    return Part(claims, numbers, Section("Solutions by another method", (known.origin,), (table,)))


def _errors(known: ReferenceSolutions, elements: int, order: int) -> NDArray[np.float64]:
    """Return the error of every case, (n, 3) [m, m, rad]."""
    model = FiniteElementModel(elements=elements, order=order)
    parameters = np.array([pack(mechanism) for mechanism in known.mechanisms])
    return np.abs(model.solve_batch(known.lam, known.wrench, parameters=parameters).pose - known.pose)


def _lengths(known: ReferenceSolutions) -> NDArray[np.float64]:
    return np.array([mechanism.beam.length for mechanism in known.mechanisms])


def _workspace_size() -> NDArray[np.float64]:
    """Return the extent of the slender preset's workspace, (3,) [m, m, rad]: its poses are the larger ones."""
    pose = FiniteElementModel(Mechanism.preset("slender")).solve_batch(random_tendon_forces()).pose
    extent: NDArray[np.float64] = np.ptp(pose, axis=0)
    return extent


def _table(
    known: ReferenceSolutions, errors: dict[str, NDArray[np.float64]]
) -> tuple[Table, dict[str, list[dict[str, Any]]]]:
    lengths = _lengths(known)
    loads = np.array(known.loads)
    numbers: dict[str, list[dict[str, Any]]] = {}
    rows: list[tuple[str | float, ...]] = []
    for name, error in errors.items():
        numbers[name] = []
        for kind, length in dict.fromkeys(zip(known.loads, lengths, strict=True)):
            chosen = (loads == kind) & (lengths == length)
            largest = error[chosen].max(axis=0)
            numbers[name].append({"loads": kind, "length_m": length, "rows": int(chosen.sum()),
                                  **dict(zip(CHANNEL_KEYS, largest, strict=True))})  # fmt: skip
            rows.append((name, kind, f"{length * MM:g} mm", int(chosen.sum()), *largest[:2] * MM, largest[2] * DEG))
    head = ("discretization", "loads", "length", "cases", "x [mm]", "z [mm]", "theta [deg]")
    return Table("Largest errors against solutions by shooting", head, tuple(rows)), numbers


def _percent(shares: Any) -> str:
    x, z, theta = (shown(100.0 * share, ".2g") for share in shares)
    return f"x {x} %, z {z} %, theta {theta} % of the workspace"
