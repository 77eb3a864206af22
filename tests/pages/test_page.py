"""The page of a diagnosis and the commands around it, on data with a hidden taper whose look-alikes are known."""

import csv
import json
import re
from html import unescape

import numpy as np
import pytest

pytest.importorskip("matplotlib")
pytest.importorskip("jinja2")

from ecm_fast.cli import main
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.mechanism.mechanism import Mechanism
from ecm_fast.testbed import Sensors, measure, tendon_test

pytestmark = pytest.mark.slow

PICTURES = {"gap", "workspace", "residual_maps", "parity", "loops", "wrenches", "evidence", "cosines", "parameters",
            "left_over", "stiffness"}  # fmt: skip


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """Return the folder of a diagnosis by the command line, which also prints its JSON."""
    folder = tmp_path_factory.mktemp("diagnosis")
    hidden = Mechanism().replace(stiffness_taper=0.08)
    loads = tendon_test(grid=6, replicated=12, replicates=3, seed=3)
    measure(hidden, loads, Sensors(force_sigma=0.1), 1).to_csv(folder / "run.csv")
    assert main(["diagnose", str(folder / "run.csv"), "--out", str(folder / "out")]) == 0
    return folder / "out"


def table(path):
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_the_page_asks_nobody_and_holds_every_picture(done) -> None:
    """Contract: no request, no script, every figure with its numbers."""
    text = (done / "diagnosis.html").read_text(encoding="utf-8")
    linked = set(re.findall(r'href="(\w+)\.csv"', text))
    assert linked >= PICTURES
    assert text.count("<svg ") == len(linked)
    assert "<script" not in text
    assert "://" not in text
    ids = re.findall(r' id="([^"]+)"', text)
    assert len(ids) == len(set(ids))


def test_the_first_page_says_verdict_gap_set_and_next(done) -> None:
    """Contract: what the JSON says stands before the first heading."""
    text = (done / "diagnosis.html").read_text(encoding="utf-8")
    result = json.loads((done / "diagnose.json").read_text(encoding="utf-8"))
    first = text[: text.index("<h2>")]
    assert result["sentence"] in first
    assert "stiffness_taper" in first
    assert "Not distinguishable from" in first
    name = result["effects"][0]["name"]
    assert f"{name}: {CATALOGUE[name].size.meaning}; even (same on both sides)" in unescape(first)
    assert "Next best: " in first
    assert "Measure next" in first
    assert "rows set aside, calibrated alone" in first


def test_numbers_beside_the_pictures_are_those_of_the_rows(done) -> None:
    """The measured file itself."""
    rows = table(done / "residual_maps.csv")
    source = {row["row"]: row for row in rows}
    measured = table(done.parent / "run.csv")
    assert set(source) <= {str(number) for number in range(2, len(measured) + 2)}
    for number, row in source.items():
        assert float(row["lam_l_N"]) == float(measured[int(number) - 2]["lam_l_N"])
    before, after = (np.sqrt(np.mean([float(row[f"z_m_{when}"]) ** 2 for row in rows])) for when in ("before", "after"))
    assert after < before
    assert after == pytest.approx(1e-4, rel=0.3)  # the camera's noise, 48 rows


def test_mirror_pairs_put_a_taper_on_the_even_side(done) -> None:
    """Mirror symmetry: the hidden taper is even."""
    rows = table(done / "parity.csv")
    even, odd = (sum(float(row[f"z_m_{word}"]) ** 2 for row in rows) for word in ("even", "odd"))
    assert even > 2.0 * odd


def test_cosines_are_those_of_patterns(done) -> None:
    """Known look-alikes and opposites."""
    cosine = {(row["first"], row["second"]): float(row["cosine"]) for row in table(done / "cosines.csv")}
    names = {first for first, _ in cosine}
    assert all(cosine[name, name] == pytest.approx(1.0) for name in names)
    assert abs(cosine["stiffness_taper", "clamp_rotation_compliance"]) > 0.95  # they are known look-alikes
    assert abs(cosine["stiffness_taper", "precurvature"]) < 0.3  # even and odd


