"""Copies of rows are no further evidence: what a diagnosis says of data holds for the same data given twice."""

import numpy as np
import pytest

from ecm_fast import InputError, Measurements, Mechanism, Study, diagnose, hide, identify
from ecm_fast.data.repeated_rows import repeated_rows, without_poses

NECK = Mechanism()


@pytest.fixture(scope="module")
def bent():
    """Measurements of a neck that is bent by itself, force noise included."""
    return hide(effects={"precurvature": 0.2}, noise="force", seed=4)[0]


@pytest.fixture(scope="module")
def clean():
    return hide(noise="force", seed=1)[0]


def test_copies_are_told_from_repeated_loads(clean) -> None:
    """A load that is measured again has another noise; a copy has the same digits, whatever its time stamp."""
    twice = clean.select(np.repeat(np.arange(clean.n), 2))
    assert repeated_rows([twice])[0].tolist() == [False, True] * clean.n
    again = hide(noise="undeclared+force", seed=1)[0]  # ten loads are applied five times
    assert not repeated_rows([again])[0].any()
    one, other = repeated_rows([clean, clean.select(np.arange(5))])
    assert not one.any()
    assert other.all()
    signed = [Measurements.from_columns({"lam_l_N": [5.0], "fx_N": [zero], "x_m": [0.1]}) for zero in (0.0, -0.0)]
    assert repeated_rows(signed)[1].all()  # 0 is the same number with any sign
    blank = without_poses(clean, np.ones(clean.n, dtype=bool))
    assert not repeated_rows([blank, blank])[1].any()  # a row without a pose is no evidence


COPIES = {
    "twice": lambda n: np.repeat(np.arange(n), 2),
    "five times": lambda n: np.tile(np.arange(n), 5),
    "a block three times": lambda n: np.concatenate([np.arange(n), np.arange(20), np.arange(20)]),
}


@pytest.mark.slow
@pytest.mark.parametrize("order", COPIES.values(), ids=COPIES)
def test_copied_rows_change_no_answer(bent, order) -> None:
    """Rows that occur twice, five times, or a block three times, ended in ``outside_catalogue``."""
    plain, copied = diagnose(NECK, bent), diagnose(NECK, bent.select(order(bent.n)))
    assert copied.names == plain.names == ("precurvature",)
    assert any("copies of earlier rows" in text for text in copied.noticed)
    for name in ("EA", "GA", "EI"):
        assert copied.calibration[name].std > 0.9 * plain.calibration[name].std


@pytest.mark.slow
def test_copied_rows_of_clean_data_find_nothing(clean) -> None:
    """Known truth: nothing is hidden; a block of twenty rows is copied twice."""
    order = COPIES["a block three times"](clean.n)
    assert diagnose(NECK, clean.select(order)).verdict == "nothing_found"


@pytest.mark.slow
def test_the_same_file_twice_is_one_file(bent) -> None:
    """Known truth: the second file is the first one."""
    plain, twice = diagnose(NECK, bent), diagnose(NECK, [bent, bent])
    assert twice.effects[0].interval == plain.effects[0].interval
    assert any("81 of 81 rows repeat rows of the files before" in text for text in twice.noticed)


def test_a_test_takes_rows_that_no_fit_has_seen(bent) -> None:
    """``diagnose s.csv --test s.csv`` said that what was found carries over."""
    with pytest.raises(InputError, match="all its 81 rows are among those fitted") as caught:
        diagnose(NECK, bent, test=bent)
    assert "\n" not in str(caught.value)
    fitted = bent.select(np.arange(60))
    study = Study(NECK, fitted, test=bent)
    (unseen,) = study.unseen
    assert np.flatnonzero(unseen.measured.any(axis=1)).tolist() == list(range(60, 81))
    assert any("60 of 81 rows repeat" in text for text in study.check())


def test_a_fit_weighs_copies_once(clean) -> None:
    """Five copies of each row would make intervals narrower by the root of five."""
    names = ["EA", "GA", "EI"]
    plain = identify(NECK, clean, names)
    copied = identify(NECK, clean.select(np.tile(np.arange(clean.n), 5)), names)
    assert copied.rows == plain.rows
    for name in names:
        assert copied[name].std == pytest.approx(plain[name].std, rel=1e-3)
    assert "copies of earlier rows" in copied.warnings[0]
    both = identify(NECK, [clean, clean], names)
    assert both["EI"].std == pytest.approx(plain["EI"].std, rel=1e-3)
