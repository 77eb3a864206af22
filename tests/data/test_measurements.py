"""Measurement files: every number and every text below was worked out by hand."""

from dataclasses import FrozenInstanceError, fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ecm_fast.data.columns import COLUMNS
from ecm_fast.data.measurements import Measurements, read_measurements
from ecm_fast.errors import InputError

GOOD = "lam_l_N,lam_r_N,x_mm,z_mm,theta_deg\n40,10,98.5,-12.25,18\n0,0,109,0,0\n"


@pytest.fixture
def read(tmp_path: Path) -> Any:
    """Return a function that reads `content` from a file; errors lose the path, which must lead them."""

    def _read(content: str | bytes, name: str = "run.csv") -> Measurements:
        path = tmp_path / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return read_measurements(path)

    return _read


@pytest.fixture
def refused(read: Any, tmp_path: Path) -> Any:
    def _refused(content: str | bytes, name: str = "run.csv") -> str:
        with pytest.raises(InputError) as caught:
            read(content, name)
        text = str(caught.value)
        assert text.startswith(f"{tmp_path / name}: ")
        assert len(text.splitlines()) == 1
        return text.removeprefix(f"{tmp_path / name}: ")

    return _refused


def test_the_fields_are_the_declared_columns() -> None:
    """Contract: one field a declared column."""
    names = [entry.name for entry in fields(Measurements)]
    assert names == [*COLUMNS, "rows", "columns", "source", "counted", "named", "ignored", "zeroed", "slack"]


def test_a_file_in_millimeters_and_degrees(read: Any, tmp_path: Path) -> None:
    """By hand: SI values of two rows."""
    run = read(GOOD)
    assert run.lam.tolist() == [[40.0, 10.0], [0.0, 0.0]]
    assert run.pose.tolist() == [[0.0985, -0.01225, np.pi / 10], [0.109, 0.0, 0.0]]
    assert run.wrench.tolist() == [[0.0] * 3] * 2
    assert run.measured.all()
    assert run.extra_mass.tolist() == run.tilt.tolist() == [0.0, 0.0]
    assert np.isnan([run.t, run.dwell, run.sigma_x, run.sigma_z, run.sigma_theta, run.sigma_lam]).all()
    assert run.experiment.tolist() == run.pose_id.tolist() == run.session.tolist() == ["", ""]
    assert run.columns == ("lam_l_N", "lam_r_N", "x_mm", "z_mm", "theta_deg")
    assert run.source == str(tmp_path / "run.csv")
    assert run.rows.tolist() == [2, 3]
    assert run.where(1) == f"{tmp_path / 'run.csv'}: line 3"
    assert run.n == len(run) == 2


@pytest.mark.parametrize(
    ("column", "cell", "si"),
    [
        ("lam_l_kN", "0.16", 160.0),
        ("lam_l_mN", "2500", 2.5),
        ("lam_l_kgf", "2", 19.6133),  # 9.80665 N: the standard acceleration of free fall
        ("lam_l_gf", "100", 0.980665),
        ("lam_l_lbf", "10", 44.482216152605),
        ("x_in", "0.5", 0.0127),  # 25.4 mm
        ("tau_Ncm", "250", 2.5),
        ("tau_kgfcm", "10", 0.980665),
        ("fx_N", "-3", -3.0),
        ("fx_N", "-1e6", -1e6),  # the largest size that is allowed
        ("fz_kN", "1e-3", 1.0),
        ("tau_Nm", "+1.5", 1.5),
        ("tau_Nmm", "-250", -0.25),
        ("tau_kNm", "0.011", 11.0),
        ("x_m", ".109", 0.109),
        ("x_cm", "10.9", 0.109),
        ("x_mm", "109", 0.109),
        ("x_um", "109000", 0.109),
        ("z_m", "-1.", -1.0),
        ("theta_mrad", "200", 0.2),
        ("theta_deg", "90", np.pi / 2),
        ("t_s", "-4", -4.0),
        ("t_ms", "1500", 1.5),
        ("t_min", "2", 120.0),
        ("t_h", "0.5", 1800.0),
        ("dwell_min", "0.5", 30.0),
        ("extra_mass_kg", "0.2", 0.2),
        ("extra_mass_g", "200", 0.2),
        ("tilt_deg", "180", np.pi),
        ("sigma_x_mm", "0.1", 0.0001),
        ("sigma_theta_mrad", "1", 0.001),
        ("sigma_lam_N", "0", 0.0),
    ],
)
def test_a_unit_is_converted(read: Any, column: str, cell: str, si: float) -> None:
    """By hand: one cell in every unit."""
    other = "lam_r_N" if column != "lam_r_N" else "lam_l_N"
    run = read(f"{column},{other}\n{cell},1\n")
    assert getattr(run, column.rsplit("_", 1)[0]).tolist() == [si]


