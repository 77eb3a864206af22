"""Explanations that are no answer: sizes beyond reason, names that leave most of the misfit."""

from dataclasses import replace

import numpy as np
import pytest

import ecm_fast as ecm
from ecm_fast.diagnosis.search.model_selection import FAILS, NO_GAIN, OUTCOMES, PASSES, UNTRIED
from ecm_fast.diagnosis.search.subsample import search_all

pytestmark = pytest.mark.slow

NECK = ecm.Mechanism()
GIVEN = ["precurvature", "pulley_shift", "force_gain_asymmetry", "marker_lever_x"]
"""Names that broken force cells were given."""


def test_a_size_of_many_times_the_typical_one_is_no_answer() -> None:
    """Hidden truth: a precurvature of 1.71 1/m, nine times what is typical; a dead cell was told as that."""
    data, _ = ecm.hide(effects={"precurvature": 1.71}, seed=3)
    found = ecm.diagnose(NECK, data, candidates=["precurvature"])
    assert found.verdict == "outside_catalogue"
    assert found.effects == ()
    assert any("but precurvature would need 9 times its typical size" in text for text in found.warnings)
    usual = ecm.diagnose(NECK, ecm.hide(effects={"precurvature": 0.4}, seed=3)[0], candidates=["precurvature"])
    assert usual.names == ("precurvature",)


@pytest.mark.parametrize("fault", ["dead", "saturated", "dropped out"])
def test_a_broken_cell_has_no_name_even_unchecked(fault) -> None:
    """Known truth: nothing is hidden, and one column was overwritten; the checks that refuse it are left out."""
    data, _ = ecm.hide(noise="force", seed=3)
    lost = np.random.default_rng(5).random(data.n) < 0.1
    values = {"dead": 0.0 * data.lam_l, "saturated": np.minimum(data.lam_l, 120.0),
              "dropped out": np.where(lost, 0.0, data.lam_l)}[fault]  # fmt: skip
    study = ecm.Study(NECK, replace(data, lam_l=values), candidates=GIVEN)
    with pytest.raises(ecm.InputError, match=f"the cell is {fault}|the cell {fault}"):
        study.check()
    found = search_all(study.problem(), 0.01, 2, 0)
    assert (found.effects, found.outside) == (0, True)


def test_every_outcome_of_the_search_has_an_answer() -> None:
    """Counting: one effect passes or fails; two are not tried, gain nothing, fail or pass."""
    assert set(OUTCOMES) == {(one, two) for one in (PASSES, FAILS) for two in (UNTRIED, NO_GAIN, FAILS, PASSES)}
    assert {answer for (_, two), answer in OUTCOMES.items() if two == PASSES} == {"two"}
    assert all(answer != "one" for (one, _), answer in OUTCOMES.items() if one == FAILS)
