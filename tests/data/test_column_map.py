"""Maps of columns: files with names of their own, read with what is told of them; all numbers by hand."""

from pathlib import Path

import numpy as np
import pytest

from ecm_fast.data.column_map import ColumnMap
from ecm_fast.data.measurements import read_measurements
from ecm_fast.errors import InputError

GERMAN = "Seil links [kgf];Bild z [mm];Bild x [mm];T [°C];Bemerkung\n1,5;-12,25;98,5;20,5;kalt\n0,5;0;109;20,6;\n"
MAP = """\
decimal = ","

[columns]
"Seil links [kgf]" = "lam_l_kgf"
"Bild z [mm]" = "-z_mm"
"Bild x [mm]" = "-2*x_mm"
Bemerkung = "note"
"""


def test_a_file_is_read_with_its_map(tmp_path: Path) -> None:
    """By hand: SI values; 1 kgf is 9.80665 N."""
    (tmp_path / "map.toml").write_text(MAP, encoding="utf-8")
    (tmp_path / "run.csv").write_text(GERMAN, encoding="utf-8-sig")
    run = read_measurements(tmp_path / "run.csv", columns=tmp_path / "map.toml")
    assert run.lam.tolist() == [[1.5 * 9.80665, 0.0], [0.5 * 9.80665, 0.0]]
    assert run.pose[:, :2].tolist() == [[-0.197, 0.01225], [-0.218, 0.0]]
    assert run.columns == ("lam_l_kgf", "z_mm", "x_mm")
    assert run.ignored == ("T [°C]",)


def test_a_map_is_written_as_it_reads(tmp_path: Path) -> None:
    """Round trip: awkward names, with reasons behind them."""
    columns = {'F "left"\t[N]': "lam_l_N", "Kraft = [N]": "-fx_N", "é": "note", "3": "1e-3*x_m", "*": "note"}
    told = ColumnMap.from_dict({"decimal": ",", "header": 3, "sheet": "Tab \\ 1", "columns": columns})
    again = ColumnMap.from_toml(told.to_toml(tmp_path / "map.toml", "Of run.csv.", {"é": "no unit"}))
    assert again == told
    assert '"é" = "note"  # no unit' in (tmp_path / "map.toml").read_text(encoding="utf-8")


def test_columns_without_names_go_by_their_places(tmp_path: Path) -> None:
    """By hand: three columns."""
    (tmp_path / "run.txt").write_text("1 2 -3\n4 5 6\n")
    run = read_measurements(tmp_path / "run.txt", {"1": "lam_r_N", "3": "z_cm", "*": "note"})
    assert run.lam_r.tolist() == [1.0, 4.0]
    assert run.z.tolist() == [-0.03, 0.06]


def test_files_of_a_pattern_become_sessions(tmp_path: Path) -> None:
    """By hand: two files; a session that a file gives itself is kept."""
    (tmp_path / "a.csv").write_text("lam_l_N,x_mm\n1,10\n2,20\n")
    (tmp_path / "b.csv").write_text("lam_l_kN,session\n3,7\n")
    run = read_measurements(tmp_path / "*.csv")
    assert run.lam_l.tolist() == [1.0, 2.0, 3000.0]
    assert run.session.tolist() == ["a", "a", "b 7"]
    np.testing.assert_array_equal(run.x, [0.01, 0.02, np.nan])
    with pytest.raises(InputError, match=r"\*\.dat: fits no file$"):
        read_measurements(tmp_path / "*.dat")


@pytest.mark.parametrize(
    ("columns", "text"),
    [
        ({"F [N]": "lam_l_N", "x": "x_mm"}, "run.csv: has no column 'x', which the map names; it has 'F [N]', "
                                            "'Push [N]'"),
        ({"F [N]": "lam_l_kgf", "*": "note"}, "run.csv: column 'F [N]' has the unit N in its name, and kgf is told; "
                                              "where the name is wrong rename it, or tell N with a factor"),
        ({"F [N]": "lam_l_N"}, "run.csv: column 'Push [N]' is not in the map; add it, or \"*\" = \"note\" to have all "
                               "others ignored"),
        ({"F [N]": "lam_l"}, "'F [N]' = 'lam_l': column 'lam_l': the unit is missing; allowed are lam_l_N, "),
        ({"F [N]": "-session"}, "'F [N]' = '-session': text takes no sign and no factor"),
        ({"F [N]": ".*lam_l_N"}, "'F [N]' = '.*lam_l_N': . is no number"),
        ({"F [N]": ""}, "'F [N]' = '': says nothing; \"note\" has a column ignored"),
        ({"F [N]": "lam_l_N", "*": "x_mm"}, "* = 'x_mm': allowed is 'note', to have all other columns ignored"),
    ],
)  # fmt: skip
def test_a_map_that_does_not_fit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, columns: dict[str, str], text: str
) -> None:
    """By hand: the text of the error."""
    monkeypatch.chdir(tmp_path)
    Path("run.csv").write_text("F [N],Push [N]\n1,2\n")
    with pytest.raises(InputError) as caught:
        read_measurements("run.csv", columns)
    assert str(caught.value).startswith(text)


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("colums = {}", "unknown key 'colums' (did you mean 'columns'?); allowed are columns, decimal, header, sheet"),
        ("columns = 1", "columns = 1: allowed is a table"),
        ("header = true", "header = True: allowed is a line number"),
        ("decimal = ';'", "decimal = ';': allowed is ',' or '.'"),
        ("columns.a = 1", 'columns.a = 1: allowed is text, such as "lam_l_N"'),
        ("columns", "not a TOML file ("),
    ],
)
def test_a_file_that_is_no_map(tmp_path: Path, content: str, text: str) -> None:
    """By hand: the text of the error."""
    path = tmp_path / "map.toml"
    path.write_text(content)
    with pytest.raises(InputError) as caught:
        ColumnMap.from_toml(path)
    assert str(caught.value).startswith(f"{path}: {text}")
