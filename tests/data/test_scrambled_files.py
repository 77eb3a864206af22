"""Files scrambled at random: each read right, asked about or refused, never wrong without a word."""

import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lab_files import PER_SI, Doubts, imported, text
from numpy.typing import NDArray

from ecm_fast.data.column_map import ColumnMap
from ecm_fast.data.columns import column_of, is_known
from ecm_fast.data.measurements import Measurements, read_measurements
from ecm_fast.errors import InputError

pytestmark = pytest.mark.slow

Floats = NDArray[np.float64]

NAMES = {
    "lam_l": ["lam_l", "F_left", "Force left", "Seil links", "Kraft L", "FL", "left", "F1", "Load", "lam_left"],
    "lam_r": ["lam_r", "F_right", "Force right", "Seil rechts", "Kraft R", "FR", "right", "F2", "Last", "lam_right"],
    "fz": ["fz", "Fz", "side force", "push", "Seitenkraft"],
    "x": ["x", "Position x", "Bild x", "pos_x", "tip_x", "PosX", "X", "axial", "y"],
    "z": ["z", "Position z", "Bild z", "pos_z", "tip_z", "PosZ", "Z", "y", "lateral", "x"],
    "theta": ["theta", "Angle", "Winkel", "rotation", "\u03b8", "phi", "tilt", "head angle"],
    "t": ["t", "time", "Zeit", "Timestamp", "elapsed"],
}
"""Names that people give; some are of another column, some say nothing."""
UNITS = {
    "lam_l": ["N", "N", "kgf", "gf", "lbf", "mN", "kN"],
    "x": ["mm", "mm", "m", "cm", "in"],
    "theta": ["deg", "deg", "rad", "mrad"],
    "t": ["s", "ms"],
}
WORDS = {"deg": ["deg", "\u00b0", "degrees"], "in": ["in", "inch"], "kgf": ["kgf", "kp"], "s": ["s", "sec"]}
OTHER = [("T [\u00b0C]", "20.5"), ("Remark", "cold"), ("Nr", "7"), ("error x [mm]", "0.01"), ("set left [N]", "3.5"),
         ("voltage_V", "1.25"), ("Distance [mm]", "12.5"), ("note", "a"), ("spare", "")]  # fmt: skip


class File(NamedTuple):
    """A scrambled file and what it means.

    Attributes
    ----------
    content : its bytes
    truth : by quantity, in SI, nan where blank
    misnamed : whether a name that is read as ours stands for another quantity, or for one whose sign is turned
    exactly : whether one that is ours to the letter does
    """

    content: bytes
    truth: dict[str, Floats]
    misnamed: bool
    exactly: bool


def neck(draw: st.DrawFn, n: int) -> dict[str, Floats]:
    """Return loads and poses of something like a neck, or, one time in five, numbers without a relation."""
    seed = draw(st.integers(0, 10**6))
    random = np.random.default_rng(seed)
    left, right = random.uniform(0.0, 80.0, (2, n))
    push = random.choice([0.0, 1.0]) * random.uniform(-20.0, 20.0, n)
    lateral = 1.5e-4 * (left - right) + 5e-4 * push + random.normal(0.0, 1e-4, n)
    if draw(st.integers(0, 4)) == 0:
        lateral = random.uniform(-0.03, 0.03, n)
    along = 0.109 - lateral**2 / 0.15
    theta = -random.uniform(1.4, 2.1) * lateral / along
    return {"lam_l": left, "lam_r": right, "fz": push, "x": along, "z": lateral, "theta": theta,
            "t": np.cumsum(random.uniform(1.0, 30.0, n))}  # fmt: skip


