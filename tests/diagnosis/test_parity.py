"""Parity tests on the simulated test bed: what is hidden there is known, and the rate of false alarms is binomial."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from ecm_fast.diagnosis.checks.symmetry import parity
from ecm_fast.errors import InputError
from ecm_fast.identification.identify import identify
from ecm_fast.mechanism.mechanism import Mechanism
from ecm_fast.models.instruments.prediction import predict
from ecm_fast.testbed import Sensors, equilibria, measure, readings, shear_test, tendon_test

pytestmark = pytest.mark.slow

GRID = tendon_test(grid=9, replicated=15, replicates=3, seed=3)
NECK = Mechanism()
NOISE = Sensors(force_sigma=0.15)


@pytest.fixture(scope="module")
def clean():
    return equilibria(NECK, GRID).raise_if_failed()


def changed(data, **columns):
    for array in columns.values():
        array.setflags(write=False)
    return replace(data, **columns)


def test_clean_data_raise_no_alarm_more_often_than_allowed(clean) -> None:
    """Binomial: alarms in 50 clean sets."""
    alpha, alarms, runs = 0.05, 0, 50
    for seed in range(runs):
        found = parity(readings(NECK, clean, NOISE, seed), alpha=alpha, seed=seed)
        assert {name for name, test in found.tests.items() if test.p is not None} == {"odd", "path", "drift"}
        alarms += bool(found.verdict)
    assert alarms <= stats.binom.ppf(0.999, runs, alpha)


def test_p_values_of_pure_noise_are_uniform() -> None:
    """Kolmogorov-Smirnov test on 60 sets of pure noise."""
    rng, found = np.random.default_rng(5), []
    for seed in range(60):
        noise = [np.ascontiguousarray(column) for column in (rng.standard_t(3, (GRID.n, 3)) * 1e-4).T]
        silent = changed(GRID, x=noise[0], z=noise[1], theta=noise[2])
        found.append([parity(silent, seed=seed).tests[name].p for name in ("odd", "path", "drift")])
    for p in np.array(found).T:
        assert stats.kstest(p, "uniform").pvalue > 1e-3


@pytest.mark.parametrize("name", ["precurvature", "neutral_axis_offset", "clamp_tilt", "pulley_shift"])
def test_what_differs_left_and_right_is_odd(name) -> None:
    """Mirror symmetry: an odd effect of the test bed."""
    hidden = NECK.replace(**{name: {"precurvature": 0.1, "clamp_tilt": 0.01}.get(name, 1e-3)})
    assert parity(measure(hidden, GRID, NOISE, 1)).verdict == ("odd",)


def test_random_loads_are_paired_too() -> None:
    """Mirror symmetry: an odd effect, and none."""
    loads = tendon_test(300, seed=2)
    assert parity(measure(NECK.replace(clamp_tilt=0.01), loads, NOISE, 1)).verdict == ("odd",)
    assert parity(measure(NECK, loads, NOISE, 1)).verdict == ()


def test_what_is_alike_on_both_sides_shows_against_a_model_alone() -> None:
    """Mirror symmetry: an even effect of the test bed."""
    data = measure(NECK.replace(pulley_spacing=5e-3), GRID, NOISE, 1)
    assert parity(data).verdict == ()
    assert "model" in parity(data).tests["even"].gap
    assert parity(data, predict(NECK, data).residual).verdict == ("even",)


@pytest.mark.parametrize("size", [4e-3, -4e-3])
def test_what_calibration_leaves_of_an_even_law_is_even(size) -> None:
    """EI takes in the part that is linear in the difference of the forces, the one that needs no order of the pairs."""
    data = measure(NECK.replace(bending_cubic=size), GRID, NOISE, 1)
    fitted = identify(NECK, data, ["EA", "GA", "EI"]).mechanism
    assert parity(data, predict(fitted, data).residual).verdict == ("even",)


def test_friction_is_seen_as_path() -> None:
    """By hand: a step of 2 mrad with the direction of travel."""
    data = measure(NECK, tendon_test(grid=6, replicated=36, replicates=3, seed=3), NOISE, 4)
    came = np.sign(np.diff(data.lam_l - data.lam_r, prepend=0.0))
    found = parity(changed(data, theta=data.theta - 2e-3 * came))  # 1 N of dry friction turns the tip so far
    assert found.verdict == ("path",)
    assert found.tests["path"].deviation[2] == pytest.approx(-4e-3, abs=1e-3)  # noise 1.4 mrad over some 30 pairs


def test_a_camera_that_wanders_is_seen_as_drift() -> None:
    """Known truth: a drift of the test bed's camera."""
    loads = tendon_test(grid=6, replicated=36, replicates=3, seed=3)
    found = parity(measure(NECK, loads, replace(NOISE, camera_drift=(0.0, 5e-4, 0.0)), 4))
    assert "drift" in found.verdict
    assert found.tests["drift"].by_channel["z"] < 0.01 < found.tests["drift"].by_channel["theta"]


def test_missing_pairs_are_named() -> None:
    """By hand: loads on one side alone."""
    one_sided = measure(NECK, tendon_test(grid=6, seed=1), NOISE, 1)
    one_sided = one_sided.select(one_sided.lam_l > one_sided.lam_r + 10.0)
    found = parity(one_sided)
    assert found.verdict == ()
    assert "mirrored" in found.tests["odd"].gap
    assert "repeated" in found.tests["drift"].gap
    assert len(found.gaps) == 4
    assert "no test could be answered" in repr(found)


def test_a_channel_that_was_not_measured_is_left_out(clean) -> None:
    """By hand: a blank channel, and z moved by 1 mm."""
    data = readings(NECK, clean, NOISE, 1)
    blank = changed(data, theta=np.full(data.n, np.nan), z=data.z + 1e-3)
    found = parity(blank)
    assert found.verdict == ("odd",)
    assert set(found.tests["odd"].by_channel) == {"x", "z"}
    assert "theta" not in repr(found.tests["odd"])
    nothing = changed(blank, x=np.full(data.n, np.nan), z=np.full(data.n, np.nan))
    assert len(parity(nothing).gaps) == 4


def test_a_side_force_is_mirrored_with_its_sign() -> None:
    """Mirror symmetry: with and without an odd effect."""
    loads = shear_test(np.linspace(-66.0, 66.0, 24))
    assert parity(measure(NECK, loads, NOISE, 1)).verdict == ()
    assert parity(measure(NECK.replace(precurvature=0.2), loads, NOISE, 1)).verdict == ("odd",)


def test_bad_arguments_are_told() -> None:
    """Contract: the text of the error."""
    with pytest.raises(InputError, match="alpha = 2"):
        parity(GRID, alpha=2)
    with pytest.raises(InputError, match=r"\(2, 3\)"):
        parity(GRID, np.zeros((2, 3)))


def test_the_same_seed_gives_the_same_answer(clean) -> None:
    """Contract: the same seed, the same text."""
    data = readings(NECK, clean, NOISE, 2)
    assert repr(parity(data, seed=1)) == repr(parity(data, seed=1))
