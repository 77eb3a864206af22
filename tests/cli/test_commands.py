"""The command line: what it says on stdout and stderr, its exit codes, and numbers from outside."""

import json
import os
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import Refused, Run

from ecm_fast import Measurements, cli, predict
from ecm_fast.errors import NotConverged
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.mechanism.mechanism import Mechanism

# tendon_equilibria.csv, independent shooting solutions: law nh, L 0.109 m, routing point, no masses;
# lambda_l, lambda_r, x_L, z_L, theta_L
TENDONS = [
    (80.0, 0.0, 0.107060521673, 0.0111749712073, -0.208006646653),
    (0.0, 80.0, 0.107060521673, -0.0111749712073, 0.208006646653),
    (160.0, 0.0, 0.103487116471, 0.02212955381, -0.421331871714),
    (160.0, 80.0, 0.104715810049, 0.0116309891139, -0.221237072978),
    (40.0, 120.0, 0.105880786795, -0.0113856281219, 0.214241799938),
]
# the same file: law hooke, L 0.04 m
PAPER_HOOKE = (160.0, 80.0, 0.0386816227188, 0.0014604306694, -0.0754744623006)


def process(*words: str, cwd: Path, env: dict[str, str] | None = None, **options: Any) -> subprocess.Popen[str]:
    """Start ``ecm-fast`` as a shell would."""
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
    return subprocess.Popen(
        [sys.executable, "-m", "ecm_fast", *words], cwd=cwd, env={**os.environ, **(env or {})}, text=True, **options
    )


# solve


def test_what_a_file_does_not_say_is_listed_once(run: Run) -> None:
    """A file with a beam alone: one line on stderr, none of it on stdout, and none once the preset is named."""
    Path("rod.toml").write_text("[beam]\nlength = 0.5\n")
    ended = run("solve", "--tendons", "0", "0", "--mechanism", "rod.toml", "--json")
    assert ended.json["converged"]
    assert ended.err.count("\n") == 1
    assert ended.err.startswith("ecm-fast: rod.toml: not given, so as in the preset 'slender': beam.EA = 7500.0, ")
    assert "beam.mass_per_length = 9.47, " in ended.err
    assert "head.mass = 1.0, " in ended.err
    Path("rod.toml").write_text("preset = 'slender'\n[beam]\nlength = 0.5\n")
    assert run("solve", "--tendons", "0", "0", "--mechanism", "rod.toml", "--json").err == ""


@pytest.mark.parametrize(("left", "right", "x", "z", "theta"), TENDONS)
def test_solve_meets_the_shooting_solutions(
    run: Run, left: float, right: float, x: float, z: float, theta: float
) -> None:
    """Shooting: three rows of the table of tendon equilibria."""
    answer = run("solve", "--tendons", left, right, "--mechanism", "bare.toml", "--json").json
    assert [answer["x"], answer["z"], answer["theta"]] == pytest.approx([x, z, theta], abs=1e-8)
    assert (answer["converged"], answer["stable"], answer["status"]) == (True, True, "converged")
    assert answer["load_factor"] == 1.0
    assert answer["iterations"] > 0


def test_solve_takes_the_mechanism_and_the_discretization(run: Run) -> None:
    """Shooting: a row of the table; the coarser mesh is farther off."""
    bare = Path("bare.toml").read_text()
    paper = bare.replace("slender", "paper").replace("[beam]", '[beam]\naxial_law = "hooke"')
    Path("paper.toml").write_text(paper)
    left, right, x, z, theta = PAPER_HOOKE
    words = ("solve", "--tendons", left, right, "--mechanism", "paper.toml", "--json")
    fine, coarse = (
        run(*words, "--elements", "3", "--order", "5").json,
        run(*words, "--elements", "2", "--order", "1").json,
    )
    assert [fine["x"], fine["z"], fine["theta"]] == pytest.approx([x, z, theta], abs=1e-9)
    assert coarse["theta"] != pytest.approx(theta, rel=1e-5)
    assert coarse["theta"] == pytest.approx(theta, rel=1e-2)


