"""Large data sets: a share of the rows is searched, all rows decide; progress reports."""

import io
import json
from collections.abc import Callable

import numpy as np
import pytest

from ecm_fast import Measurements, Mechanism, diagnose
from ecm_fast.cli import main
from ecm_fast.cli.frame import terminal as _streams
from ecm_fast.diagnosis.answer.claims import claims
from ecm_fast.diagnosis.search import subsample as many
from ecm_fast.diagnosis.search.model_selection import search
from ecm_fast.identification.rows import FitRows
from ecm_fast.studies.diagnosis import Study
from ecm_fast.testbed import Sensors, in_sequence, measure, shear_test, tendon_test
from ecm_fast.testbed.sealed.hide import hide

pytestmark = pytest.mark.slow

NECK = Mechanism()
MADE = NECK.replace(EA=7600.0, GA=2400.0, EI=2.95)
COUPLE = "bending_hysteresis.couple"


@pytest.fixture(scope="module")
def looped() -> Measurements:
    """A hysteresis in 2600 rows: what a row inherits comes from the rows between those that are searched."""
    return measure(MADE.replace(**{f"effects.{COUPLE}": 0.05}), tendon_test(2600, seed=1), Sensors(), seed=2)


def test_a_share_and_all_rows_give_the_same_name_and_size(looped: Measurements) -> None:
    """Known truth of the test bed, and the search over all rows."""
    found = diagnose(NECK, looped)
    problem = Study(NECK, looped).problem()
    assert problem.open.size > many.ENOUGH
    every = search(problem, 0.01, 2, 0)
    names = [problem.candidates[i].name for i in every.best.model]
    assert (found.verdict, list(found.names)) == ("named", names) == ("named", ["bending_hysteresis"])
    low, high = found.effects[0].interval[COUPLE]
    assert low < 0.05 < high
    key = f"effects.{COUPLE}"
    assert abs(found.effects[0].parameters[COUPLE] - every.best.by_key()[key]) < 0.1 * (high - low)
    place = every.best.keys.index(key)
    width = 2.0 * 1.645 * np.sqrt(every.best.covariance[place, place])  # of 90 % under a normal law
    assert (high - low) == pytest.approx(width, rel=0.02)
    assert found.gap is not None
    assert 0.95 < found.gap.after.sigma < 1.05


