"""The mechanism written by a diagnosis, and its proof: tolerances of dimensions, hold-out error by stage."""

from dataclasses import replace

import numpy as np
import pytest

from ecm_fast import FiniteElementModel, Mechanism
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.models.instruments.prediction import predict
from ecm_fast.studies.diagnosis import diagnose
from ecm_fast.testbed import Sensors, measure, tendon_test

pytestmark = pytest.mark.slow

NECK = Mechanism()
OFF = {"beam_length": 6e-5, "pulley_height": -2e-4}  # twice their tolerances
TRUTH = NECK.replace(precurvature=0.2, **OFF)
LOADS = tendon_test(120, seed=3)
MATERIAL = {"EA": (7500.0, 75.0), "GA": (2420.0, 17.0), "EI": (3.0, 0.009)}


@pytest.fixture(scope="module")
def found():
    data = measure(TRUTH, LOADS, Sensors(camera_sigma=(2e-5, 2e-5, 2e-4)), seed=5)
    return diagnose(NECK, data, candidates=["precurvature", "lever_arm"], priors=MATERIAL)


def test_the_written_mechanism_has_the_fitted_dimensions(found):
    """On loads that were never measured its poses are nearer to the truth than with the dimensions as drawn."""
    assert found.names == ("precurvature",)
    exact = measure(TRUTH, tendon_test(80, seed=4), Sensors(camera_sigma=(0.0, 0.0, 0.0)), seed=6)
    drawn = found.mechanism.replace(**dict.fromkeys(found.dimensions, 0.0))
    sigma = np.array([2e-5, 2e-5, 2e-4])
    after, before = (
        np.sqrt(np.mean((predict(neck, exact).residual / sigma) ** 2)) for neck in (found.mechanism, drawn)
    )
    assert after < 0.3 < 1.0 < before
    assert found.dimensions["beam_length"] == pytest.approx(OFF["beam_length"], rel=0.5)
    assert FiniteElementModel(found.mechanism).path == "condensed"  # as fast in a control loop as before


def test_every_dimension_with_a_tolerance_is_said(found):
    """Contract: the catalogue's tolerances, in object and JSON."""
    known = {effect.name for effect in CATALOGUE.values() if effect.size.tolerance}
    assert set(found.dimensions) == set(found.dimensions_before) == known
    assert {name: found.mechanism.effects[name] for name in known} == pytest.approx(dict(found.dimensions))
    content = found.to_json_dict()
    assert (content["dimensions"], content["dimensions_before"]) == (
        dict(found.dimensions),
        dict(found.dimensions_before),
    )


def test_a_dimension_that_is_named_is_no_tolerance():
    """Known truth of the test bed; the named dimension stands in the mechanism."""
    data = measure(NECK.replace(beam_length=1e-3), LOADS, seed=7)
    found = diagnose(NECK, data, candidates=["beam_length"], priors=MATERIAL)
    assert found.names == ("beam_length",)
    assert "beam_length" not in found.dimensions
    assert found.mechanism.effects["beam_length"] == found.effects[0].parameters["beam_length"]


def test_the_gap_begins_with_the_mechanism_as_it_was_given(found):
    """Noise of the camera alone: the gap in sigmas is that of the plain prediction."""
    rows = found.rows
    sigma = np.array([2e-5, 2e-5, 2e-4]) * found.noise.scale
    off = predict(NECK, rows.data[0]).residual[rows.locked & ~rows.outlier]
    assert found.gap.given.sigma == pytest.approx(np.sqrt(np.mean((off / sigma) ** 2)), rel=1e-6)
    assert found.gap.given.theta == pytest.approx(np.sqrt(np.mean(off[:, 2] ** 2)), rel=1e-12)
    assert found.gap.given.sigma > found.gap.before.sigma > 5.0 * found.gap.after.sigma


def test_of_two_effects_each_one_closes_its_part_of_the_gap():
    """A bend to one side moves z and theta, a lever of the marker x: neither does what the other does."""
    data = measure(NECK.replace(precurvature=0.1, marker_lever_x=2e-3), LOADS, seed=8)
    found = diagnose(NECK, data, candidates=["precurvature", "marker_lever_x", "creep"], priors=MATERIAL)
    assert set(found.names) == {"precurvature", "marker_lever_x"}
    gap = found.gap
    without = [f"fitted without {name}" for name in found.names]
    assert list(gap.stages) == ["as given", "calibrated alone", *without, "with what was found", "floor"]
    for name, other in (found.names, found.names[::-1]):
        assert gap.before.sigma > gap.without[name].sigma > 2.0 * gap.after.sigma
        alone = diagnose(NECK, measure(NECK.replace(**{name: found.effects[found.names.index(name)].parameters[name]}),
                                       LOADS, seed=8), candidates=[other], max_effects=0, priors=MATERIAL)  # fmt: skip
        assert gap.without[name].sigma == pytest.approx(alone.gap.before.sigma, rel=0.2)
    assert found.to_json_dict()["gap"]["without"].keys() == gap.without.keys()


@pytest.mark.parametrize("sizes", [(0.1, 4e-4), (0.012, 3e-3)])
def test_of_two_effects_the_one_that_is_needed_most_comes_first(sizes):
    """Whatever their order in the catalogue is: 0.1 1/m and 3 mm bend and shift far more than 0.012 1/m and 0.4 mm."""
    hidden = dict(zip(("precurvature", "marker_lever_x"), sizes, strict=True))
    found = diagnose(NECK, measure(NECK.replace(**hidden), LOADS, seed=9), candidates=list(hidden), priors=MATERIAL)
    larger = "precurvature" if sizes[0] > 0.05 else "marker_lever_x"
    assert set(found.names) == set(hidden)
    assert found.names[0] == larger
    assert list(found.gap.without) == list(found.names)


def test_what_is_seen_as_a_product_alone_stands_out():
    """Capstan friction is exp(-coefficient wrap): neither number is known well, and yet nothing shows more."""
    data = measure(NECK.replace(**{"tendon_capstan_friction.coefficient": 0.03}), LOADS, seed=11)
    found = diagnose(NECK, data, candidates=["tendon_capstan_friction"], priors=MATERIAL)
    (claim,) = found.effects
    low, high = claim.interval["tendon_capstan_friction.coefficient"]
    assert high - low > 0.3 * claim.parameters["tendon_capstan_friction.coefficient"]
    assert claim.parameters["tendon_capstan_friction.coefficient"] * claim.parameters[
        "tendon_capstan_friction.wrap"
    ] == pytest.approx(0.03 * NECK.effects.get("tendon_capstan_friction.wrap", np.pi / 2), rel=0.02)
    assert claim.sigmas > 100.0
    assert any("trade off in these data" in text for text in found.warnings)


def test_noise_far_beyond_the_declared_is_reported():
    """By hand: the same readings with sigmas five times too small."""
    loud = measure(NECK.replace(precurvature=0.3), LOADS, Sensors(camera_sigma=(5e-4, 5e-4, 5e-3)), seed=12)
    noisy = replace(loud, sigma_x=loud.sigma_x / 5.0, sigma_z=loud.sigma_z / 5.0, sigma_theta=loud.sigma_theta / 5.0)
    found, quiet = (diagnose(NECK, data, candidates=["precurvature"], priors=MATERIAL) for data in (noisy, loud))
    assert found.names == quiet.names == ("precurvature",)
    assert any("times as much as the noise that is declared" in text for text in found.warnings)
    assert not any("declared" in text for text in quiet.warnings)