@st.composite
def files(draw: st.DrawFn) -> File:
    n = draw(st.integers(3, 9))
    values = neck(draw, n)
    some = st.lists(st.sampled_from([*NAMES]), min_size=2, max_size=7, unique=True)
    chosen = draw(st.one_of(some, st.permutations(["lam_l", "lam_r", "x", "z", "theta"])))
    plain = draw(st.booleans())
    digits = draw(st.sampled_from([3, 4, 6]))
    form = draw(st.sampled_from(["{} [{}]", "{} ({})", "{}_{}", "{} {}", "line", "none"]))
    columns, names, units, truth = list[list[str]](), list[str](), list[str](), dict[str, Floats]()
    misnamed = exactly = False
    for quantity in chosen:
        kind = {"lam_r": "lam_l", "fz": "lam_l", "z": "x"}.get(quantity, quantity)
        unit = draw(st.sampled_from(UNITS[kind]))
        stem = quantity if plain else draw(st.sampled_from(NAMES[quantity]))
        written = draw(st.sampled_from(WORDS.get(unit, [unit])))
        name = f"{stem}_{unit}" if plain else stem if form in ("line", "none") else form.format(stem, written)
        sign = 1.0 if plain or quantity == "t" else draw(st.sampled_from([1.0, 1.0, 1.0, -1.0]))
        own = f"{stem} [{unit}]"  # as a line of units is read
        wrongly = is_known(own) and (sign < 0.0 or column_of(own)[0].name != quantity)
        misnamed, exactly = misnamed | wrongly, exactly | (wrongly and name == f"{stem}_{unit}")
        cells = [f"{sign * value * PER_SI[unit]:.{digits}f}" for value in values[quantity]]
        truth[quantity] = np.array([sign * float(cell) / PER_SI[unit] for cell in cells])
        if quantity in ("x", "z", "theta") and draw(st.integers(0, 4)) == 0:
            place = draw(st.integers(0, n - 1))
            cells[place], truth[quantity][place] = draw(st.sampled_from(["", "NaN", "-", "#N/A"])), np.nan
        columns.append(cells)
        names.append(name)
        units.append("" if plain else written)
    for name, cell in draw(st.lists(st.sampled_from(OTHER), max_size=2, unique=True)):
        place = draw(st.integers(0, len(names)))
        names.insert(place, name)
        units.insert(place, "")
        columns.insert(place, [cell] * n)
    header = [names, units] if form == "line" else [] if draw(st.integers(0, 9)) == 0 else [names]
    mark, decimal = draw(st.sampled_from([(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), ("  ", ".")]))
    above = draw(st.sampled_from(["", "", "", "# rig 3\n", f"Test{mark}3\n\n", "Report\nDate: 12.03.2026\n"]))
    end = draw(st.sampled_from(["\n", "\r\n", "\r"]))
    encoding = draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "cp1252"]))
    rows = [list(row) for row in zip(*columns, strict=True)]
    filled = [any(row) for row in rows]  # a line of separators alone is a blank line, as spreadsheets leave them
    truth = {name: values[filled] for name, values in truth.items()}
    content = above.replace("\n", end) + text(header, rows, mark, decimal, end)
    return File(content.encode(encoding, "replace"), truth, misnamed, exactly)


def wrong(run: Measurements, truth: dict[str, Floats]) -> list[str]:
    """Return the quantities that are not as they were written."""
    known = {name: truth.get(name, np.full(run.n, 0.0 if name in ("lam_l", "lam_r", "fz") else np.nan))
             for name in NAMES}  # fmt: skip
    return [name for name, values in known.items()
            if not np.allclose(getattr(run, name), values, rtol=1e-9, atol=1e-15, equal_nan=True)]  # fmt: skip


OUTCOMES = {"read": 0, "asked": 0, "refused": 0}


@settings(max_examples=2000, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(files())
def test_no_file_is_read_wrong(file: File) -> None:
    """Written by the test: every number, whatever is scrambled; of what the file has not, what absence means.

    Names that are ours to the letter are taken at their word, without a map ``z [mm]`` too: where they stand for x, or
    with another sign, is for the checks of the labels, which compare with a mechanism. ``pos_x_mm`` is a marker, which
    a neck refuses.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.txt"
        path.write_bytes(file.content)
        outcome = "read"
        try:
            found = imported(path)
            if isinstance(found, Doubts):
                outcome = "asked"
            else:
                assert file.exactly or not wrong(found, file.truth)
        except InputError:
            outcome = "refused"
        OUTCOMES[outcome] += 1
        for told in (None, ColumnMap({})):
            try:
                found = read_measurements(path, told)
            except InputError:
                continue
            assert file.misnamed or found.named or found.ignored or not wrong(found, file.truth)


def test_enough_files_are_read() -> None:
    """Contract: the test above would pass where every file were refused."""
    if sum(OUTCOMES.values()) == 0:
        pytest.skip("the files were not read in this process")
    assert OUTCOMES["read"] > 0.1 * sum(OUTCOMES.values()), OUTCOMES
