"""The tool that measures error rates, with answers whose rates are known."""

import importlib.util
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from bench import results_page
from ecm_fast.testbed.sealed.ground_truth import Truth
from ecm_fast.testbed.sealed.hide import hide

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
WORDS = ("--count", "2", "--designs", "grid2", "--noises", "white", "force", "--materials", "unknown")


@pytest.fixture(scope="module")
def tool():
    spec = importlib.util.spec_from_file_location("error_rates", ROOT / "bench" / "error_rates.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["error_rates"] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules["error_rates"]


def oracle(path, priors):
    """Answer as one who has looked, but takes what is outside the catalogue for creep."""
    truth = Truth.from_json(path.with_suffix(".truth.json"))
    effects = [
        {
            "name": name,
            "parameters": {key: value for key, value in truth.effects.items() if key.partition(".")[0] == name},
            "look_alikes": [],
        }
        for name in truth.names or ("creep",) * bool(truth.outside)
    ]
    return {"verdict": "named" if effects else "nothing_found", "effects": effects}


def plainly(path, truth, answer, priors):
    """Tell that every hidden effect stands out, of every other pair one effect only where it is alone."""
    beside = 9.0 if int(path.stem[-1]) % 2 else 3.0
    return {
        "stands": {name: {"sigmas": 9.0, "apart": 9.0, "beside": beside} for name in (*truth.names, *truth.outside)}
    }


def test_known_answers_have_known_rates(tool, tmp_path, capsys):
    """Counted by hand, for answers made by hand."""
    words = ["--folder", str(tmp_path), "--groups", "clean", "pairs", "outside", *WORDS]
    assert tool.main([*words, "--generate-only"]) == 0
    count = 2 * 2 + 20 + 2 * 8
    assert capsys.readouterr().out == f"{count} of {count} sets\n"
    files = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.csv")}
    assert len(files) == count
    assert tool.main(words, diagnose=oracle, tell=plainly) == 0
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.csv")} == files  # none made again
    rates = json.loads((tmp_path / "rates.json").read_text())["unknown"]["rates"]["grid2"]
    assert rates["false alarm on clean data"] == "0.0% (0 of 4)"
    assert rates["two effects, each 6 sigma or more when alone: both named"] == "100.0% (20 of 20)"
    (tmp_path / "rates.json").unlink()
    assert tool.main([*words, "--grade-only"]) == 0  # with no one to ask
    assert json.loads((tmp_path / "rates.json").read_text())["unknown"]["rates"]["grid2"] == rates
    row = "two effects, each 6 sigma or more alone and beside the other: both named"
    assert rates[row] == "100.0% (10 of 10)"
    assert rates["outside the catalogue, 8 sigma or more from every entry: said so"] == "0.0% (0 of 16)"
    assert rates["outside the catalogue, 8 sigma or more from every entry: one name alone"] == "100.0% (16 of 16)"
    assert rates["a second name on one effect"] == "-"
    assert "| false alarm on clean data | 0.0% (0 of 4) |" in capsys.readouterr().out


def test_the_chance_of_an_answer_is_its_share_of_the_evidence(tool):
    """Two explanations as good as each other halve it; one that is refused, or of two effects, takes nothing."""
    kinds = [(["creep"], ""), (["ogden"], ""), (["ogden"], "10 times its size"), (["creep", "ogden"], "")]
    models = [{"names": names, "behind": 0.0, "refused": refused} for names, refused in kinds]
    assert tool.chance({"effects": [{}], "models": models}) == pytest.approx(0.5)
    behind = [models[0], models[1] | {"behind": 2.0 * np.log(3.0)}]
    assert tool.chance({"effects": [{}], "models": behind}) == pytest.approx(0.75)
    assert tool.chance({"effects": []}) is None


def test_answers_are_kept_until_they_are_forgotten(tool, tmp_path, capsys):
    """Counted by hand, for answers made by hand."""
    words = ["--folder", str(tmp_path), "--groups", "clean", *WORDS]
    alarm = {"verdict": "named", "effects": [{"name": "creep", "parameters": {"creep": 0.1}}]}
    for diagnose, more, line in (
        (lambda path, priors: alarm, (), "100.0% (4 of 4)"),
        (oracle, (), "100.0% (4 of 4)"),
        (oracle, ("--forget",), "0.0% (0 of 4)"),
    ):
        assert tool.main([*words, *more], diagnose=diagnose, tell=plainly) == 0
        assert f"| false alarm on clean data | {line} |" in capsys.readouterr().out


def test_every_effect_is_a_cell_and_every_set_has_its_own_seed(tool, tmp_path):
    """Counted by hand: 67 effects, 37 laws of other forms, 8 outside, noises and designs."""
    cells = list(tool.cells(tool.GROUPS, ("T", "T+S"), ("white", "force"), 3))
    assert len(cells) == 2 * (2 + 67 + 37 + 1 + 8)
    seeds = [tool.Sealed(cell, number, tmp_path).seed for cell in cells for number in range(cell.count)]
    assert len(set(seeds)) == len(seeds)


@pytest.mark.parametrize("noise", ["strong_force", "undeclared+strong_force"])
def test_sigmas_are_those_of_the_noise_declared_or_not(tool, noise):
    """By hand: the noise of camera and force cells."""
    made, truth = hide(effects={"beam_length": 1e-3}, design="T", seed=5, noise=noise)
    still = tool.still(truth, truth.effects)
    assert still.n == made.n
    for name, sigma in (("sigma_x", 1e-4), ("sigma_z", 1e-4), ("sigma_theta", 1e-3), ("sigma_lam", 0.4)):
        assert np.all(getattr(still, name) == sigma)


def test_the_page_of_results_is_written_whole(tmp_path):
    """Truth: the stored tables; the page in the repository is what the script makes of them."""
    stored = json.loads((ROOT / "bench" / "results.json").read_text(encoding="utf-8"))
    assert results_page.page(stored) == (ROOT / "bench" / "RESULTS.md").read_text(encoding="utf-8")
    results_page.write(stored, tmp_path)
    results_page.put("times", ["a new table"], tmp_path)
    text = (tmp_path / "RESULTS.md").read_text(encoding="utf-8")
    assert "a new table" in text
    assert "\n".join(stored["error_rates"]).strip() in text
