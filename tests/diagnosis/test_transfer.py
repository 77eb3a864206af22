"""External validation: a right name carries over to other experiments, a wrong one is reported."""

import json
from dataclasses import replace

import numpy as np
import pytest

from ecm_fast import Mechanism, diagnose, identify, predict
from ecm_fast.cli import main
from ecm_fast.diagnosis.proof.external_validation import transfer
from ecm_fast.diagnosis.results.diagnosis import Noise
from ecm_fast.diagnosis.results.external_validation import allowed
from ecm_fast.diagnosis.search.subsample import search_all
from ecm_fast.studies.diagnosis import Study
from ecm_fast.testbed import Sensors, measure, shear_test, tendon_test

pytestmark = pytest.mark.slow

NECK = Mechanism()
LOADS = tendon_test(grid=9, seed=2)
SIDE = shear_test(np.linspace(-60.0, 60.0, 9))
TRUTH = NECK.replace(EA=7600.0, GA=2400.0, EI=2.95, precurvature=0.12)
KNOWN = {"GA": (2400.0, 20.0)}


@pytest.fixture(scope="module")
def bent():
    return measure(TRUTH, LOADS, Sensors(force_sigma=0.1), seed=3)


@pytest.fixture(scope="module")
def side():
    return measure(TRUTH, SIDE, Sensors(force_sigma=0.1), seed=8)


def test_noise_alone_exceeds_what_is_allowed_once_in_a_hundred():
    """Monte Carlo: 20000 draws of pure noise."""
    drawn = np.sqrt(np.mean(np.random.default_rng(1).standard_normal((20000, 27)) ** 2, axis=1))
    assert 0.008 < np.mean(drawn > allowed(27)) < 0.012  # 200 expected, standard deviation 14
    assert allowed(10000) == 1.1  # chance alone allows less there


def test_the_right_name_carries_over(bent, side):
    """Known truth of the test bed, on side forces."""
    found = diagnose(NECK, bent, priors=KNOWN, test=side)
    (entry,) = found.transfer
    assert found.names == ("precurvature",)
    assert entry.proves
    assert entry.before.sigma > 3.0
    assert "precurvature carries over to" in found.sentence
    assert not any("carry" in text for text in found.warnings)


def test_what_the_next_best_leave_of_it_is_said(bent, side):
    """Each refitted on its own, with no drift and no outliers allowed for: good to a tenth."""
    found = diagnose(NECK, bent, priors=KNOWN, test=side)
    (entry,) = found.transfer
    best = [model.names[0] for model in found.models if len(model.names) == 1 and not model.refused][1:6]
    assert [name for name, _ in entry.rivals] == best
    seen = bent.select(np.flatnonzero(~found.rows.locked & ~found.rows.outlier))
    sigma = np.column_stack([side.sigma_x, side.sigma_z, side.sigma_theta]) * np.maximum(found.noise.scale, 1.0)
    for name, left in entry.rivals:
        own = identify(NECK, seen, ["EA", "GA", "EI", name], priors=KNOWN).mechanism
        assert left == pytest.approx(np.sqrt(np.mean((predict(own, side).residual / sigma) ** 2)), rel=0.1)
        assert (name in found.sentence.partition("It refutes")[2]) == (left > entry.allowed)


def test_a_wrong_name_is_refuted_before_it_is_given(bent, side, tmp_path, capsys):
    """Only a wrong name may be given: it takes up the tendons' loads in part, and misses the side forces."""
    bent.to_csv(tmp_path / "run.csv")
    side.to_csv(tmp_path / "side.csv")
    words = ["diagnose", str(tmp_path / "run.csv"), "--test", str(tmp_path / "side.csv"), "--out", str(tmp_path)]
    assert main([*words, "--candidates", "plate_misalignment", "--prior", "GA", "2400", "20"]) == 0
    first = capsys.readouterr().out.splitlines()[0]
    answer = json.loads((tmp_path / "diagnose.json").read_text(encoding="utf-8"))
    assert not answer["transfer"][0]["carries_over"]
    assert "does NOT carry over to side.csv" in answer["sentence"]
    assert "does NOT carry over to side.csv" in first
    assert "Fit both" in answer["warnings"][0]
    page = (tmp_path / "diagnosis.html").read_text(encoding="utf-8")
    assert "does NOT carry over to side.csv" in page[: page.index("<h2>")]


def test_a_test_file_with_a_wrong_sign_is_refused(bent, side, tmp_path, capsys):
    """By hand: the sign of a column turned."""
    bent.to_csv(tmp_path / "run.csv")
    replace(side, fz=-side.fz).to_csv(tmp_path / "side.csv")
    words = ["diagnose", str(tmp_path / "run.csv"), "--test", str(tmp_path / "side.csv"), "--out", str(tmp_path)]
    assert main(words) == 2
    assert "side.csv: " in (printed := capsys.readouterr().err)
    assert "sign" in printed


def test_a_calibration_that_may_move_is_told_from_a_wrong_name(bent, side):
    """A material test that is two of its standard deviations off: the tendons' loads hardly see GA, side forces do."""
    found = diagnose(NECK, bent, priors={"GA": (2800.0, 200.0)}, test=side)
    (entry,) = found.transfer
    assert found.names == ("precurvature",)
    assert not entry.carries_over
    assert entry.adapted <= entry.allowed
    assert "not known well enough to tell" in found.sentence


def test_what_is_left_within_the_doubt_is_mahalanobis(bent):
    """Linear algebra: the Mahalanobis distance, by NumPy."""
    side = measure(TRUTH, SIDE, seed=8)  # exact force cells: the noise is the camera's alone
    study = Study(NECK, bent, candidates=["precurvature"])
    found = search_all(study.problem(), 0.01, 1, 0)
    entry = transfer(study.problem([side]), found, Noise((1e-4, 1e-4, 1e-3), 0.0, {}, (1.0, 1.0, 1.0), 0.0, 0.0), 0)
    fit = found.best

    def pose(values):
        return predict(NECK.replace(**dict(zip(fit.keys, values, strict=True)), **fit.build), side).pose

    steps = np.diag(1e-5 * np.maximum(np.abs(fit.values), 1e-2))
    sigma = np.array([1e-4, 1e-4, 1e-3]) * np.maximum(found.scale, 1.0)
    by = np.stack([(pose(fit.values + h) - pose(fit.values - h)) / (2.0 * h.sum() * sigma) for h in steps], axis=2)
    by, off = by.reshape(27, -1), ((side.pose - pose(fit.values)) / sigma).ravel()
    left = off @ np.linalg.solve(np.eye(27) + by @ fit.covariance @ by.T, off)
    assert entry.after.sigma == pytest.approx(np.sqrt(off @ off / 27), rel=1e-6)
    assert entry.adapted == pytest.approx(np.sqrt(left / 27), rel=1e-4)
