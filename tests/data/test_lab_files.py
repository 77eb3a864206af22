"""Files of the kinds that laboratories have: each read right, or answered with the cure.

Truth: the numbers that this file writes.
"""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from lab_files import PER_SI, Doubts, imported, text

from ecm_fast.data.grid import Layout
from ecm_fast.data.measurements import Measurements, read_measurements
from ecm_fast.errors import InputError

TRUTH = {
    "lam_l": np.array([5.0, 40.0, 60.5, 20.25, 5.0]),
    "lam_r": np.array([5.0, 10.0, 5.0, 45.5, 60.0]),
    "x": np.array([0.109, 0.1075, 0.1062, 0.1079, 0.1059]),
    "z": np.array([0.0001, 0.00625, 0.01125, -0.0051, -0.0121]),
    "theta": np.array([0.0, -0.11, -0.2, 0.09, 0.215]),
}  # fmt: skip
NAMES = {"lam_l": "lam_l_N", "lam_r": "lam_r_N", "x": "x_mm", "z": "z_mm", "theta": "theta_deg"}
SPOKEN = {"lam_l": "Force left", "lam_r": "Force right", "x": "Position x", "z": "Position z", "theta": "Angle"}
DEUTSCH = {"lam_l": "Seil links", "lam_r": "Seil rechts", "x": "Bild x", "z": "Bild z", "theta": "Winkel"}
UNITS = {"lam_l": "N", "lam_r": "N", "x": "mm", "z": "mm", "theta": "deg"}


def rows(units: Mapping[str, str] = UNITS, signs: Mapping[str, float] | None = None) -> list[list[str]]:
    """Return the cells of the truth, row by row, to 17 digits."""
    columns = [TRUTH[name] * PER_SI[units[name]] * (signs or {}).get(name, 1.0) for name in TRUTH]
    return [[f"{value:.17g}" for value in row] for row in np.column_stack(columns)]


def with_units(names: Mapping[str, str] = SPOKEN, form: str = "{} [{}]", **units: str) -> tuple[str, ...]:
    return tuple(form.format(names[name], units.get(name, UNITS[name])) for name in TRUTH)


OWN = tuple(NAMES.values())
SIMPLE = text([OWN], rows())
GERMAN = text([with_units(DEUTSCH)], rows(), ";", ",")
TWO_LINES = [tuple(SPOKEN.values()), tuple(UNITS.values())]
MACHINE = (
    "Test report;;;;\nSpecimen;3;;;\nDate;12.03.2026;;;\n\n"
    + text([tuple(DEUTSCH.values()), ("[N]", "[N]", "[mm]", "[mm]", "[\u00b0]")], rows(), ";", ",")
)  # fmt: skip


def more(column: str, cells: list[str], header: tuple[str, ...] = OWN, mark: str = ",", decimal: str = ".") -> str:
    return text([(*header, column)], [[*row, cell] for row, cell in zip(rows(), cells, strict=True)], mark, decimal)


def of_units(**units: str) -> str:
    return text([with_units(**units)], rows({**UNITS, **units}))


READ: dict[str, str | bytes] = {
    "our names": SIMPLE,
    "semicolons": text([OWN], rows(), ";"),
    "tabs": text([OWN], rows(), "\t"),
    "blanks between columns": text([OWN], rows(), "   "),
    "German spreadsheet": GERMAN,
    "tabs and decimal commas": text([with_units(DEUTSCH)], rows(), "\t", ","),
    "byte order mark": GERMAN.encode("utf-8-sig"),
    "UTF-16 as Excel's Unicode text": text([OWN], rows(), "\t").encode("utf-16"),
    "UTF-16 without its mark": SIMPLE.encode("utf-16-be"),
    "Latin-1": text([with_units(DEUTSCH, theta="\u00b0")], rows(), ";", ",").encode("latin-1"),
    "units in brackets": of_units(),
    "units in parentheses": text([with_units(form="{} ({})")], rows()),
    "units after an underscore": text([with_units(form="{}_{}")], rows()),
    "units after 'in'": text([with_units(DEUTSCH, "{} in {}")], rows(), ";", ","),
    "units in a second line": text(TWO_LINES, rows()),
    "a testing machine's report": MACHINE,
    "gram-force": of_units(lam_l="gf", lam_r="gf"),
    "kilogram-force": of_units(lam_l="kgf", lam_r="kgf"),
    "pound-force": of_units(lam_l="lbf", lam_r="lbf"),
    "kilonewton and newton": of_units(lam_l="kN", lam_r="N"),
    "inches": of_units(x="in", z="in"),
    "centimeters and radians": of_units(x="cm", z="cm", theta="rad"),
    "a degree sign": text([with_units(theta="\u00b0")], rows()),
    "words for units": text([with_units(lam_l="newton", x="millimeters", theta="degrees")], rows()),
    "a mark at the end of each line": SIMPLE.replace("\n", ",\n"),
    "every cell quoted": '"' + SIMPLE.replace(",", '","').replace("\n", '"\n"')[:-1],
    "ends of lines of Windows": text([OWN], rows(), end="\r\n"),
    "ends of lines of old Macs": text([OWN], rows(), end="\r"),
    "remarks above": "# rig 3\n# cold\n" + SIMPLE,
    "a column of temperatures": more("Raum [\u00b0C]", ["20.5"] * 5, with_units(DEUTSCH), ";", ","),
    "a column of remarks": more("Bemerkung", ["kalt", "", "", "n/a", ""]),
    "a counter": more("Nr.", list("12345"), with_units()),
    "an empty column": more("spare", [""] * 5, with_units()),
}  # fmt: skip


