"""Laws as they occur: what each variant of the test bed changes is known from its law."""

import numpy as np
import pytest

from ecm_fast import Mechanism, hide
from ecm_fast.errors import InputError
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.testbed import VARIANTS, Sensors, measure, shear_test, tendon_test
from ecm_fast.testbed.sealed.ground_truth import Truth

LOADS = tendon_test(grid=4, seed=1)
SIGMA = np.array([1e-4, 1e-4, 1e-3])


def poses(name, size, variant="", share=1.0, loads=LOADS):
    """Return noise-free readings with an effect of some typical sizes."""
    entry = CATALOGUE[name].size
    built = Mechanism().replace(**{entry.name: size * entry.typical})
    return measure(built, loads, Sensors.perfect(), hidden={variant: share} if variant else None).pose


PAIRS = [(variant, name) for variant, entry in VARIANTS.items() for name in entry.effects]


@pytest.mark.slow
@pytest.mark.parametrize(("variant", "name"), PAIRS, ids=lambda value: value)
def test_a_variant_changes_the_law_of_its_effect_alone(variant, name):
    """Definition: nothing without the effect or with no share of the variant; else more than rounding."""
    np.testing.assert_array_equal(poses(name, 1.0, variant, 0.0), poses(name, 1.0))
    np.testing.assert_allclose(poses(name, 0.0, variant), poses(name, 0.0), atol=1e-12)
    assert np.abs(poses(name, 1.0, variant) - poses(name, 1.0)).max() > 1e-8


@pytest.mark.parametrize("name", VARIANTS["zeroed_at_rest"].effects)
def test_a_zeroed_camera_shows_the_straight_neck_at_rest(name):
    """Truth: a weightless neck without load is straight, and so it is shown whatever the camera does."""
    neck = Mechanism().replace(**{name: CATALOGUE[name].size.typical, "g": 0.0})
    shown = measure(neck, shear_test([0.0]), Sensors.perfect(), hidden={"zeroed_at_rest": 1.0}).pose[0]
    np.testing.assert_allclose(shown, [neck.length, 0.0, 0.0], atol=1e-12)


def test_a_camera_that_turns_about_the_marker_keeps_its_place():
    """Closed form: at rest the angle alone is turned."""
    neck = Mechanism().replace(camera_rotation=0.02, g=0.0)
    shown = measure(neck, shear_test([0.0]), Sensors.perfect(), hidden={"turned_about_marker": 1.0}).pose[0]
    np.testing.assert_allclose(shown, [neck.length, 0.0, 0.02], atol=1e-12)


def test_a_slack_spring_does_nothing_within_its_way():
    """Truth: the neck without the spring, where the head is less than 3 mm aside."""
    loads = shear_test([-2.0, 0.0, 2.0])
    near = poses("lateral_spring", 1.0, "spring_slack", loads=loads)
    assert np.abs(near[:, 1]).max() < 3e-3
    np.testing.assert_allclose(near, poses("lateral_spring", 0.0, loads=loads), atol=1e-12)


def test_a_variant_without_its_effect_is_refused():
    """Contract: the error names the effects whose law it is, or the variants there are."""
    with pytest.raises(InputError, match="is a law of contact_stop and contact_stop_one_sided"):
        hide(effects={"precurvature": 0.1}, variant="soft_onset")
    with pytest.raises(InputError, match="did you mean 'soft_onset'"):
        hide(effects={"contact_stop": None}, variant="soft_onsett")


def test_the_truth_names_its_variant(tmp_path):
    """Round trip; a truth written before there were variants is read, too."""
    truth = Truth({"precurvature": 0.1}, variant="cast_below")
    assert Truth.from_json(truth.to_json(tmp_path / "t.json")) == truth
    old = (tmp_path / "t.json").read_text().replace(',\n "variant": "cast_below"', "")
    (tmp_path / "old.json").write_text(old)
    assert Truth.from_json(tmp_path / "old.json").variant == ""