def test_blanks_are_kept_as_missing_and_the_order_of_rows_too(read: Any) -> None:
    """By hand: three rows."""
    run = read("t_s,lam_l_N,x_mm,z_mm,experiment,pose_id,session\n9,3,,1,shear,b,2\n1,2,  ,,,,\n5,1,4,2, a b ,a,1.0\n")
    assert run.lam_l.tolist() == [3.0, 2.0, 1.0]
    assert run.t.tolist() == [9.0, 1.0, 5.0]
    assert run.measured.tolist() == [[False, True, False], [False, False, False], [True, True, False]]
    assert run.experiment.tolist() == ["shear", "", "a b"]
    assert run.pose_id.tolist() == ["b", "", "a"]
    assert run.session.tolist() == ["2", "", "1.0"]


def test_what_spreadsheets_and_editors_do_to_a_file_is_harmless(read: Any) -> None:
    """By hand: the same numbers with quotes, comments, blanks and a byte order mark."""
    plain = read(GOOD)
    quoted = '\ufeff# rig 3, "cold"\r\n\r\n"lam_l_N", lam_r_N ,x_mm,z_mm,theta_deg\r\n"40", 10,98.5,-12.25,18\r\n\r\n'
    run = read(quoted + ",,,,\r\n0,0,109,0,0")
    assert run.pose.tolist() == plain.pose.tolist()
    assert run.rows.tolist() == [4, 7]
    for delimiter in ";\t":
        assert read(GOOD.replace(",", delimiter)).pose.tolist() == plain.pose.tolist()
    assert read(GOOD.replace("\n", "\r")).rows.tolist() == [2, 3]
    assert read(GOOD, "RUN.TXT").lam.tolist() == plain.lam.tolist()


def test_a_record_counts_from_its_first_line(read: Any) -> None:
    """By hand: line numbers."""
    assert read('lam_l_N,note_weather\n1,"cold\nand wet"\n2,\n').rows.tolist() == [2, 4]


def test_notes_are_ignored(read: Any) -> None:
    """By hand: columns that are not read."""
    run = read("lam_l_N,Notes,note_x_mm\n1,nan,abc\n")
    assert run.columns == ("lam_l_N",)
    assert np.isnan(run.x).all()


def test_a_selection_keeps_its_places(read: Any) -> None:
    """By hand: rows and their line numbers."""
    run = read("lam_l_N,experiment\n1,shear\n2,tendon\n3,shear\n")
    shear = run.select(run.experiment == "shear")
    assert shear.lam_l.tolist() == [1.0, 3.0]
    assert shear.rows.tolist() == [2, 4]
    assert run.select([2, 0, 2]).lam_l.tolist() == [3.0, 1.0, 3.0]
    assert run.select([]).n == 0
    assert run.lam_l.tolist() == [1.0, 2.0, 3.0]
    with pytest.raises(InputError, match=r"run\.csv: cannot select these rows \(boolean index did not match"):
        run.select([True, False])
    with pytest.raises(InputError, match=r"cannot select these rows \(index 3 is out of bounds"):
        run.select([3])
    with pytest.raises(InputError, match=r"shape \(1, 2\); allowed is a mask of shape \(3,\) or a list of indices"):
        run.select([[0, 1]])