def same(run: Measurements) -> None:
    for name, values in TRUTH.items():
        np.testing.assert_allclose(getattr(run, name), values, rtol=1e-13, atol=0.0, err_msg=name)


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    def _write(content: str | bytes, name: str = "run.csv") -> Path:
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return _write


@pytest.mark.parametrize("kind", READ)
def test_a_kind_of_file_is_read_right(write: Callable[..., Path], kind: str) -> None:
    """Written by the test: every number of the file."""
    run = imported(write(READ[kind], "run.txt"))
    assert isinstance(run, Measurements), run
    same(run)


@pytest.mark.parametrize("blank", ["", "NaN", "nan", "-", "--", "n/a", "N/A", "#N/A", "#NV", "NA", " "])
def test_blanks_of_every_spelling(write: Callable[..., Path], blank: str) -> None:
    """Written by the test: one reading is missing."""
    cells = rows()
    cells[2][3] = blank
    run = imported(write(text([with_units()], cells)))
    assert isinstance(run, Measurements)
    assert np.isnan(run.z).tolist() == [False, False, True, False, False]


@pytest.mark.parametrize(
    "times",
    [
        ["2026-03-01T12:00:00", "2026-03-01T12:00:01.5", "2026-03-01T12:00:03", "2026-03-02T12:00:00", ""],
        ["2026-03-01 12:00:00Z", "2026-03-01 13:00:01.5+01:00", "2026-03-01 12:00:03Z", "2026-03-02 12:00:00Z", "-"],
        ["01.03.2026 12:00:00", "01.03.2026 12:00:01,5", "1.3.2026 12:00:03", "02.03.2026 12:00:00", "n/a"],
    ],
)
def test_dates_and_times(write: Callable[..., Path], times: list[str]) -> None:
    """By hand: seconds since the first row; a day has 86 400."""
    run = imported(write(more("Timestamp", [f'"{time}"' for time in times], with_units())))
    assert isinstance(run, Measurements)
    np.testing.assert_array_equal(run.t, [0.0, 1.5, 3.0, 86400.0, np.nan])
    same(run)


def test_a_file_without_names(write: Callable[..., Path]) -> None:
    """Written by the test: refused with the cure, and read with it."""
    path = write(text([], rows(), " "), "run.txt")
    with pytest.raises(InputError, match="name columns by place: --rename 1=lam_l_N --rename 2=lam_r_N"):
        read_measurements(path)
    assert isinstance(imported(path), Doubts)
    run = imported(path, {str(i + 1): name for i, name in enumerate(OWN)})
    assert isinstance(run, Measurements)
    same(run)


def test_many_files(write: Callable[..., Path], tmp_path: Path) -> None:
    """Written by the test: two files are two sessions."""
    write(SIMPLE, "a.csv")
    write(SIMPLE, "b.csv")
    run = read_measurements(tmp_path / "?.csv")
    assert run.session.tolist() == ["a"] * 5 + ["b"] * 5
    same(run.select(run.session == "b"))


@pytest.mark.slow
def test_workbooks(tmp_path: Path) -> None:
    """Written by the test: a plain sheet; one with a title, a line of units and a second sheet of words."""
    openpyxl = pytest.importorskip("openpyxl")
    numbers = [[float(cell) for cell in row] for row in rows()]
    for name, head in {
        "plain.xlsx": [OWN],
        "titled.xlsx": [("Pr\u00fcfstand 3",), (), tuple(DEUTSCH.values()), ("[N]", "[N]", "[mm]", "[mm]", "[\u00b0]")],
    }.items():
        book = openpyxl.Workbook()
        book.active.title = "Daten"
        for row in [*head, *numbers]:
            book.active.append(row)
        book.create_sheet("Info").append(["cold"])
        book.save(tmp_path / name)
        run = imported(tmp_path / name)
        assert isinstance(run, Measurements), run
        same(run)
    book["Info"].append([1.0, 2.0])
    book.save(tmp_path / "two.xlsx")
    with pytest.raises(InputError, match="has the sheets Daten, Info; say which: sheet = 'Daten' in the file of"):
        imported(tmp_path / "two.xlsx")
    run = imported(tmp_path / "two.xlsx", layout=Layout(sheet="Daten"))
    assert isinstance(run, Measurements)
    same(run)
    book["Daten"]["A6"] = "=2*A5"
    del book["Info"]
    book.save(tmp_path / "formula.xlsx")
    with pytest.raises(InputError, match="row 6: holds a formula without its value; open the file in a spreadsheet"):
        imported(tmp_path / "formula.xlsx")


