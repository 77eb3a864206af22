"""Effects whose law is not the catalogue's, hidden by variants of the test bed: the right name, and no second one."""

import numpy as np
import pytest

import ecm_fast as ecm
from ecm_fast.diagnosis.problem.law_tolerance import FUNCTIONS, law_columns
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.mechanism.parameters import find

pytestmark = pytest.mark.slow

NECK = ecm.Mechanism()
PRIORS = {name: (getattr(NECK.beam, name), find(name).typical) for name in ("EA", "GA", "EI")}


def answer(name, variant, seed, design="T+S"):
    size = 1.8 * CATALOGUE[name].size.typical
    data, truth = ecm.hide(effects={name: size}, design=design, seed=seed, noise="force", variant=variant)
    return ecm.diagnose(NECK, data, priors=PRIORS), truth


@pytest.mark.parametrize(
    ("name", "variant"),
    [
        ("marker_lever_x", "zeroed_at_rest"),
        ("camera_rotation", "turned_about_marker"),
        ("tendon_capstan_friction", "wrap_grows"),
        ("precurvature", "cast_below"),
    ],
)
def test_the_right_effect_is_named_alone(name, variant):
    """Hidden truth: an effect of another law; as exact laws are fitted, a second one mends what the law leaves."""
    found, truth = answer(name, variant, seed=21)
    assert found.names == truth.names == (name,)
    (claim,) = found.effects
    assert claim.law


def test_a_zeroed_camera_goes_into_the_mechanism(tmp_path):
    """Hidden truth: another file of the same zeroed camera; its error falls to the noise."""
    found, truth = answer("marker_lever_x", "zeroed_at_rest", seed=21)
    (claim,) = found.effects
    assert claim.law == "seen by a camera that was zeroed at rest"
    size = truth.effects["marker_lever_x"]
    other, _ = ecm.hide(
        effects={"marker_lever_x": size}, design="grid5", seed=22, variant="zeroed_at_rest", spread=False
    )
    before, after = (
        np.sqrt(np.nanmean(((ecm.predict(each, other).pose - other.pose) / [1e-4, 1e-4, 1e-3]) ** 2))
        for each in (NECK, found.mechanism.replace(EA=NECK.beam.EA, GA=NECK.beam.GA, EI=NECK.beam.EI))
    )
    assert before > 3.0
    assert after < 1.6


def test_a_law_of_the_catalogue_is_taken_as_it_is():
    """Hidden truth: the law as the catalogue has it; nothing is said of another one."""
    data, truth = ecm.hide(effects={"bending_cubic": None}, design="T+S", seed=21, noise="force")
    found = ecm.diagnose(NECK, data, priors=PRIORS)
    assert found.names == truth.names
    assert found.effects[0].law == ""


def test_rows_without_an_angle_have_a_law_as_well():
    """Hidden truth: the same, where a third of the angles was not read."""
    size = 1.8 * CATALOGUE["tendon_capstan_friction"].size.typical
    data, truth = ecm.hide(
        effects={"tendon_capstan_friction": size}, design="T+S", seed=21, noise="force", variant="wrap_grows"
    )
    blank = np.zeros((data.n, 3), dtype=bool)
    blank[::3, 2] = True
    found = ecm.diagnose(NECK, data.blank(blank, data.channels), priors=PRIORS)
    assert found.names == truth.names
    assert found.effects[0].law


def test_functions_of_a_law_have_the_share_that_is_stated():
    """By hand: each column is the signature times a function of weighted mean 0 and spread 1, times the share."""
    rng = np.random.default_rng(1)
    change, functions = rng.standard_normal((50, 3)), rng.standard_normal((50, 9))
    whitening = np.tile(np.diag([2.0, 3.0, 5.0]), (50, 1, 1))
    whitening[7, 2, 2] = 0.0  # a reading that is missing
    signature = (whitening @ change[:, :, None])[:, :, 0]
    columns = law_columns(change, functions, whitening, 0.1)
    assert columns.shape == (50, 3, len(FUNCTIONS))
    size = np.linalg.norm(columns[:, :, :11].reshape(150, -1), axis=0)
    np.testing.assert_allclose(size, 0.1 * np.linalg.norm(signature), rtol=1e-12)
    np.testing.assert_allclose(columns[:, :, 11:].sum(axis=2), 0.0, atol=1e-14)