def test_solve_gives_the_derivatives_of_a_cantilever_at_rest(run: Run) -> None:
    """Closed form: compliance of the linear Timoshenko beam."""
    answer = run("solve", "--tendons", "0", "0", "--mechanism", "bare.toml", "--json").json
    L, EA, GA, EI, d = 0.109, 7500.0, 2420.0, 3.0, 0.070
    # closed form for a small tip force: z = f L^3/(3 EI) + f L/GA, theta = -f L^2/(2 EI)
    zz, zt, tt = L**3 / (3 * EI) + L / GA, -(L**2) / (2 * EI), L / EI
    for row, expected in zip(answer["compliance"], [[L / EA, 0, 0], [0, zz, zt], [0, zt, tt]], strict=True):
        assert row == pytest.approx(expected, rel=1e-9, abs=1e-15)
    # the left tendon pulls by (-1, 0) at P = Q + d e_z: a force along -x and the moment -d about e_y
    for row, expected in zip(answer["jacobian"], [[-L / EA] * 2, [-d * zt, d * zt], [-d * tt, d * tt]], strict=True):
        assert row == pytest.approx(expected, rel=1e-9, abs=1e-15)


def test_solve_speaks_to_a_reader(run: Run) -> None:
    """By hand: the lines of the answer."""
    ended = run("solve", "--tendons", "80", "0", "--mechanism", "bare.toml")
    lines = ended.out.splitlines()
    assert (ended.code, ended.err) == (0, "")
    for line, (start, end) in zip(
        lines,
        [("x     = 0.107060", " m"), ("z     = 0.011174", " m"), ("theta = -0.208006", " rad (-11.9179 deg)")],
        strict=False,
    ):
        assert line.startswith(start)
        assert line.endswith(end)
    assert lines[3].startswith("stable equilibrium, on the branch that grows from the unloaded state (")
    assert len(lines) == 8


def test_solve_takes_negative_numbers_in_every_spelling(run: Run) -> None:
    """Contract: one answer for every spelling of the same number."""
    plain = run("solve", "--tendons", "40", "10", "--wrench", "-50", "-0.5", "-2", "--json").json
    for spelling in (("-5e1", "-.5", "-2."), ("-5E+1", "-5e-1", "-0.2e1")):
        assert run("solve", "--wrench", *spelling, "--json", "--tendons", "4e1", "+10").json == plain
    assert plain["x"] < run("solve", "--tendons", "40", "10", "--json").json["x"]


def test_an_unstable_equilibrium_is_no_failure(run: Run) -> None:
    """Closed form: the neck buckles at 539.05 N; exit code 0, a line on stderr."""
    ended = run("solve", "--tendons", "0", "0", "--wrench", "-600", "0", "0", "--mechanism", "bare.toml", "--json")
    assert ended.code == 0
    assert (ended.json["converged"], ended.json["stable"], ended.json["status"]) == (True, False, "unstable")
    # closed form: the neo-Hookean neck of 0.109 m buckles at 539.05 N
    assert ended.json["load_factor"] * 600.0 == pytest.approx(539.05, abs=0.005)
    assert ended.err == f"ecm-fast: {ended.json['message']}\n"
    assert ended.json["message"].startswith("equilibrium, but not stable: the load passes the buckling load at 0.898")


def test_a_solve_that_fails(run: Run) -> None:
    """Contract: exit code 3 and null for every number."""
    ended = run("solve", "--tendons", "5000", "0", "--json")
    assert ended.code == 3
    assert (ended.json["x"], ended.json["z"], ended.json["theta"]) == (None, None, None)
    assert ended.json["compliance"] == [[None] * 3] * 3
    assert ended.json["jacobian"] == [[None] * 2] * 3
    assert (ended.json["converged"], ended.json["stable"], ended.json["status"]) == (False, False, "tendon_zero_length")
    assert 0.0 < ended.json["load_factor"] < 1.0
    assert ended.err == f"ecm-fast: {ended.json['message']}\n"
    quiet = run("solve", "--tendons", "5000", "0")
    assert quiet == (3, "", ended.err)


def test_solve_writes_its_answer_where_it_is_told(run: Run) -> None:
    """Contract: the file holds what stdout shows."""
    ended = run("solve", "--tendons", "40", "10", "--json", "--out", "a/b")
    assert ended.err == f"ecm-fast: wrote {Path('a/b/solve.json')}\n"
    assert json.loads(Path("a/b/solve.json").read_text()) == ended.json


# predict


