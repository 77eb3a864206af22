"""Grades of answers, against hand counts."""

import json

import pytest

from ecm_fast import Truth, score
from ecm_fast.__main__ import main
from ecm_fast.errors import InputError

BENT = Truth(effects={"precurvature": 0.2})
PAIR = Truth(effects={"precurvature": 0.2, "contact_stop.stiffness": 5.0, "contact_stop.angle": 0.4})


def claim(name, value=None, interval=None, look_alikes=(), key=None):
    key = key or name
    known = {} if interval is None else {"interval": {key: interval}}
    return {"name": name, "parameters": {key: value}, "look_alikes": list(look_alikes), **known}


def answer(*effects, verdict="named", gap=(None, None, None), given=None):
    known = zip(("given", "before", "after", "floor"), (given, *gap), strict=True)
    levels = {name: {"rms_sigma": level} for name, level in known}
    return {"verdict": verdict, "sentence": "", "effects": list(effects), "gap": {"rows": 20, **levels}}


def test_a_right_answer():
    """By hand: every grade of one answer."""
    grade = score(answer(claim("precurvature", 0.21, [0.19, 0.23]), gap=(5.0, 1.0, 1.0)), BENT)
    assert grade.top
    assert grade.in_set
    assert grade.verdict_right
    assert grade.alone_right
    assert not grade.extra
    assert not grade.false_alarm
    assert grade.set_size == 1
    assert grade.size_error == pytest.approx({"precurvature": 0.05})
    assert grade.covered == {"precurvature": True}
    assert grade.gap_closed == 1.0
    assert grade.gap_closed_since_given is None  # an answer that does not say it
    assert repr(grade) == (
        "<Score of named (precurvature) on precurvature: verdict right, top names right, set right; "
        "gap closed 100.0%; precurvature off by +5.0%>"
    )


def test_the_truth_among_the_look_alikes():
    """By hand: every grade of one answer."""
    grade = score(answer(claim("side_force", 1.0, look_alikes=["precurvature", "clamp_tilt"]), verdict="family"), BENT)
    assert (grade.top, grade.in_set, grade.set_size, grade.alone, grade.alone_right) == (False, True, 3, False, None)
    assert grade.verdict_right
    assert grade.size_error == {}


def test_one_wrong_name_alone():
    """By hand: grades, and the closed share of the gap from its squares."""
    grade = score(answer(claim("side_force", 1.0), gap=(5.0, 3.0, 1.0), given=9.0), BENT)
    assert (grade.top, grade.in_set, grade.alone_right) == (False, False, False)
    assert grade.gap_closed == pytest.approx(1.0 - 8.0 / 24.0)
    assert grade.gap_closed_since_given == pytest.approx(1.0 - 8.0 / 80.0)


def test_a_second_name_on_one_effect():
    """By hand: every grade of one answer."""
    grade = score(answer(claim("precurvature", 0.1, [0.11, 0.12]), claim("creep", 0.1)), BENT)
    assert grade.extra
    assert grade.top
    assert not grade.alone_right
    assert grade.covered == {"precurvature": False}


def test_pairs_need_both():
    """By hand: grades of a pair, and of half of it."""
    both = [claim("contact_stop", 4.0, key="contact_stop.stiffness"), claim("precurvature", 0.2, look_alikes=["a"])]
    grade = score(answer(*both), PAIR)
    assert PAIR.kind == "pair"
    assert (grade.top, grade.in_set, grade.set_size, grade.extra) == (True, True, 1.5, False)
    assert grade.size_error == pytest.approx({"precurvature": 0.0, "contact_stop.stiffness": -0.2})
    one = score(answer(both[1]), PAIR)
    assert (one.top, one.in_set) == (False, False)


def test_clean_data():
    """By hand: four answers on data without an effect."""
    assert score(answer(verdict="nothing_found"), Truth()).verdict_right
    gap = score(answer(verdict="data_gap"), Truth())
    assert (gap.verdict_right, gap.false_alarm, gap.top, gap.in_set, gap.set_size) == (False, False, None, None, None)
    assert score(answer(claim("creep", 0.1)), Truth()).false_alarm
    assert score(answer(verdict="outside_catalogue"), Truth()).false_alarm
    excused = score(answer(claim("lever_arm", 1e-4)), Truth(tolerance={"lever_arm": 1e-4}))
    assert (excused.alone_right, excused.extra) == (True, False)


def test_outside_the_catalogue():
    """By hand: a right and a wrong answer."""
    truth = Truth(outside={"slack": 9.0})
    right, wrong = score(answer(verdict="outside_catalogue"), truth), score(answer(claim("creep", 0.1)), truth)
    assert (right.verdict_right, right.hidden, right.alone_right) == (True, ("slack",), None)
    assert (wrong.verdict_right, wrong.alone_right) == (False, False)


def test_what_is_unknown_stays_unknown():
    """Contract: an unknown size, interval or gap is left out."""
    grade = score(answer(claim("precurvature", None, [None, 0.3])), BENT)
    assert (grade.size_error, grade.covered, grade.gap_closed) == ({}, {}, None)
    assert score(answer(gap=(1.0, 1.0, 1.0), verdict="nothing_found"), Truth()).gap_closed is None
    assert score({"verdict": "nothing_found", "effects": []}, Truth()).gap_closed is None


def test_objects_files_and_the_command(tmp_path, capsys):
    """Contract: three ways in, one grade."""

    class Result:
        def to_json_dict(self):
            return answer(claim("precurvature", 0.21, [0.19, 0.23]), gap=(5.0, 1.0, 1.0))

    (tmp_path / "result.json").write_text(json.dumps(Result().to_json_dict()))
    path = BENT.to_json(tmp_path / "truth.json")
    assert score(Result(), BENT) == score(tmp_path / "result.json", path)
    assert main(["score", str(tmp_path / "result.json"), str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == score(Result(), BENT).to_json_dict() | {
        "hidden": ["precurvature"],
        "named": ["precurvature"],
    }
    assert main(["score", str(tmp_path / "result.json"), str(path)]) == 0
    assert "precurvature: +5.00% off, interval holds the truth: yes" in capsys.readouterr().out


def test_no_answer(tmp_path):
    """Contract: the text of the error."""
    (tmp_path / "bad.json").write_text("{")
    for bad, message in (
        (tmp_path / "bad.json", "cannot be read as an answer"),
        (tmp_path / "none.json", "cannot be read as an answer"),
        ({}, r"^result: no answer of diagnose \(KeyError: 'effects'\)$"),
        ({"effects": [{}], "verdict": "named"}, r"^result: no answer of diagnose \(KeyError: 'name'\)$"),
        ({"effects": 3, "verdict": "named"}, "no answer of diagnose"),
    ):
        with pytest.raises(InputError, match=message):
            score(bad, BENT)
