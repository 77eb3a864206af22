"""Bundled data sets: published measurements, simulated measurements, and solutions by another method.

The measurements are figures published by others, each file citing its source; nothing in a mechanism file was fitted
unless that file says so. What is called ``simulated_...`` nobody measured: the test bed of `ecm_fast.testbed` made it,
and its mechanism file is the truth.
"""

import csv
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from importlib.resources import as_file, files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, did_you_mean
from ...mechanism.mechanism import Mechanism
from ...mechanism.sections import AXIAL_LAWS
from ..measurements import Measurements, read_measurements

__all__ = ["ReferenceSolutions", "available", "describe", "load", "reference_solutions"]

Array = NDArray[np.float64]

_NAMES = (
    "steel_cantilever",
    "silicone_cantilever",
    "simulated_slender_tendon",
    "simulated_slender_shear",
    "simulated_paper_tendon",
    "simulated_paper_shear",
    "simulated_compression_28mm",
    "simulated_compression_40mm",
)
_FOLDER = files(__name__)


def available() -> tuple[str, ...]:
    """Return the names that `load` and `describe` take."""
    return _NAMES


def load(name: str) -> tuple[Mechanism, Measurements]:
    """Return what was built and what was measured on it.

    Raises
    ------
    InputError : no such dataset; names the nearest one.
    """
    with _file(name, ".toml") as mechanism, _file(name, ".csv") as measurements:
        return Mechanism.from_toml(mechanism), read_measurements(measurements)


def describe(name: str) -> str:
    """Return what was measured, by whom, and how the figures were read: the comment at the top of the file.

    Raises
    ------
    InputError : no such dataset; names the nearest one.
    """
    with _file(name, ".csv") as path:
        return " ".join(_comments(path))


@dataclass(frozen=True, eq=False)
class ReferenceSolutions:
    """Equilibria found by shooting, not by this program, one entry a row.

    Attributes
    ----------
    loads : (n,) "tendons" or "dead wrench"
    mechanisms : (n,)
    lam : (n, 2) tendon forces [N]
    wrench : (n, 3) dead wrench at Q [N, N, N m]
    pose : (n, 3) x, z, theta of Q [m, m, rad]
    origin : how they were made
    """

    loads: tuple[str, ...]
    mechanisms: tuple[Mechanism, ...]
    lam: Array
    wrench: Array
    pose: Array
    origin: str


def reference_solutions() -> ReferenceSolutions:
    """Return a few equilibria that any solver of this beam must meet."""
    with _path("reference_solutions.csv") as path:
        origin = " ".join(_comments(path))
        lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    numbers = np.array([[float(row[name]) for name in _NUMBERS] for row in rows])
    return ReferenceSolutions(
        tuple(row["loads"] for row in rows),
        tuple(_mechanism(row) for row in rows),
        numbers[:, :2],
        numbers[:, 2:5],
        numbers[:, 5:],
        origin,
    )


_NUMBERS = ("lam_l_N", "lam_r_N", "fx_N", "fz_N", "tau_Nm", "x_m", "z_m", "theta_rad")


def _mechanism(row: dict[str, str]) -> Mechanism:
    """Return the mechanism of a row: the columns with a dot are its entries."""
    entries = {name: value for name, value in row.items() if "." in name}
    return Mechanism().replace(**{name: v if v in AXIAL_LAWS else float(v) for name, v in entries.items()})


def _file(name: str, ending: str) -> AbstractContextManager[Path]:
    if name not in _NAMES:
        allowed = " or ".join(repr(known) for known in _NAMES)
        raise InputError(f"dataset = {name!r}: allowed is {allowed}{did_you_mean(str(name), _NAMES)}")
    folder = "simulated" if name.startswith("simulated_") else "measured"
    return _path(f"{folder}/{name}{ending}")


@contextmanager
def _path(name: str) -> Iterator[Path]:
    """Give a real file to read, also where the package lies in an archive."""
    with as_file(_FOLDER / name) as path:
        yield path


def _comments(path: Path) -> list[str]:
    lines = path.read_text(encoding="utf-8").splitlines()
    return [line.removeprefix("#").strip() for line in lines if line.startswith("#")]