def test_predict_meets_the_shooting_solutions(run: Run) -> None:
    """Shooting: rows of the table as measured poses."""
    rows = [f"{left},{right},{1e3 * x:.12g},{1e3 * z:.12g},{theta}" for left, right, x, z, theta in TENDONS]
    Path("run.csv").write_text("\n".join(["lam_l_N,lam_r_N,x_mm,z_mm,theta_rad", *rows]))
    ended = run("predict", "run.csv", "--mechanism", "bare.toml", "--json")
    assert ended.code == 0
    assert ended.err == f"ecm-fast: wrote {Path('out/predicted.csv')}\n"
    assert ended.json["rows"] == 5
    assert ended.json["csv"] == str(Path("out/predicted.csv"))
    assert set(ended.json["rms"]) == {"x_m", "z_m", "theta_rad"}
    assert max(ended.json["rms"].values()) < 1e-8
    assert ended.json["status"]["converged"] == 5
    assert sum(ended.json["status"].values()) == 5
    lines = Path("out/predicted.csv").read_text().splitlines()
    columns = lines[0].split(",")
    for line, (_, _, x, z, theta) in zip(lines[1:], TENDONS, strict=True):
        cells = dict(zip(columns, line.split(","), strict=True))
        assert [float(cells[name]) for name in ("x_m", "z_m", "theta_rad")] == pytest.approx([x, z, theta], abs=1e-8)


def test_predict_reports_the_misfit_in_units_of_noise(run: Run) -> None:
    """Nine readings off by one sigma of 0.1 mm up and down, the tenth by 20: rms sqrt((9 + 400)/10)."""
    loads = Measurements.from_columns({"lam_l_N": np.linspace(0.0, 90.0, 10)})
    pose = predict(Mechanism(), loads).pose
    off = 1e-4 * np.r_[np.tile([1.0, -1.0], 5)[:9], 20.0]
    Measurements.from_columns(
        {"lam_l_N": loads.lam_l, "x_m": pose[:, 0], "z_m": pose[:, 1] + off, "sigma_z_mm": [0.1] * 10}
    ).to_csv("run.csv")
    lines = run("predict", "run.csv").out.splitlines()
    assert lines[2:] == [
        "in units of the camera's noise as declared: z 6.4",
        "far off: run.csv: line 11, 20 times its noise",
        "next: ecm-fast diagnose with the same file says what the model is missing",
    ]
    answer = run("predict", "run.csv", "--json").json["rms_sigma"]
    assert answer["z"] == pytest.approx(np.sqrt(40.9), rel=1e-6)
    assert (answer["x"], answer["theta"]) == (None, None)


def test_predict_without_measured_poses(run: Run) -> None:
    """By hand: the text."""
    Path("run.csv").write_text("lam_l_N,lam_r_N\n40,10\n0,0\n")
    ended = run("predict", "run.csv", "--out", "there")
    assert (
        ended.out
        == "2 rows: 2 converged\nrms of measured less predicted: x not measured, z not measured, theta not measured\n"
        "next: measure poses under these loads and predict them again\n"
    )
    assert ended.err == f"ecm-fast: wrote {Path('there/predicted.csv')}\n"
    assert run("predict", "run.csv", "--json").json["rms"] == {"x_m": None, "z_m": None, "theta_rad": None}


def test_predict_with_a_row_that_fails_writes_the_others(run: Run) -> None:
    """Contract: exit code 3, the failed row named, the others written."""
    Path("run.csv").write_text("lam_l_N,lam_r_N,theta_deg\n40,10,-5\n5000,0,1\n0,0,0\n")
    ended = run("predict", "run.csv", "--json", "--order", "5")
    assert ended.code == 3
    assert ended.json["status"]["tendon_zero_length"] == 1
    assert ended.err.startswith("ecm-fast: 1 of 3 rows did not converge; run.csv: line 3: no equilibrium: at 0.10")
    assert ended.err.endswith(f"ecm-fast: wrote {Path('out/predicted.csv')}\n")
    assert len(Path("out/predicted.csv").read_text().splitlines()) == 4