def test_the_next_loads_go_on_from_the_result(done, capsys) -> None:
    """Contract: the set of the result, within the given time."""
    words = ["next", str(done / "diagnose.json"), "--minutes", "4"]
    assert main([*words, "--add-ons", "nothing", "wrench", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert {"stiffness_taper", "clamp_rotation_compliance"} <= set(answer["set"])
    assert answer["minutes"] <= 4.0
    assert answer["sigma_after"] >= answer["sigma_before"]
    assert all(entry["mount"] in ("nothing", "wrench") for entry in answer["next"])
    assert main(words) == 0
    assert "to tell apart" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["next", "none.json"], "none.json: cannot be read"),
        (["next", "none.json"], "ecm-fast diagnose DATA --out DIR writes DIR/diagnose.json"),
        (["next", "{file}", "--add-ons", "masss"], "did you mean 'mass'"),
        (["next", "{file}", "--minutes", "0"], "minutes = 0"),
    ],
)
def test_wrong_words_are_told(done, capsys, words, message) -> None:
    """Contract: exit code 2 and the text of the error."""
    assert main([word.format(file=done / "diagnose.json") for word in words]) == 2
    assert message in capsys.readouterr().err


def test_another_json_is_told(done, capsys, tmp_path) -> None:
    """Contract: exit code 2 and the text of the error."""
    (tmp_path / "other.json").write_text("{}")
    assert main(["next", str(tmp_path / "other.json")]) == 2
    assert "has no 'inputs'" in capsys.readouterr().err


def test_a_wrong_unit_stops_the_command(done, capsys, tmp_path) -> None:
    """By hand: a column labelled a thousand times too small."""
    text = (done.parent / "run.csv").read_text(encoding="utf-8")
    (tmp_path / "run.csv").write_text(text.replace(",x_m,", ",x_mm,"), encoding="utf-8")
    assert main(["diagnose", str(tmp_path / "run.csv"), "--out", str(tmp_path)]) == 2
    assert "label it x_m" in capsys.readouterr().err


def test_a_folder_stands_for_the_result_in_it(done, capsys) -> None:
    """Contract: the same answer for folder and file."""
    answers = []
    for place in (done, done / "diagnose.json"):
        assert main(["next", str(place), "--minutes", "2", "--add-ons", "nothing", "--json"]) == 0
        answers.append(json.loads(capsys.readouterr().out))
    assert answers[0] == answers[1]
    assert main(["next", str(done.parent)]) == 2
    assert str(done.parent / "diagnose.json") in capsys.readouterr().err


def test_a_name_alone_is_checked_against_its_nearest_rivals(done, capsys, tmp_path) -> None:
    """By hand: a result whose set has one name."""
    result = json.loads((done / "diagnose.json").read_text(encoding="utf-8"))
    single = [model for model in result["models"] if len(model["names"]) == 1 and not model["refused"]]
    result["models"] = [{**model, "in_set": model is single[0]} for model in single[:3]]
    (tmp_path / "diagnose.json").write_text(json.dumps(result), encoding="utf-8")
    assert main(["next", str(tmp_path), "--minutes", "4", "--add-ons", "wrench"]) == 0
    first, *rest = (model["names"][0] for model in single[:3])
    assert capsys.readouterr().out.startswith(f"to check {first} against its nearest rivals: {'; '.join(rest)}\n")


def test_a_page_that_fails_loses_nothing(done, capsys, monkeypatch, tmp_path) -> None:
    """Contract: the result is written although the page is not."""

    def fail(*_, **__):
        raise RuntimeError("no picture")

    monkeypatch.setattr("ecm_fast.pages.diagnosis.write_diagnosis", fail)
    words = ["diagnose", str(done.parent / "run.csv"), "--out", str(tmp_path), "--candidates", "stiffness_taper"]
    assert main([*words, "--json"]) == 1
    out, err = capsys.readouterr()
    assert "RuntimeError: no picture" in err.splitlines()[-1]
    written = json.loads((tmp_path / "diagnose.json").read_text(encoding="utf-8"))
    assert json.loads(out) == written
    assert written["effects"][0]["name"] == "stiffness_taper"
    assert Mechanism.from_toml(tmp_path / "mechanism.toml").effects["stiffness_taper"] != 0.0


def test_few_rows_beside_many_are_no_warning(done, capsys, tmp_path) -> None:
    """By hand: the same rows in one file and in two."""
    lines = (done.parent / "run.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    for name, part in {"few.csv": lines[:9], "many.csv": [lines[0], *lines[9:]]}.items():
        (tmp_path / name).write_text("".join(part), encoding="utf-8")
    words = ["diagnose", str(tmp_path / "few.csv"), "--candidates", "precurvature", "--out", str(tmp_path)]
    both = [*words[:2], str(tmp_path / "many.csv"), *words[2:]]
    assert main(words) == 0
    assert "30 rows or more" in capsys.readouterr().err
    assert main(both) == 0
    assert "30 rows or more" not in capsys.readouterr().err