def test_the_arrays_cannot_be_changed_by_accident(read: Any) -> None:
    """Contract: read-only arrays, in fields that stay."""
    run = read(GOOD)
    with pytest.raises(FrozenInstanceError):
        run.x = run.z
    with pytest.raises(ValueError, match="read-only"):
        run.x[0] = 1.0
    run.lam[0] = 1.0  # made anew each time, so the caller may do what they like
    assert run.lam_l.tolist() == [40.0, 0.0]


def test_repr(read: Any, tmp_path: Path) -> None:
    """By hand: the text."""
    run = read("lam_l_N,x_mm,z_mm,theta_deg\n1,1,1,1\n2,1,1,\n")
    path = tmp_path / "run.csv"
    assert repr(run) == f"<Measurements {path}: 2 rows, 1 with a whole pose; lam_l_N, x_mm, z_mm, theta_deg>"


@pytest.mark.parametrize(
    ("header", "text"),
    [
        ("x", "column 'x': the unit is missing; allowed are x_m, x_cm, x_mm, x_um, x_in, or start its name with "
              "note_ to have it ignored"),
        ("x_foot", "column 'x_foot': 'foot' is not a unit of x; allowed are x_m, x_cm, x_mm, x_um, x_in, or start"),
        ("lam_l_dyn", "column 'lam_l_dyn': 'dyn' is not a unit of lam_l; allowed are lam_l_N, lam_l_kN, lam_l_mN,"),
        ("x_m,delta_l_mm", "unknown column 'delta_l_mm' (known are"),
        ("sigma_x_deg", "'deg' is not a unit of sigma_x; allowed are sigma_x_m, sigma_x_cm, sigma_x_mm, sigma_x_um,"),
        ("left_N", "unknown column 'left_N' (did you mean 'lam_l_N'?); start its name"),
        ("tendon_right", "unknown column 'tendon_right' (did you mean 'lam_r_N'?); start its name"),
        ("X_mm", "unknown column 'X_mm' (did you mean 'x_mm'?); start its name"),
        ("session_nr", "unknown column 'session_nr' (did you mean 'session'?); start its name"),
        ("F815", "unknown column 'F815' (known are lam_l_N, lam_r_N, fx_N, fz_N, tau_Nm, x_m,"),
        ("x_mm,x_mm", "column 'x_mm' is there twice; keep one"),
        ("x_mm,x_m", "columns x_mm and x_m give the same; keep one"),
        ("experiment,t_s", "gives no load and no pose; at least one of the columns lam_l_N, lam_r_N, fx_N, fz_N, "
                           "tau_Nm, extra_mass_kg, tilt_rad, x_m, z_m, theta_rad is needed"),
        ("x_m,angle_deg", "unknown column 'angle_deg' (did you mean 'theta_deg'?); start its name"),
        ("x_m,sigma_fz_N", "unknown column 'sigma_fz_N' (known are sigma_x_m, sigma_z_m, sigma_theta_rad, "
                           "sigma_lam_N); start its name"),
        ("time_s,F_left_N,x_m,side_force_N", "unknown column 'time_s' (did you mean 't_s'?); unknown column 'F_left_N' "
         "(did you mean 'lam_l_N'?); unknown column 'side_force_N' (did you mean 'fz_N'?); start its name"),
        ("x_m,,z_m", "column 2 has no name; name it or delete it"),
        ("x_m,z_m;theta_rad", "column 'x_m,z_m': 'm,z_m' is not a unit of x; allowed are x_m"),
        ("x_m z_m", "names columns but holds no rows"),
        ("x_m", "names columns but holds no rows"),
        ("", "is empty; the first line names the columns"),
        ("# only a remark\n \n", "is empty; the first line names the columns"),
    ],
)  # fmt: skip
def test_a_header_that_cannot_be(refused: Any, header: str, text: str) -> None:
    """By hand: the text of the error."""
    assert refused(header).startswith(text) or f": {text}" in refused(header)