def test_predict_with_bad_data(refused: Refused) -> None:
    """Contract: one line that names file, line and column."""
    assert refused("predict", "no.csv").startswith("no.csv: ")
    Path("run.csv").write_text("lam_l_N,lam_r_N\n-1,10\n")
    assert refused("predict", "run.csv").startswith("run.csv: line 2, column lam_l_N: ")
    Path("neck.toml").write_text("[beam]\nEA = -1\n")
    assert refused("predict", "run.csv", "--mechanism", "neck.toml").startswith("neck.toml: beam.EA = -1: allowed is ")
    assert not Path("out").exists()


# effects


@pytest.mark.slow
def test_effects_lists_the_catalogue(run: Run) -> None:
    """By hand: the first entry; and the catalogue's own order."""
    effects = run("effects", "--json").json["effects"]
    assert [entry["name"] for entry in effects] == list(CATALOGUE)
    assert effects[0] == {
        "name": "precurvature",
        "meaning": "curvature of the beam as it was cast",
        "law": "u = kappa - a",
        "unit": "1/m",
        "typical": 0.2,
        "tolerance": 0.0,
        "lower": -100.0,
        "upper": 100.0,
        "group": "moment bias",
        "mirror": "odd",
        "enters": "section",
        "needs": [],
        "parameters": [
            {
                "name": "precurvature",
                "unit": "1/m",
                "meaning": "curvature of the beam as it was cast",
                "default": 0.0,
                "typical": 0.2,
                "lower": -100.0,
                "upper": 100.0,
            }
        ],
    }
    text = run("effects").out
    assert text.isascii()
    for entry in effects:
        assert f"{entry['name']}: {entry['meaning']}\n    {entry['law']}\n" in text
    assert run("effects", "--json", "--out", "here").json == json.loads(Path("here/effects.json").read_text())


# init


@pytest.mark.parametrize("preset", ["slender", "paper"])
def test_init_writes_a_file_that_every_command_takes(run: Run, preset: str) -> None:
    """Round trip: the preset, and its length by hand."""
    ended = run("init", "--preset", preset, "neck.toml", "--json")
    assert ended.json == {"mechanism": "neck.toml", "preset": preset}
    assert ended.err == "ecm-fast: wrote neck.toml\n"
    assert Mechanism.from_toml("neck.toml") == Mechanism.preset(preset)
    assert tomllib.loads(Path("neck.toml").read_text())["beam"]["length"] == {"slender": 0.109, "paper": 0.040}[preset]
    with_file = run("solve", "--tendons", "40", "10", "--mechanism", "neck.toml", "--json").json
    default = run("solve", "--tendons", "40", "10", "--json").json
    assert (with_file == default) == (preset == "slender")


@pytest.mark.parametrize("robot", ["finger", "segments", "tentacle"])
def test_init_writes_robots(run: Run, refused: Refused, robot: str) -> None:
    """Round trip: each shipped robot, complete, solves under its first tendon and is written again as it was read."""
    assert run("init", "--robot", robot, "robot.toml", "--json").json == {"mechanism": "robot.toml", "robot": robot}
    built = Mechanism.from_toml("robot.toml")
    assert built == Mechanism.robot(robot)
    assert built.assumed == ()
    built.to_toml("again.toml")
    assert Mechanism.from_toml("again.toml") == built
    pulled, free = (run("solve", "--mechanism", "robot.toml", "--tendon", f"{built.tendon_names[0]}={force}", "--json")
                    for force in (0.5, 0.0))  # fmt: skip
    assert pulled.json["stable"]
    assert pulled.json["theta"] < free.json["theta"]  # a tendon at z > 0 turns the end there
    assert refused("init", "--robot", "tentacel", "other.toml").startswith("robot = 'tentacel': allowed is 'finger' or")


def test_init_does_not_overwrite(run: Run, refused: Refused) -> None:
    """Contract: an existing file is kept unless forced."""
    assert run("init") == (0, "", "ecm-fast: wrote mechanism.toml\n")
    Path("mechanism.toml").write_text("mine")
    assert refused("init") == "mechanism.toml: exists; --force overwrites it"
    assert Path("mechanism.toml").read_text() == "mine"
    assert run("init", "--force").code == 0
    assert Mechanism.from_toml("mechanism.toml") == Mechanism()
    Path("folder").mkdir()
    assert refused("init", "folder") == "folder: exists; --force overwrites it"
    assert refused("init", "folder", "--force") == "folder: cannot be written here (Is a directory)"
    Path("dangling").symlink_to("nowhere")
    assert refused("init", "dangling") == "dangling: exists; --force overwrites it"


