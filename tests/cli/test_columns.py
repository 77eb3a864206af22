"""Files with names of their own, from the command line."""

from pathlib import Path

import pytest
from commands import Refused, Run

from ecm_fast.cli import COMMANDS
from ecm_fast.cli.frame.arguments import parse

PLAIN = "lam_l_N,lam_r_N,x_mm,z_mm\n40,10,108.5,4.5\n80,10,107.5,10.5\n"
OWN = "F links [gf];F rechts [gf];x;y [mm];Raum [°C]\n{};{};108,5;-4,5;20,5\n{};{};107,5;-10,5;20,5\n"


def test_a_file_with_its_map_gives_what_a_plain_one_gives(run: Run) -> None:
    """Consistency: the same numbers under other names, units, signs and separators; one line names what is ignored."""
    forces = [f"{force / 9.80665e-3!r}".replace(".", ",") for force in (40.0, 10.0, 80.0, 10.0)]
    Path("own.csv").write_text(OWN.format(*forces), encoding="latin-1")
    Path("plain.csv").write_text(PLAIN)
    Path("map.toml").write_text('[columns]\n"F links [gf]" = "lam_l_gf"\n"y [mm]" = "-z_mm"\nx = "x_mm"\n')
    expected = run("predict", "plain.csv", "--mechanism", "bare.toml", "--json").json
    words = ("--columns", "map.toml", "--rename", "F rechts [gf]=lam_r_gf")
    ended = run("predict", "own.csv", "--mechanism", "bare.toml", "--json", *words)
    assert ended.json["rms"]["x_m"] == pytest.approx(expected["rms"]["x_m"], rel=1e-9)
    assert ended.json["rms"]["z_m"] == pytest.approx(expected["rms"]["z_m"], rel=1e-9)
    assert "ecm-fast: own.csv: ignored Raum [°C]\n" in ended.err


def test_every_command_takes_a_map() -> None:
    """Contract: every command that takes measurements takes a map of their columns."""
    for name, words in {
        "predict": ("run.csv",),
        "identify": ("run.csv", "--fit", "EI"),
        "diagnose": ("run.csv",),
        "plan": ("run.csv",),
        "effects": ("run.csv",),
        "polynomial fit": ("run.csv",),
        "elements": ("--loads", "run.csv"),
        "view": ("--data", "run.csv"),
    }.items():
        args = parse([*name.split(), *words, "--rename", "a=x_mm"], COMMANDS)
        assert args.rename == ["a=x_mm"], name


def test_what_no_map_can_be(refused: Refused) -> None:
    """By hand: the text of the error."""
    Path("run.csv").write_text(PLAIN)
    assert refused("predict", "run.csv", "--rename", "x_mm") == (
        "argument --rename: 'x_mm': allowed is COLUMN=NAME, such as \"F_left [N]=lam_l_N\""
    )
    assert refused("predict", "run.csv", "--columns", "none.toml").startswith("none.toml: cannot be read (No such file")