@pytest.mark.parametrize(
    ("column", "cell", "text"),
    [
        ("lam_l_N", "-3", "'-3' (allowed is a finite number >= 0)"),
        ("lam_l_N", "", "blank (allowed is a finite number >= 0; write 0 for none)"),
        ("tau_Nm", " ", "blank (allowed is a finite number; write 0 for none)"),
        ("tilt_deg", "", "blank (allowed is a finite number; write 0 for none)"),
        ("x_mm", "abc", "'abc' (allowed is a finite number, or a blank)"),
        ("x_mm", "-inf", "'-inf' (allowed is a finite number, or a blank)"),
        ("fx_N", "1e400", "'1e400' (allowed is a finite number)"),
        ("fx_kN", "1e308", "'1e308' (allowed is a finite number)"),
        ("fx_N", "1_000", "'1_000' (allowed is a finite number)"),
        ("fx_N", "0x10", "'0x10' (allowed is a finite number)"),
        ("fx_N", "\u0663", "'\u0663' (allowed is a finite number)"),
        ("fx_N", '"4\n2"', "'4\\n2' (allowed is a finite number)"),
        ("dwell_s", "-1", "'-1' (allowed is a finite number >= 0, or a blank)"),
        ("extra_mass_g", "-1", "'-1' (allowed is a finite number >= 0)"),
        ("sigma_theta_mrad", "-1", "'-1' (allowed is a finite number >= 0, or a blank)"),
        ("fx_N", "x" * 50, f"'{'x' * 35} ... (allowed is a finite number)"),
        ("session", "a\x07b", "'a\\x07b' (allowed is printable text of up to 100 characters, or a number)"),
        ("session", "s" * 101, f"'{'s' * 35} ... (allowed is printable text of up to 100 characters, or a number)"),
    ],
)
def test_a_cell_that_cannot_be(refused: Any, column: str, cell: str, text: str) -> None:
    """By hand: the text of the error."""
    content = f"# rig 3\n{column},lam_r_N\n{'a' if column == 'session' else 1},1\n{cell},2\n"
    assert refused(content) == f"line 4, column {column}: {text}"


def test_five_bad_cells_are_shown_in_the_order_of_the_file(refused: Any) -> None:
    """By hand: the text of the error."""
    text = refused("lam_l_N,x_mm\n1,a\n-1,b\n-2,c\n3,d\n4,e\n")
    allowed, pose = "(allowed is a finite number >= 0)", "(allowed is a finite number, or a blank)"
    assert text == (
        f"7 bad cells: line 2, column x_mm: 'a' {pose}; line 3, column lam_l_N: '-1' {allowed}; "
        f"line 3, column x_mm: 'b' {pose}; line 4, column lam_l_N: '-2' {allowed}; "
        f"line 4, column x_mm: 'c' {pose}; and 2 more"
    )


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("lam_l_N,lam_r_N\n1,2\n1,5,2\n", "line 3: has 3 cells, the header names 2 columns (decimals are written with "
                                          "a point)"),
        ("lam_l_N,lam_r_N\n1,2\n1\n", "line 3: has 1 cells, the header names 2 columns"),
        ('lam_l_N,note\n1,"open\n2,\n', "line 3: unexpected end of data"),
        ("lam_l_N,note\n1," + "y" * 200_000 + "\n", "line 2: field larger than field limit (131072)"),
        (GOOD.encode("utf-16")[:-1], "begins as UTF-16 text and goes on as none (byte 138); save it as CSV UTF-8"),
        (GOOD.replace("98.5", '"98,5"'), "some numbers are written with a decimal point and some with a comma; write "
                                         "all with one"),
        ('x_m,z_m\n"1,234",2\n', "numbers such as 1,234 could be thousands or decimals; say decimal = ',' or the "
                                  "other mark in the file of --columns, or --decimal to ecm-fast import"),
        ("x_m;z_m\n1.234;2\n", "numbers such as 1.234 could be thousands or decimals; say decimal = '.' or the "
                                "other mark in the file of --columns, or --decimal to ecm-fast import"),
        ("1,2\n3,4\n", "line 1: holds numbers where the names of the columns are expected: add them, or name columns "
                       "by place: --rename 1=lam_l_N --rename 2=lam_r_N ..."),
        ("x_m,t_s\n1,23:59:59\n1,0:00:01\n", "line 3, column t_s: '0:00:01' (earlier than the time before it, perhaps "
                                            "past midnight: give the date too)"),
        ("lam_l_N\n1\n2\0\n", "line 3: holds a NUL byte, so it is no text; save it as CSV UTF-8"),
    ],
)  # fmt: skip
def test_a_file_that_cannot_be(refused: Any, content: str | bytes, text: str) -> None:
    """By hand: the text of the error."""
    assert refused(content) == text