def test_init_in_a_folder(run: Run) -> None:
    """Contract: the place of the file."""
    assert run("init", "--out", "new/place").err == f"ecm-fast: wrote {Path('new/place/mechanism.toml')}\n"
    assert Mechanism.from_toml("new/place/mechanism.toml") == Mechanism()


# reproduce


def test_reproduce_gives_one_object_on_stdout(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Contract: one JSON object on stdout, progress on stderr."""
    pytest.importorskip("matplotlib")
    pytest.importorskip("jinja2")
    from ecm_fast.studies import paper as reproduce

    quick = {name: reproduce._PARTS[name] for name in ("steel_cantilever",)}
    monkeypatch.setattr(reproduce, "_PARTS", quick)
    ended = run("reproduce", "--json")
    assert ended.code == 0
    assert {"what", "theirs", "ours", "verdict"} <= set(ended.json["claims"][0])
    assert Path(ended.json["report"]).exists()
    assert ended.err.splitlines()[0] == f"ecm-fast: {quick['steel_cantilever'][0]}"
    assert ended.err.splitlines()[-1] == "ecm-fast: wrote out"
    text = run("reproduce", "--out", "informative_loads").out
    assert ended.json["claims"][0]["what"] in text
    assert ended.json["claims"][0]["verdict"] in text


# Bad arguments: one line that names what, where and what is allowed

TENSION = "allowed is a finite number >= 0 [N], a tendon only pulls; see ecm-fast solve --help"
FINITE = "allowed is a finite number; see ecm-fast solve --help"
WHOLE = "allowed is a whole number; see ecm-fast solve --help"
COMMANDS = (
    "solve, predict, identify, polynomial fit, polynomial eval, elements, plan, diagnose, next, sweep, "
    "effects, hide, score, init, import, view, reproduce, "
    "bench, warmup"
)
SOLVE = ("solve", "--tendons", "1", "2")


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ((), "the following arguments are required: COMMAND; see ecm-fast --help"),
        (("slove",), f"no command 'slove' (did you mean 'solve'?); allowed are {COMMANDS}"),
        (("42",), f"no command '42'; allowed are {COMMANDS}"),
        (("solve",), "--tendons L R is missing: the forces of the left and the right tendon [N]"),
        (("predict",), "the following arguments are required: DATA; see ecm-fast predict --help"),
        (("solve", "--tendons", "1"), "argument --tendons: expected 2 arguments, L R; see ecm-fast solve --help"),
        (("solve", "--tendons", "nan", "3"), f"argument --tendons: 'nan': {TENSION}"),
        (("solve", "--tendons", "3", "inf"), f"argument --tendons: 'inf': {TENSION}"),
        (("solve", "--tendons", "-1", "3"), f"argument --tendons: '-1': {TENSION}"),
        (("solve", "--tendons", "-inf", "3"), f"argument --tendons: '-inf': {TENSION}"),
        (("solve", "--tendons", "3", "1e400"), f"argument --tendons: '1e400': {TENSION}"),
        (("solve", "--tendons", "3", "1_0"), f"argument --tendons: '1_0': {TENSION}"),
        (("solve", "--tendons", "3", "4N"), f"argument --tendons: '4N': {TENSION}"),
        (("solve", "--tendons", "3", "3,5"), f"argument --tendons: '3,5': {TENSION}"),
        (("solve", "--tendons", "3", ""), f"argument --tendons: '': {TENSION}"),
        ((*SOLVE, "--wrench", "1", "-nan", "3"), f"argument --wrench: '-nan': {FINITE}"),
        ((*SOLVE, "--wrench", "1", "a\nb", "3"), f"argument --wrench: 'a\\nb': {FINITE}"),
        (
            ("diagnose", "run.csv", "--prior", "GA", "2420"),
            "argument --prior: expected 3 arguments, NAME VALUE STD, such as --prior GA 2420 17; "
            "see ecm-fast diagnose --help",
        ),
        (
            (*SOLVE, "--wrench", "1", "2"),
            "argument --wrench: expected 3 arguments, FX FZ TAU; see ecm-fast solve --help",
        ),
        ((*SOLVE, "3"), "unknown argument '3'; see ecm-fast solve --help"),
        ((*SOLVE, ""), "unknown argument ''; see ecm-fast solve --help"),
        ((*SOLVE, "-3"), "unknown argument '-3'; see ecm-fast solve --help"),
        ((*SOLVE, "--jsn"), "unknown argument '--jsn' (did you mean '--json'?); see ecm-fast solve --help"),
        (("--json", *SOLVE), "unknown argument '--json': say it after solve; see ecm-fast solve --help"),
        ((*SOLVE, "--mech", "f"), "unknown argument '--mech' (did you mean '--mechanism'?); see ecm-fast solve --help"),
        ((*SOLVE, "--elements", "1.5"), f"argument --elements: '1.5': {WHOLE}"),
        ((*SOLVE, "--elements", "-2"), f"argument --elements: '-2': {WHOLE}"),
        ((*SOLVE, "--elements", "0"), "elements = 0: allowed is 1 to 100000"),
        ((*SOLVE, "--order", "7"), "order = 7: allowed is a whole number from 1 to 6"),
        ((*SOLVE, "--mechanism", "no.toml"), "no.toml: cannot be read (No such file or directory)"),
        ((*SOLVE, "--out", "bare.toml"), "--out bare.toml: cannot be made (File exists)"),
        ((*SOLVE, "--out", "bare.toml/a"), "--out bare.toml/a: cannot be made (Not a directory)"),
        ((*SOLVE, "--out", "a\0b"), "--out a\0b: cannot be made (embedded null byte)"),
        (("init", "--preset", "papr"), "preset = 'papr': allowed is 'slender' or 'paper' (did you mean 'paper'?)"),
        (("init", "no/such/folder"), f"{Path('no/such/folder')}: cannot be written here (No such file or directory)"),
        (("predict", "a\nb.csv"), "a b.csv: cannot be read (No such file or directory)"),
    ],
    ids=lambda entry: repr(" ".join(entry)) if isinstance(entry, tuple) else "",
)
def test_bad_arguments(refused: Refused, words: tuple[str, ...], text: str) -> None:
    """Contract: the text of the error, written by hand."""
    assert refused(*words) == text


# Help and version


@pytest.mark.parametrize(
    "command", [(), *(tuple(name.split()) for name in cli.COMMANDS)], ids=lambda words: " ".join(words) or "top"
)
def test_every_command_has_help(run: Run, command: tuple[str, ...]) -> None:
    """Contract: usage, options and exit codes of every command."""
    ended = run(*command, "--help")
    assert (ended.code, ended.err) == (0, "")
    assert ended.out.startswith(f"usage: {' '.join(['ecm-fast', *command])} ")
    assert "exit codes: 0 done, 1 unexpected, 2 bad input" in " ".join(ended.out.split())
    assert all(option in ended.out for option in (("--json", "--out DIR") if command else cli.COMMANDS))


def test_the_version_is_that_of_the_project(run: Run) -> None:
    """pyproject.toml."""
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert run("--version") == (0, f"ecm-fast {project['version']}\n", "")
    assert project["scripts"] == {"ecm-fast": "ecm_fast.__main__:main"}


def test_help_version_and_bad_arguments_load_no_library(tmp_path: Path) -> None:
    """Python's own list of loaded modules."""
    lines = [
        ["--help"],
        ["--version"],
        [],
        ["slove"],
        ["solve", "--help"],
        ["solve", "--tendons", "nan", "3"],
        ["solve", "--tendons", "1", "2", "--jsn"],
        ["predict"],
        ["init", "--preset", "papr"],
        ["elements", "--tolerance", "much"],
        ["effects"],
    ]
    code = (
        "import contextlib, io, sys\n"
        "from ecm_fast.__main__ import main\n"
        f"for words in {lines!r}:\n"
        "    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):\n"
        "        code = main(words)\n"
        "    print(code, sorted({'numba', 'numpy', 'scipy', 'matplotlib', 'jinja2'} & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, timeout=60)
    assert done.stdout.splitlines() == [f"{code} []" for code in (0, 0, 2, 2, 0, 2, 2, 2, 2, 2, 0)]


# What is not the user's fault


def replaced(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    """Let the command ``effects`` end with `error`."""

    def fail(args: Any) -> Any:
        raise error

    command = cli.COMMANDS["effects"]
    monkeypatch.setitem(cli.COMMANDS, "effects", type(command)(command.summary, command.add_arguments, fail))


def test_the_unexpected_is_one_line_and_a_traceback_on_demand(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Contract: the text of the error."""
    monkeypatch.delenv("ECM_FAST_TRACEBACK", raising=False)
    replaced(monkeypatch, KeyError("a\nb"))
    line = "ecm-fast: unexpected KeyError: 'a\\nb' (ECM_FAST_TRACEBACK=1 in the environment shows where)\n"
    assert run("effects", "--json") == (1, "", line)
    monkeypatch.setenv("ECM_FAST_TRACEBACK", "1")
    err = run("effects").err
    assert err.startswith("Traceback (most recent call last):\n")
    assert err.endswith(line)


def test_an_interrupt_and_a_solve_that_does_not_converge(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Contract: exit codes 130 and 3."""
    replaced(monkeypatch, KeyboardInterrupt())
    assert run("effects") == (130, "", "ecm-fast: interrupted\n")
    replaced(monkeypatch, NotConverged("no equilibrium"))
    assert run("effects") == (3, "", "ecm-fast: no equilibrium\n")


# As a process


@pytest.mark.slow
def test_a_process_ends_with_its_code_and_json_on_stdout(tmp_path: Path) -> None:
    """Contract: exit codes of real processes."""
    for words, code in {
        ("effects", "--json"): 0,
        ("solve", "--tendons", "5000", "0", "--json"): 3,
        ("solve", "--tendons", "5000"): 2,
    }.items():
        running = process(*words, cwd=tmp_path)
        out, err = running.communicate(timeout=120)
        assert running.returncode == code
        assert out == "" if code == 2 else isinstance(json.loads(out), dict)
        assert all(line.startswith("ecm-fast: ") for line in err.splitlines())


@pytest.mark.skipif(os.name == "nt", reason="pipes of POSIX")
@pytest.mark.parametrize("words", [("effects",), ("effects", "--json"), ("--help",), ("solve", "--help")], ids=" ".join)
def test_a_reader_that_goes_away_is_no_error(tmp_path: Path, words: tuple[str, ...]) -> None:
    """Contract: a closed pipe ends the command in silence."""
    with process(*words, cwd=tmp_path) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        running.stdout.close()  # long before the interpreter has started
        assert running.stderr.read() == ""
        assert running.wait(timeout=60) == 0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_a_full_disk_under_stdout_is_an_error(tmp_path: Path) -> None:
    """The operating system's /dev/full."""
    with open("/dev/full", "w") as full:
        running = process("effects", cwd=tmp_path, stdout=full)
        _, err = running.communicate(timeout=60)
    assert (running.returncode, err) == (2, "ecm-fast: stdout: cannot be written (No space left on device)\n")


@pytest.mark.skipif(os.name == "nt", reason="shells of POSIX")
def test_closed_streams_are_no_error(tmp_path: Path) -> None:
    """Contract: exit code 0 with closed streams."""
    for closed in (">&-", "2>&-", ">&- 2>&-"):
        done = subprocess.run(
            ["sh", "-c", f'"{sys.executable}" -m ecm_fast effects {closed}'], cwd=tmp_path, timeout=60
        )
        assert done.returncode == 0


def test_a_terminal_that_knows_ascii_alone(tmp_path: Path) -> None:
    """Contract: other characters are escaped."""
    running = process("init", "h\u00e4ls.toml", cwd=tmp_path, env={"PYTHONIOENCODING": "ascii:strict"})
    out, err = running.communicate(timeout=60)
    assert (running.returncode, out) == (0, "")
    assert err == "ecm-fast: wrote h\\xe4ls.toml\n"
    assert (tmp_path / "h\u00e4ls.toml").exists()


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c(tmp_path: Path) -> None:
    """A sweep of a million million cases does not end by itself."""
    text = "[sweep]\ncases = 1_000_000_000_000\nkeep = 'statistics'\n[inputs]\nlam_l = [0, 9]\n"
    (tmp_path / "spec.toml").write_text(text)
    running = process("sweep", "spec.toml", "--out", "out", cwd=tmp_path)
    while not (tmp_path / "out" / "sweep.json").exists() and running.poll() is None:
        time.sleep(0.01)
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=60)
    assert (running.returncode, out, err) == (130, "", "ecm-fast: interrupted\n")
