"""Caveats: calibrations that contradict the material, each made by hand."""

import pytest

from ecm_fast import Mechanism, diagnose
from ecm_fast.diagnosis.answer.caveats import _away, stiffness_caveats
from ecm_fast.identification.result import Estimate
from ecm_fast.mechanism.parameters import find
from ecm_fast.testbed import measure, tendon_test

NECK = Mechanism()


def calibrated(**changes):
    """Return EA, GA, EI as the mechanism has them, each within 1 %; what changes is (value, standard deviation)."""
    known = {name: (value, 0.01 * value) for name in ("EA", "GA", "EI") for value in [getattr(NECK.beam, name)]}
    units = {"EA": "N", "GA": "N", "EI": "N m^2"}
    return {name: Estimate(*pair, *pair, units[name]) for name, pair in {**known, **changes}.items()}


def test_a_stiffness_that_is_known_raises_no_doubt() -> None:
    """By hand: values and standard deviations."""
    assert stiffness_caveats(calibrated(), NECK) == ()
    assert stiffness_caveats(calibrated(GA=(1.2 * NECK.beam.GA, 0.14 * 1.2 * NECK.beam.GA)), NECK) == ()
    assert stiffness_caveats(calibrated(EI=(1.02 * NECK.beam.EI, 0.001 * NECK.beam.EI)), NECK) == ()


def test_a_loose_stiffness_comes_with_its_number_and_cure() -> None:
    """By hand: the parts of the text."""
    (text,) = stiffness_caveats(calibrated(GA=(3291.48, 703.0)), NECK)
    assert "GA to no better than 21%: 3291 +- 703 N" in text
    assert f"{NECK.beam.GA:.4g} N" in text
    assert "--prior GA VALUE STD" in text
    assert "side forces" in text


def test_a_stiffness_far_from_the_file_is_said() -> None:
    """By hand: 30 standard deviations, and 10 of a batch that is a tenth softer; and a known truth of the test bed."""
    (text,) = stiffness_caveats(calibrated(EA=(0.7 * NECK.beam.EA, 0.01 * NECK.beam.EA)), NECK)
    assert "30 standard deviations (-30%)" in text
    assert not stiffness_caveats(calibrated(EA=(0.9 * NECK.beam.EA, 0.01 * NECK.beam.EA)), NECK)
    data = measure(NECK.replace(EI=0.7 * NECK.beam.EI), tendon_test(grid=6, seed=2), seed=3)
    assert any("moves EI" in text and "(-30%)" in text for text in diagnose(NECK, data, max_effects=0).warnings)


@pytest.mark.parametrize(("wanted", "caveat"), [(-254.9, "no physical GA fits"), (1900.0, "want GA = 1900 +- 38 N")])
def test_a_negative_stiffness_is_never_wanted(wanted, caveat) -> None:
    """By hand: the text."""
    text = _away(find("GA"), 2420.0, 120.0, wanted, 38.0, 13.0)
    assert caveat in text
    assert "-254.9" not in text
    assert "13.0 standard deviations, of fit and test together, from 2420 +- 120 N" in text


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (3291.48, 703.2, "3291 +- 703 N (3291 to 3291)"),
        (7409.43, 36.96, "7409 +- 37 N (7409 to 7409)"),
        (3.005981, 0.01217, "3.006 +- 0.012 N (3.006 to 3.006)"),
        (0.0015178, 5.4e-5, "0.001518 +- 0.000054 N (0.001518 to 0.001518)"),
        (2420.0, float("inf"), "2420 +- inf N (2420 to 2420)"),
        (1.5e-12, 2.5e-13, "1.5e-12 +- 2.5e-13 N (1.5e-12 to 1.5e-12)"),
    ],
)
def test_value_and_doubt_have_the_same_digits(value, std, text) -> None:
    """By hand: the text."""
    assert repr(Estimate(value, std, value, value, "N")) == text