def test_a_path_that_cannot_be(refused: Any, tmp_path: Path) -> None:
    """By hand: the text of the error."""
    known = ".csv, .txt, .tsv, .dat, .asc, .xlsx, .parquet, .mat"
    assert refused(GOOD, "run.xls") == f"file type '.xls' is not known; allowed are {known}"
    for path, text in [
        (tmp_path / "none.csv", "cannot be read (No such file or directory)"),
        (tmp_path / "none.xlsx", "cannot be read (No such file or directory)"),
        (tmp_path, "cannot be read (Is a directory)"),
        (Path("a\0b.csv"), "cannot be read (embedded null byte)"),
    ]:
        with pytest.raises(InputError) as caught:
            read_measurements(path)
        assert str(caught.value) == f"{path}: {text}"


def test_measurements_from_vectors_in_memory() -> None:
    """By hand: SI values."""
    run = Measurements.from_columns(
        {"lam_l_N": [1, np.float32(2.5)], "x_mm": np.array([[109.0], [np.nan]]), "pose_id": (7, 2.5), "note": None}
    )
    assert run.lam_l.tolist() == [1.0, 2.5]
    assert run.x[0] == 0.109
    assert run.measured[:, 0].tolist() == [True, False]
    assert run.pose_id.tolist() == ["7", "2.5"]
    assert (run.source, run.where(1)) == ("measurements", "measurements: row 2")


class TwoLines:
    def __repr__(self) -> str:
        return "two\nlines"


@pytest.mark.parametrize(
    ("columns", "text"),
    [
        ({"lam_l_N": [1.0], "x_m": [1.0, 2.0]}, "lam_l_N has 1 entries, x_m has 2; all columns are equally long"),
        ({"lam_l_N": np.ones((2, 3))}, "lam_l_N is float64 of shape 2 x 3; allowed is a vector of real numbers or"),
        ({"x_m": np.array([1j, 2])}, "x_m is complex128 of shape 2; allowed is a vector of real numbers or text"),
        ({"t_s": np.array(["2026-01-01"], "M8[ns]"), "x_m": [1]}, "t_s is datetime64[ns] of shape 1; allowed is a "
                                                                  "vector of real numbers or text"),
        ({"raw": np.ones((2, 3))}, "unknown column 'raw' (known are lam_l_N, "),
        ({"x_m": [True]}, "row 1, column x_m: True (allowed is a finite number, or a blank)"),
        ({"x_m": [10**400]}, "row 1, column x_m: 100000000000000000000000000000000000 ... (allowed is a finite number"),
        ({"x_m": [TwoLines()]}, "row 1, column x_m: two lines (allowed is a finite number"),
        ({"x_m": [1], "session": [float("inf")]}, "row 1, column session: inf (allowed is printable text"),
        ({"x_m": []}, "names columns but holds no rows"),
        ({}, "gives no load and no pose; at least one of"),
    ],
)  # fmt: skip
def test_vectors_that_cannot_be(columns: dict[str, Any], text: str) -> None:
    """By hand: the text of the error."""
    with pytest.raises(InputError) as caught:
        Measurements.from_columns(columns, source="trial")
    assert str(caught.value).startswith(f"trial: {text}")