def test_an_effect_that_only_all_rows_show_is_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A size that all rows show with seven standard deviations is one of three in a share of a sixth of them."""
    monkeypatch.setattr(many, "ENOUGH", 375)
    loads = tendon_test(3000, seed=3)
    clean = diagnose(NECK, measure(MADE, loads, seed=4))
    assert clean.verdict == "nothing_found"
    smallest = next(sight.smallest for sight in clean.sights if sight.name == "precurvature")
    data = measure(MADE.replace(precurvature=1.3 * smallest), loads, seed=5)
    problem = Study(NECK, data).problem()
    assert search(problem.by(many.evenly(problem, 375)), 0.01, 2, 0).effects == 0
    answer, one = diagnose(NECK, data), search(problem, 0.01, 2, 0)
    every = claims(one, dict.fromkeys(one.best.model, one.null))
    assert [claim.name for claim in answer.effects] == [claim.name for claim in every] != []
    assert answer.effects[0].look_alikes == every[0].look_alikes


def test_a_second_effect_that_all_rows_ask_for_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """A share of the rows shows the larger of two effects, which passes the tests of all rows alone."""
    hidden = {"clamp_lateral_compliance": 5e-6, "force_crosstalk": 0.015}
    data, _ = hide(effects=hidden, design="T+S", noise="force", seed=1)
    priors = {"EA": (7500.0, 75.0), "GA": (2420.0, 17.0), "EI": (3.0, 0.01)}
    monkeypatch.setattr(many, "ENOUGH", 30)
    problem = Study(NECK, data, priors=priors).problem()
    assert search(problem.by(many.evenly(problem, 30)), 0.01, 2, 0).effects == 1
    found = diagnose(NECK, data, priors=priors)
    assert not any(gate.alarm for gate in found.gates if gate.stage == 1)
    assert found.names == tuple(hidden)
    assert any("clamp_lateral_compliance alone passes the tests, too" in line for line in found.warnings)


def test_nothing_is_left_of_a_look_alike_of_the_share(monkeypatch: pytest.MonkeyPatch) -> None:
    """The tests look at what one name leaves, not at what it leaves beside another one that the rows refute."""
    monkeypatch.setattr(many, "ENOUGH", 375)
    data = measure(MADE.replace(precurvature=0.05), tendon_test(3000, seed=3), seed=7)
    problem = Study(NECK, data).problem()
    few = search(problem.by(many.evenly(problem, 375)), 0.01, 2, 0)
    assert few.names(few.best) == ("force_zero_asymmetry",)
    found = many.search_all(problem, 0.01, 2, 0)
    assert found.names(found.best) == ("precurvature",)
    sizes = {candidate.keys[0] for candidate in problem.candidates}
    assert sizes.intersection(found.view.values) == {"effects.precurvature"}


def test_the_share_keeps_small_experiments_whole() -> None:
    """Counting: the rows of a small and a large experiment."""
    data = measure(MADE, in_sequence(tendon_test(4000, seed=6), shear_test(np.linspace(-60.0, 60.0, 40))), seed=7)
    problem = Study(NECK, data).problem()
    rows = many.evenly(problem, 900)
    assert rows.size <= 900
    assert np.all(np.diff(rows) > 0)
    assert not problem.locked[rows].any()
    small = np.flatnonzero(data.experiment == "shear")
    assert set(np.intersect1d(problem.open, small)) <= set(rows)
    assert np.array_equal(many.evenly(problem, 10**6), problem.open)
    assert np.diff(rows[data.experiment[rows] == "tendon"]).max() < 40  # one in four on the average


def test_rows_solved_alone_are_as_among_all(looped: Measurements) -> None:
    """Contract: a row's residual depends on no other row."""
    problem = Study(NECK, looped.select(range(200))).problem()
    some = np.array([3, 4, 50, 77, 199])
    keys = [f"effects.{COUPLE}", "effects.creep", "beam.EI"]
    values = np.array([0.04, 0.01, 2.9])
    all_rows, few = (FitRows(problem.sets, keys, problem.mesh, only) for only in (None, some))
    whole, part = all_rows.at(values), few.at(values)
    for name in ("pose", "by", "dpose_dlam", "status"):
        np.testing.assert_array_equal(getattr(whole, name)[some], getattr(part, name))
    spread = part.among(200, some)
    assert np.flatnonzero(spread.stable).tolist() == some.tolist()
    assert np.isnan(np.delete(spread.pose, some, axis=0)).all()


def test_everybody_who_asks_is_told_of_every_step(looped: Measurements) -> None:
    """Contract: lines of progress in order."""
    messages: list[str] = []
    diagnose(NECK, looped.select(range(60)), progress=messages.append)
    assert messages[0].startswith("[....................] search")
    assert "proof" in messages[-1]
    assert any("calibration" in line for line in messages)
    bars = [line.count("#") for line in messages]
    assert bars == sorted(bars)
    messages.clear()
    diagnose(NECK, looped, candidates=["bending_hysteresis", "creep"], progress=messages.append)
    stages = [line.split("] ")[1].split(",")[0] for line in messages]
    assert list(dict.fromkeys(stages)) == ["search", "all rows", "proof"]


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("make", "shown"), [(_Terminal, True), (io.StringIO, False)])
def test_a_terminal_shows_one_line_that_goes_away(
    make: Callable[[], io.StringIO], shown: bool, looped: Measurements, tmp_path, monkeypatch, capsys
) -> None:
    """Contract: what a terminal and a file are sent."""
    looped.select(range(60)).to_csv(tmp_path / "run.csv")
    stream = make()
    monkeypatch.setattr(_streams, "_PATIENCE", 0.0)
    monkeypatch.setattr("sys.stderr", stream)
    monkeypatch.chdir(tmp_path)
    assert main(["diagnose", "run.csv", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"]
    text = stream.getvalue()
    assert ("\r[" in text) == shown
    if shown:
        last = text[: text.index("ecm-fast:")].rsplit("\r", 2)
        assert last[1].strip() == ""
        assert last[2] == ""
