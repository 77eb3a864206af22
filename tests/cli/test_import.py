"""``ecm-fast import``: what it proposes, asks and refuses; files and answers by hand."""

import io
import sys
from pathlib import Path

import pytest
from commands import Refused, Run

from ecm_fast import read_measurements

GERMAN = """\
Pr\u00fcfstand 3;12.03.2026
Zeit;Seil links;Seil rechts;Bild x;Bild z;Winkel;Raum;Bemerkung
[hh:mm:ss];[kgf];[kgf];[mm];[mm];[\u00b0];[\u00b0C];
12:00:00;1,5;0,5;108,6;3,25;-3,4;20,5;kalt
12:00:10;2,5;0,5;108,1;6,5;-7;20,6;
12:00:20;0,5;0,5;109;0,1;0;20,6;
12:00:30;0,5;2,5;108,2;-6,4;7,1;20,6;#N/A
"""
OPEN = "F1 [N],F2 [N],x [mm],y [mm]\n1,2,100,3\n3,2,100,5\n"


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_what_is_certain_is_written_and_used(run: Run) -> None:
    """By hand: names, units and signs of a German spreadsheet; SI values of its second row."""
    Path("run.csv").write_text(GERMAN, encoding="latin-1")
    ended = run("import", "run.csv")
    assert ended.code == 0
    assert "Bild z [mm]        z_mm       certain ('z', unit mm; the tendon forces show its sign)\n" in ended.out
    assert ended.out.endswith("\nnext: ecm-fast predict run.csv --columns map.toml\n")
    data = read_measurements("run.csv", columns="map.toml")
    assert data.columns == ("t_s", "lam_l_kgf", "lam_r_kgf", "x_mm", "z_mm", "theta_deg")
    assert data.lam[1].tolist() == [24.516625, 4.903325]
    assert data.t.tolist() == [0.0, 10.0, 20.0, 30.0]
    assert run("predict", "run.csv", "--columns", "map.toml", "--mechanism", "bare.toml").code == 0
    assert "map.toml: exists; --force overwrites it" in run("import", "run.csv").err


def test_a_sign_that_contradicts_the_forces_is_asked(run: Run) -> None:
    """By hand: z turned; in the plane a pull at the left tendon moves the head to +z."""
    Path("run.csv").write_text(GERMAN.replace(";-", ";+").replace(";3,25;", ";-3,25;").replace(";6,5;", ";-6,5;"))
    ended = run("import", "run.csv", "--json")
    z = ended.json["columns"][4]
    assert (z["told"], z["doubt"]) == ("-z_mm", "its sign, or which tendon is left: they contradict each other")
    assert not Path("map.toml").exists()


def test_without_a_terminal_what_is_open_is_refused(run: Run) -> None:
    """By hand: the text of the error, whose words then settle it."""
    Path("run.csv").write_text(OPEN)
    ended = run("import", "run.csv")
    words = ["--rename", "F1 [N]=lam_l_N", "--rename", "F2 [N]=lam_r_N", "--rename", "y [mm]=z_mm"]
    assert ended.code == 2
    assert ended.err == (
        "ecm-fast: run.csv: 3 of 4 columns are not certain, nothing is written; where a proposal is right repeat it: "
        "--rename 'F1 [N]=lam_l_N' --rename 'F2 [N]=lam_r_N' --rename 'y [mm]=z_mm'; =note ignores a column\n"
    )
    assert not Path("map.toml").exists()
    assert run("import", "run.csv", *words).code == 0
    assert read_measurements("run.csv", "map.toml").z.tolist() == [0.003, 0.005]
    assert run("import", "run.csv", "--force", "--rename", "*=note").code == 0
    assert read_measurements("run.csv", "map.toml").columns == ("x_mm",)


def test_at_a_terminal_what_is_open_is_asked(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """By hand: an empty line takes the proposal, nonsense is asked again."""
    Path("run.csv").write_text(OPEN)
    monkeypatch.setattr(sys, "stdin", Terminal("\nlam_r\nlam_r_N\n-z_mm\n"))
    ended = run("import", "run.csv", "--map", "own.toml")
    assert "F2 [N]: which tendon, what '2' means?\n" in ended.err
    assert "the unit is missing; allowed are lam_r_N" in ended.err
    data = read_measurements("run.csv", "own.toml")
    assert data.lam.tolist() == [[1.0, 2.0], [3.0, 2.0]]
    assert data.z.tolist() == [-0.003, -0.005]
    monkeypatch.setattr(sys, "stdin", Terminal(""))
    assert "column 'F1 [N]': not answered; nothing is written" in run("import", "run.csv").err


def test_many_files_share_a_map(run: Run) -> None:
    """By hand: two files as sessions; a third with another column is refused by name."""
    for name in ("a", "b"):
        Path(f"{name}.csv").write_text(GERMAN, encoding="latin-1")
    answer = run("import", "?.csv", "--json").json
    assert [(one["file"], one["rows"]) for one in answer["files"]] == [("a.csv", 4), ("b.csv", 4)]
    assert read_measurements("?.csv", "map.toml").session.tolist() == ["a"] * 4 + ["b"] * 4
    Path("c.csv").write_text(GERMAN.replace("Bild z", "z"))
    assert "c.csv: has no column 'Bild z [mm]'" in run("import", "?.csv", "--force").err


def test_what_cannot_be_imported(refused: Refused) -> None:
    """By hand: the text of the error."""
    Path("run.csv").write_text("x;z\n1.234;2\n")
    assert refused("import", "run.csv").startswith("run.csv: numbers such as 1.234 could be thousands or decimals; ")
    Path("run.csv").write_text(OPEN)
    assert refused("import", "run.csv", "--rename", "F3=lam_l_N").startswith("run.csv: has no column 'F3'; it has ")
    assert refused("import", "run.csv", "--header", "9") == "run.csv: header = 9: there is nothing in that line"


def test_poses_that_begin_at_rest_are_asked(run: Run) -> None:
    """By hand: x of the same spreadsheet less its third row, the neck at rest."""
    zeroed = GERMAN
    for x, relative in (("108,6", "-0,4"), ("108,1", "-0,9"), ("109", "0"), ("108,2", "-0,8"), (";0,1;", ";0;")):
        zeroed = zeroed.replace(x, relative)
    Path("run.csv").write_text(zeroed, encoding="latin-1")
    ended = run("import", "run.csv")
    assert ended.code == 2
    assert ended.err.endswith(
        "1 of 8 columns are not certain, nothing is written; where a proposal is right repeat it: --rename "
        "'Bild x [mm]=x_mm'; =note ignores a column; poses relative to the pose at rest are told by --zeroed first, "
        "session or unloaded\n"
    )
    assert run("import", "run.csv", "--zeroed", "unloaded").code == 0
    assert 'zeroed = "unloaded"\n' in Path("map.toml").read_text(encoding="utf-8")
