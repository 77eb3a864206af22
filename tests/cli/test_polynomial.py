"""``ecm-fast polynomial``: from poses to a file, from the file to wrenches."""

import json
from functools import partial
from pathlib import Path

import pytest
from commands import Run

from ecm_fast import PolynomialModel

# tendon_equilibria.csv, independent shooting solutions: law nh, L 0.109 m, routing point, no masses;
# lambda_l, lambda_r, x_L, z_L, theta_L, fx, fz, tau
TENDONS = [
    (80.0, 0.0, 0.107060521673, 0.0111749712073, -0.208006646653, -79.5677222116, -8.30527435183, -5.56974055481),
    (160.0, 80.0, 0.104715810049, 0.0116309891139, -0.221237072978, -238.533121425, -26.4943386991, -5.56577283326),
]


@pytest.fixture
def run(run: Run) -> Run:
    """Return a function that runs ``polynomial`` beside measured tendon rows."""
    rows = [",".join(map(str, row[:5])) for row in TENDONS]
    Path("run.csv").write_text("\n".join(["lam_l_N,lam_r_N,x_m,z_m,theta_rad", *rows, "1,2,,,"]))
    return partial(run, "polynomial")


@pytest.mark.slow
def test_fit_and_eval_meet_the_shooting_solutions(run: Run) -> None:
    """Shooting: rows of the table of tendon equilibria."""
    ended = run("fit", "--mechanism", "bare.toml", "--degree", 6, "--json")
    model = Path("out/polynomial.json")
    assert (ended.code, ended.err) == (0, f"ecm-fast: wrote {model}\n")
    answer = ended.json
    assert answer["model"] == str(model)
    assert (answer["degree"], answer["coefficients"], answer["rows"], answer["dropped"]) == (6, 252, 1000, 0)
    assert answer["conservative"] is False
    assert set(answer["rms"]) == {"fx_N", "fz_N", "tau_Nm"}
    assert set(answer["range"]) == {"x_m", "z_m", "theta_rad"}
    for *_, x, z, theta, fx, fz, tau in TENDONS:
        got = run("eval", model, "--pose", x, z, theta, "--json")
        assert (got.code, got.err) == (0, "")
        wrench = [got.json[name] for name in ("fx_N", "fz_N", "tau_Nm")]
        assert wrench == pytest.approx([fx, fz, tau], abs=0.1)  # of 350 N
        assert got.json["in_range"] is True
        assert got.json["stiffness"] == PolynomialModel.from_json(model).stiffness([x, z, theta]).tolist()


@pytest.mark.slow
def test_eval_of_a_file_compares_with_the_wrench_of_the_tendons(run: Run) -> None:
    """Shooting: wrenches of the table."""
    run("fit", "--mechanism", "bare.toml", "--degree", 6)
    ended = run("eval", "out/polynomial.json", "run.csv", "--mechanism", "bare.toml", "--json")
    assert ended.err == f"ecm-fast: wrote {Path('out/wrenches.csv')}\n"
    assert (ended.json["rows"], ended.json["outside"]) == (2, 0)
    assert max(ended.json["rms"].values()) < 0.1
    head, *lines = Path("out/wrenches.csv").read_text().splitlines()
    assert head == "x_m,z_m,theta_rad,fx_N,fz_N,tau_Nm,fx_measured_N,fz_measured_N,tau_measured_Nm"
    for line, row in zip(lines, TENDONS, strict=False):
        assert [float(cell) for cell in line.split(",")[6:]] == pytest.approx(row[5:], abs=1e-8)
    assert lines[2] == ",,,,,,,,"
    assert run("eval", "out/polynomial.json", "run.csv", "--json").json["rms"] is None
    text = run("eval", "out/polynomial.json", "run.csv", "--mechanism", "bare.toml", "--out", "there").out
    assert text.startswith(
        "2 of 3 rows have a whole pose, 0 of them outside the range\nrms of predicted less measured: "
    )
    assert Path("there/wrenches.csv").exists()