@pytest.mark.slow
def test_30000_rows(read: Any) -> None:
    """By hand: three of the rows."""
    rows = "".join(f"{i},{30000 - i},{i / 7!r},-1e-3,18,tendon\n" for i in range(30000))
    run = read("lam_l_N,lam_r_N,x_mm,z_mm,theta_deg,experiment\n" + rows)
    assert run.n == 30000
    assert run.lam[12345].tolist() == [12345.0, 17655.0]
    assert run.x[700] == 0.1
    assert run.rows[-1] == 30001


def test_what_is_written_reads_back_to_the_last_digit(tmp_path: Path) -> None:
    """Round trip: awkward numbers in every column."""
    awkward = [1 / 3, 5e-324, 999.9999999999999, 0.1 + 0.2]
    run = Measurements.from_columns(
        {
            **{name: awkward for column in COLUMNS.values() for name in column.names[:1] if column.units},
            "z_m": [None, -0.0, -1 / 3, None],
            "experiment": ["a, b", '"quoted"', "#1", ""],
            "pose_id": ["7", "", "zwölf", "a;b"],
            "session": [1, 2, 2, 3],
        }
    )
    path = run.to_csv(tmp_path / "run.csv", "Where from: the laboratory.\n\nSecond paragraph, with a comma.")
    again = read_measurements(path)
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(again, name), getattr(run, name), err_msg=name)
    assert np.signbit(again.z[1])
    assert again.rows.tolist() == [5, 6, 7, 8]
    comment = path.read_text(encoding="utf-8").splitlines()[:3]
    assert comment == ["# Where from: the laboratory.", "#", "# Second paragraph, with a comma."]


def test_columns_that_hold_nothing_are_not_written(tmp_path: Path) -> None:
    """By hand: the text of the file."""
    run = Measurements.from_columns({"x_mm": [98.5, None], "tilt_rad": [0.0, 0.0], "session": ["", ""]})
    path = run.to_csv(tmp_path / "run.csv")
    assert path.read_text(encoding="utf-8") == "lam_l_N,lam_r_N,x_m\n0.0,0.0,0.0985\n0.0,0.0,\n"


def test_without_rows_nothing_is_written(tmp_path: Path) -> None:
    """By hand: the text of the error."""
    run = Measurements.from_columns({"x_mm": [98.5]}).select([])
    with pytest.raises(InputError, match=r"run\.csv: no rows to write; a measurement file has at least one$"):
        run.to_csv(tmp_path / "run.csv")
    assert not (tmp_path / "run.csv").exists()


def test_noise_is_declared_where_it_is_not() -> None:
    """By hand: SI values."""
    data = Measurements.from_columns({"x_m": [0.1, 0.2], "sigma_x_mm": [None, 0.3]})
    found = data.with_noise({"x_mm": 0.1, "theta_deg": 180.0, "lam_N": 0.2})
    np.testing.assert_allclose(found.sigma_x, [1e-4, 3e-4], rtol=1e-15)
    np.testing.assert_allclose(found.sigma_theta, np.pi, rtol=1e-15)
    np.testing.assert_array_equal(found.sigma_lam, 0.2)
    assert np.isnan(found.sigma_z).all()
    assert found.columns == ("x_m", "sigma_x_mm", "sigma_theta_deg", "sigma_lam_N")
    assert np.isnan(data.sigma_x[0])


@pytest.mark.parametrize(
    ("noise", "text"),
    [
        ({"fz_N": 1.0}, "noise of fz_N: allowed are x_m, x_cm, x_mm, x_um, x_in, z_m"),
        ({"x": 1.0}, "noise of x: allowed are x_m, x_cm, x_mm, x_um, x_in, z_m"),
        ({"x_mm": 0.0}, "noise of x_mm = 0.0: allowed is a number > 0"),
    ],
)
def test_noise_that_cannot_be(noise: dict[str, float], text: str) -> None:
    """By hand: the text of the error."""
    with pytest.raises(InputError) as caught:
        Measurements.from_columns({"x_m": [0.1]}).with_noise(noise)
    assert str(caught.value).startswith(text)
