"""``ecm-fast identify``: from measurements to a mechanism file, and what is said on the way."""

from functools import partial
from importlib.resources import files
from pathlib import Path

import pytest
from commands import Run

from ecm_fast import Mechanism, identify, read_measurements

DATASETS = files("ecm_fast.data.datasets") / "simulated"
TENDON = str(DATASETS / "simulated_slender_tendon.csv")
SHEAR = str(DATASETS / "simulated_slender_shear.csv")
PUSHES = str(DATASETS / "simulated_compression_28mm.csv")
SPECIMEN = str(DATASETS / "simulated_compression_28mm.toml")


@pytest.fixture
def run(run: Run) -> Run:
    """Return a function that runs ``identify``."""
    return partial(run, "identify")


def test_the_answer_holds_what_python_gives(run: Run) -> None:
    """Another way in: `identify` from Python."""
    Path("off.toml").write_text("preset = 'slender'\n[beam]\nEA = 7000.0\nGA = 2800.0\nEI = 2.7\n")
    words = (TENDON, SHEAR, "--fit", "EA", "GA", "EI", "--mechanism", "off.toml", "--out", "mine")
    ended, path = run(*words, "--json"), Path("mine/identified.toml")
    assert (ended.code, ended.err) == (0, f"ecm-fast: wrote {path}\n")
    answer, names = ended.json, ["EA", "GA", "EI"]
    data = [read_measurements(file) for file in (TENDON, SHEAR)]
    fit = identify(Mechanism.from_toml("off.toml"), data, names)
    assert list(answer["parameters"]) == names
    for name, truth in zip(names, (7500.0, 2420.0, 3.0), strict=True):
        found = answer["parameters"][name]
        assert found == {key: getattr(fit[name], key) for key in ("value", "std", "lower", "upper")}
        assert abs(found["value"] - truth) < 4.0 * found["std"]
    assert answer["rms"] == fit.rms
    assert list(answer["rms"]) == ["x_m", "z_m", "theta_rad"]
    assert (answer["warnings"], answer["rows"], answer["left_out"]) == ([], 324, [])
    assert answer["mechanism"] == str(path)
    assert Mechanism.from_toml(path) == fit.mechanism
    assert run("--fit", "EI", "--json", "--mechanism", path, "--", TENDON).code == 0
    text = run(*words).out.splitlines()
    assert text[0] == "324 rows; 90% intervals"
    assert [line.split()[0] for line in text[1:4]] == names
    assert text[4].startswith("rms of measured less predicted: x ")
    assert text[5] == "noise: x declared, z declared, theta declared"


def test_what_is_not_seen_is_null_and_said_on_stderr(run: Run) -> None:
    """Contract: null and a warning for GA, which pure compression cannot determine."""
    ended = run(PUSHES, "--fit", "EA", "GA", "--mechanism", SPECIMEN, "--channels", "x", "--json")
    assert ended.code == 0
    assert ended.json["parameters"]["GA"] == {"value": 2420.0, "std": None, "lower": None, "upper": None}
    assert ended.json["warnings"] == [line.removeprefix("ecm-fast: warning: ") for line in ended.err.splitlines()[:1]]
    assert ended.json["warnings"][0].startswith("GA cannot be seen in the data")
    assert ended.json["noise"] == {"x": "declared"}


def test_priors_and_losses_are_passed_on(run: Run) -> None:
    """Another way in: `identify` from Python."""
    ended = run(TENDON, "--fit", "EA", "EI", "--prior", "EA", "7900", "10", "--prior", "EI", "3", "1", "--json")
    prior = {"EA": (7900.0, 10.0), "EI": (3.0, 1.0)}
    data = read_measurements(TENDON)
    assert ended.json["parameters"]["EA"]["value"] == identify(
        Mechanism(), data, ["EA", "EI"], priors=prior
    )["EA"].value  # fmt: skip
    assert "drifts" in ended.err
    soft = run(TENDON, "--fit", "EI", "--loss", "soft_l1", "--force-sigma", "0", "--json").json
    fit = identify(Mechanism(), data, ["EI"], loss="soft_l1", force_sigma=0.0)
    assert soft["parameters"]["EI"]["value"] == fit["EI"].value


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ((TENDON,), "the following arguments are required: --fit; see ecm-fast identify --help"),
        ((TENDON, "--fit", "EJ"), "no parameter is called 'EJ'"),
        (("no.csv", "--fit", "EI"), "no.csv: cannot be read (No such file or directory)"),
        ((TENDON, "--fit", "EI", "--channels", "y"), "channel = 'y': allowed is 'x' or 'z' or 'theta'"),
        ((TENDON, "--fit", "EI", "--prior", "EI", "3", "none"), "argument --prior EI: 'none': allowed is a finite num"),
        (
            (TENDON, "--fit", "EI", "--prior", "EI", "3", "1", "--prior", "EI", "3", "2"),
            "argument --prior EI: given twice",
        ),
    ],
    ids=["nothing to fit", "parameter", "file", "channel", "prior", "prior twice"],
)
def test_bad_arguments(run: Run, words: tuple[str, ...], text: str) -> None:
    """Contract: exit code 2 and one line."""
    ended = run(*words)
    assert (ended.code, ended.out) == (2, "")
    assert ended.err.startswith(f"ecm-fast: {text}")
    assert ended.err.count("\n") == 1