@pytest.mark.slow
def test_matlab_files(tmp_path: Path) -> None:
    """Written by the test: vectors, a struct beside a matrix of other length, a matrix in a cell array."""
    from scipy.io import savemat

    columns = dict(zip(OWN, np.array(rows(), dtype=float).T, strict=True))
    savemat(tmp_path / "vectors.mat", columns)
    savemat(tmp_path / "struct.mat", {"run": columns, "rate": 50.0, "calibration": np.eye(3)})
    run = imported(tmp_path / "vectors.mat")
    assert isinstance(run, Measurements)
    same(run)
    run = imported(tmp_path / "struct.mat", {f"run.{name}": name for name in OWN})
    assert isinstance(run, Measurements)
    same(run)
    cell = np.empty((1, 2), dtype=object)
    cell[0, 0], cell[0, 1] = "cold", np.array(rows(), dtype=float)[:, :4]
    savemat(tmp_path / "cell.mat", {"runs": cell})
    run = imported(tmp_path / "cell.mat", {f"runs{{2}}[{i + 1}]": name for i, name in enumerate(OWN[:4])})
    assert isinstance(run, Measurements)
    np.testing.assert_allclose(run.z, TRUTH["z"], rtol=1e-13)


OWN_Z = ("Force left [N]", "Force right [N]", "Position x [mm]", "z down [mm]", "Angle [deg]")
CURED: dict[str, tuple[str, str]] = {
    "grams as a force": (of_units().replace("left [N]", "left [g]"), "Force left [g]: whether g is meant as a force"),
    "pixels": (of_units().replace("z [mm]", "z [px]"), "Position z [px]: its unit (px is none of z)"),
    "no units": (text([tuple(SPOKEN.values())], rows()), "Force left: its unit"),
    "z turned": (text([with_units()], rows(signs={"z": -1.0})),
                 "Position z [mm]: its sign, or which tendon is left: they contradict each other"),
    "theta turned": (text([with_units()], rows(signs={"theta": -1.0})), "Angle [deg]: its sign, or which tendon is"),
    "x turned": (text([with_units()], rows(signs={"x": -1.0})), "Position x [mm]: its sign: all are negative"),
    "pulls as negative forces": (text([with_units()], rows(signs={"lam_l": -1.0})), "Force left [N]: its sign"),
    "a word not known": (text([OWN_Z], rows()), "z down [mm]: what 'down' means"),
    "radians under degrees": (text([with_units()], rows({**UNITS, "theta": "rad"})), "its unit: the angle does not go"),
    "raw and filtered": (more("Force left raw [N]", ["1"] * 5, with_units()), "which of 2 columns is lam_l"),
    "three axes": (more("Position y [mm]", ["1"] * 5, with_units()), "which two of the three axes are the plane"),
    "numbered tendons": (of_units().replace("left", "1").replace("right", "2"), "Force 1 [N]: which tendon"),
    "a push": (more("Push [N]", ["0", "1", "2", "3", "4"], with_units()),
               "Push [N]: which load it is: lam_l, lam_r, fx or fz"),
    "a displacement": (more("delta_l_mm", ["1"] * 5), "delta_l_mm: what it is, 1 to 1 in mm"),
    "numbers with their units": (of_units().replace("\n40,", "\n40 N,"), "cells such as '40 N' hold no number"),
    "x and z exchanged": (of_units().replace("x [mm]", "a").replace("z [mm]", "x [mm]").replace("n a,", "n z [mm],"),
                          "whether x is along the neck: it changes much"),
}  # fmt: skip


@pytest.mark.parametrize("kind", CURED)
def test_what_is_not_certain_is_asked(write: Callable[..., Path], kind: str) -> None:
    """By hand: the question."""
    content, question = CURED[kind]
    doubts = imported(write(content))
    assert isinstance(doubts, Doubts)
    assert question in "; ".join(doubts)


@pytest.mark.parametrize(
    ("content", "name", "cure"),
    [
        (SIMPLE, "run.xls", "file type '.xls' is not known; allowed are .csv, .txt, .tsv, .dat, .asc, .xlsx"),
        ("x;z\n1.234;2\n5.678;3\n", "run.csv", "numbers such as 1.234 could be thousands or decimals; say decimal"),
        ("x;z\n1,5;2\n5.5;3\n", "run.csv", "some numbers are written with a decimal point and some with a comma"),
        ("x;z\n1;2\n5;3;4\n", "run.csv", "line 3: has 3 cells, the header names 2 columns"),
        ("", "run.csv", "is empty; the first line names the columns"),
    ],
)
def test_what_cannot_be_read_is_refused(write: Callable[..., Path], content: str, name: str, cure: str) -> None:
    """By hand: the text of the error."""
    with pytest.raises(InputError) as caught:
        imported(write(content, name))
    assert cure in str(caught.value)