def test_fit_to_measurements_alone_and_mixed(run: Run) -> None:
    """Counting: rows needed, used and dropped."""
    refused = run("fit", "run.csv")
    assert refused == (2, "", "ecm-fast: 2 rows do not determine a polynomial of degree 3: at least 20 are needed\n")
    mixed = run("fit", "run.csv", "--poses", 100, "--seed", 3, "--json")
    assert (mixed.json["rows"], mixed.json["dropped"]) == (102, 1)
    assert mixed.err.startswith("ecm-fast: 1 of 103 poses cannot be used\n")
    assert run("fit", "run.csv", "--poses", 100, "--seed", 3, "--json").json == mixed.json
    assert run("fit", "run.csv", "--poses", 100, "--seed", 4, "--json").json != mixed.json


def test_conservative(run: Run) -> None:
    """Theory: the stiffness of an energy is symmetric, 34 coefficients."""
    ended = run("fit", "--conservative", "--out", "mine", "--poses", 200)
    assert ended.out.startswith("degree 3, 34 coefficients from 200 poses, condition number ")
    stiffness = run("eval", "mine/polynomial.json", "--pose", 0.1, 0, 0, "--json", "--out", "mine").json["stiffness"]
    assert stiffness[0][1] == pytest.approx(stiffness[1][0], rel=1e-9, abs=1e-6)
    assert stiffness[1][2] == pytest.approx(stiffness[2][1], rel=1e-9)
    assert json.loads(Path("mine/polynomial_eval.json").read_text())["stiffness"] == stiffness


def test_beyond_the_range_it_says_so(run: Run) -> None:
    """Contract: a warning on stderr, exit code 0."""
    run("fit", "--poses", 100, "--degree", 2)
    ended = run("eval", "out/polynomial.json", "--pose", 0.1, 0.0, -3)
    assert ended.code == 0
    assert ended.out.startswith("fx ")
    assert ended.err.startswith("ecm-fast: 1 of 1 rows leave the range: theta by up to 2.")
    assert ended.err.count("\n") == 1
    assert run("eval", "out/polynomial.json", "--pose", 0.1, 0.0, -3, "--json").json["in_range"] is False


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ((), "the following arguments are required: fit or eval; see ecm-fast polynomial --help"),
        (
            ("fot",),
            "no command 'polynomial fot' (did you mean 'polynomial fit'?); allowed are solve, predict, identify, "
            "polynomial fit, polynomial eval, elements, plan, diagnose, next, sweep, effects, hide, score, init, "
            "import, view, reproduce, bench, warmup",
        ),
        (("fit", "--degre", "3"), "unknown argument '--degre' (did you mean '--degree'?); see ecm-fast polynomial fit"),
        (("--json", "fit"), "unknown argument '--json': say it after polynomial fit; see ecm-fast polynomial fit"),
        (("fit", "--degree", "7"), "degree = 7: allowed is a whole number from 1 to 6"),
        (("fit", "--degree", "1.5"), "argument --degree: '1.5': allowed is a whole number"),
        (("fit", "--poses", "0"), "n = 0: allowed is a whole number >= 1"),
        (("fit", "no.csv"), "no.csv: cannot be read (No such file or directory)"),
        (("eval",), "the following arguments are required: MODEL; see ecm-fast polynomial eval --help"),
        (("eval", "no.json"), "allowed is either DATA or --pose X Z THETA; see ecm-fast polynomial eval --help"),
        (("eval", "no.json", "run.csv"), "no.json: cannot be read (No such file or directory)"),
        (("eval", "run.csv", "run.csv"), "run.csv: not a JSON file ("),
        (("eval", "no.json", "--pose", "1", "nan", "2"), "argument --pose: 'nan': allowed is a finite number"),
    ],
    ids=lambda entry: repr(" ".join(entry)) if isinstance(entry, tuple) else "",
)
def test_bad_arguments(run: Run, words: tuple[str, ...], text: str) -> None:
    """Contract: exit code 2 and one line."""
    ended = run(*words)
    assert (ended.code, ended.out) == (2, "")
    assert ended.err.startswith(f"ecm-fast: {text}")
    assert ended.err.count("\n") == 1
