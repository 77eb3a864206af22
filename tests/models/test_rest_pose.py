"""Poses zeroed at rest and tendons that hang slack: simulated readings of the test bed, turned into either."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ecm_fast import Measurements, Mechanism, diagnose, identify, predict, read_measurements
from ecm_fast.data.columns import CHANNELS
from ecm_fast.errors import InputError
from ecm_fast.identification.posterior import posterior
from ecm_fast.mechanism.mesh.discretization import Discretization
from ecm_fast.mechanism.vector import pack
from ecm_fast.models.finite_element import FiniteElementModel
from ecm_fast.models.instruments.measuring_chain import MeasuringChain
from ecm_fast.models.instruments.rest_pose import absolute, free_origins
from ecm_fast.models.polynomial.training import measured_wrenches, training_rows
from ecm_fast.testbed import Sensors, measure, tendon_test

SEEN = {"camera_rotation": 0.02, "camera_scale": 0.01, "marker_lever_x": 4e-3, "camera_x_offset": 2e-3}


def loads(n: int = 24, sessions: int = 1) -> Measurements:
    """Return tendon forces of which the first of each session are a pre-load of 10 N."""
    drawn = tendon_test(n, seed=3)
    at = np.arange(n) % (n // sessions) == 0
    lam = np.where(at[:, None], 10.0, drawn.lam)
    return replace(drawn, lam_l=lam[:, 0].copy(), lam_r=lam[:, 1].copy(),
                   session=(np.arange(n) // (n // sessions)).astype(str))  # fmt: skip


def zeroed(data: Measurements, at: str, rest: np.ndarray) -> Measurements:
    """Return measurements less poses at rest, (3,) or (n, 3)."""
    return replace(data, **dict(zip(CHANNELS, (data.pose - rest).T.copy(), strict=True)), zeroed=at)


@pytest.mark.parametrize("at", ["first", "session", "unloaded"])
def test_predictions_meet_readings_relative_to_rest(at: str) -> None:
    """Test bed: noise-free readings of a camera with every kind of fault, zeroed in each of the three ways."""
    neck = Mechanism.preset("slender").replace(**SEEN)
    data = measure(neck, loads(sessions=3), Sensors.perfect())
    free = measure(neck, Measurements.from_columns({"lam_l_N": [0.0], "lam_r_N": [0.0]}), Sensors.perfect())
    rest = {"first": data.pose[0], "session": data.pose[np.arange(24) // 8 * 8], "unloaded": free.pose[0]}[at]
    given = zeroed(data, at, rest)
    found = predict(neck, given)
    np.testing.assert_allclose(found.data.pose, data.pose, atol=1e-7)
    assert np.abs(found.residual).max() < 1e-7
    assert absolute(neck, found.data) is found.data


def test_a_fit_leaves_the_origins_free() -> None:
    """Linear algebra: differences from a reading tell what absolute readings with free origins tell, no more."""
    true = Mechanism.preset("slender").replace(EI=3.1, camera_rotation=0.01)
    data = measure(true, loads(60), Sensors(), seed=5)
    start = Mechanism.preset("slender").replace(camera_rotation=0.01)
    relative = identify(start, zeroed(data, "first", data.pose[0]), ["EA", "GA", "EI"])
    origins = ["camera_x_offset", "camera_z_offset", "marker_angle_offset"]
    free = identify(start, data, ["EA", "GA", "EI", *origins])
    for name in ("EA", "GA", "EI"):
        assert relative[name].value == pytest.approx(free[name].value, rel=1e-5)
        assert relative[name].std == pytest.approx(free[name].std, rel=1e-3)
    assert abs(relative["EI"].value - 3.1) < 4.0 * relative["EI"].std


@pytest.mark.slow
def test_other_uses_of_poses_add_the_rest_pose() -> None:
    """Consistency: the wrenches at poses, and the sampled mean beside the fit's value."""
    neck = Mechanism.preset("slender")
    data = measure(neck, loads(40), Sensors(), seed=5)
    given, model = zeroed(data, "first", data.pose[0]), FiniteElementModel(neck)
    shifted = replace(data, **dict(zip(CHANNELS, (given.pose + predict(neck, data).pose[0]).T.copy(), strict=True)))
    np.testing.assert_allclose(measured_wrenches(model, given), measured_wrenches(model, shifted), rtol=1e-9)
    np.testing.assert_allclose(training_rows(model, given).poses, shifted.pose, rtol=1e-9)
    pytest.importorskip("emcee")
    found, fit = posterior(neck, given, ["EI"], steps=400, seed=1), identify(neck, given, ["EI"])
    assert found.names == ("EI", *free_origins([replace(given, zeroed="added")]))
    assert abs(found.samples[:, 0].mean() - fit["EI"].value) < 0.3 * fit["EI"].std
    assert 0.8 < found.samples[:, 0].std() / fit["EI"].std < 1.2


def test_a_diagnosis_leaves_the_origins_free() -> None:
    """Test bed: a camera whose origin is off and a neck curved by itself, zeroed at each session's first row."""
    true = Mechanism.preset("slender").replace(camera_x_offset=1e-3, precurvature=0.3)
    data = measure(true, loads(90, 3), Sensors(force_sigma=0.2), seed=5)
    found = diagnose(Mechanism.preset("slender"), zeroed(data, "session", data.pose[np.arange(90) // 30 * 30]))
    assert found.sentence.startswith("The data ask for precurvature = 0.3")
    named = {name for model in found.to_json_dict()["models"] for name in model["names"]}
    assert not named & {"camera_x_offset", "camera_z_offset", "marker_angle_offset"}


def test_what_cannot_be_zeroed(tmp_path: Path) -> None:
    """By hand: the texts of the errors."""
    neck = Mechanism.preset("slender")
    data = measure(neck, loads(8), Sensors.perfect())
    with pytest.raises(InputError, match=r"x is 10\d\.\d* mm, though the poses are told to be zeroed there \(first\)"):
        predict(neck, replace(data, zeroed="first"))
    with pytest.raises(InputError, match=r"its poses are zeroed at rest, those of .* are not; all or none"):
        free_origins([replace(data, zeroed="added"), data])
    (tmp_path / "run.csv").write_text("x_mm\n1\n")
    (tmp_path / "map.toml").write_text("zeroed = 'rest'")
    with pytest.raises(InputError, match="zeroed = 'rest': allowed is first, session, unloaded"):
        read_measurements(tmp_path / "run.csv", tmp_path / "map.toml")


def slack_rows() -> Measurements:
    data = Measurements.from_columns({"lam_l_N": [40.0, 0.0, 60.0, 0.0], "lam_r_N": [10.0, 50.0, 0.0, 0.0]})
    return replace(data, slack=0.5)


def test_a_slack_tendon_pulls_nothing() -> None:
    """Independent: the test bed under the forces themselves, 0 where slack and 3 N above the reading elsewhere."""
    data = slack_rows()
    forces = np.where(data.lam == 0.0, 0.0, data.lam + 3.0)
    exact = measure(Mechanism(), Measurements.from_columns({"lam_l_N": forces[:, 0], "lam_r_N": forces[:, 1]}),
                    Sensors.perfect())  # fmt: skip
    neck = Mechanism().replace(force_zero=3.0)
    np.testing.assert_allclose(predict(neck, data).pose, exact.pose, atol=1e-7)
    assert np.abs(predict(neck, replace(data, slack=np.nan)).pose - exact.pose).max() > 1e-4


@pytest.mark.slow
def test_a_fit_and_a_diagnosis_respect_slack_tendons() -> None:
    """Test bed: cells 3 N low where a tendon is taut, zero where it hangs, in a third of the rows of each."""
    drawn = tendon_test(60, seed=2)
    lam = np.where(np.random.default_rng(1).uniform(size=(60, 2)) < 0.33, 0.0, drawn.lam + 10.0)
    data = measure(Mechanism(), replace(drawn, lam_l=lam[:, 0].copy(), lam_r=lam[:, 1].copy()), Sensors(), seed=4)
    read = np.where(lam == 0.0, 0.0, lam - 3.0)
    data = replace(data, lam_l=read[:, 0].copy(), lam_r=read[:, 1].copy(), slack=0.0)
    fit = identify(Mechanism(), data, ["EI", "force_zero"])
    assert abs(fit["force_zero"].value - 3.0) < 4.0 * fit["force_zero"].std
    found = {tuple(model["names"]): model for model in diagnose(Mechanism(), data).to_json_dict()["models"]}
    assert found[("force_zero",)]["in_set"]


def test_derivatives_respect_slack_tendons() -> None:
    """Central differences: the readings by the zeros and the crosstalk of the cells, and by the forces."""
    data, mesh = slack_rows(), Discretization.from_elements(3, 5)
    names = ["force_zero", "force_zero_asymmetry", "force_crosstalk", "EI"]
    neck = Mechanism().replace(force_zero=2.0, force_zero_asymmetry=1.0, force_crosstalk=0.01)
    chain = MeasuringChain(mesh, data)
    found = chain.sensitivities(names, pack(neck), 1e-24)
    for i, (name, step) in enumerate(zip(names, (1e-3, 1e-3, 1e-5, 1e-5), strict=True)):
        value = {"force_zero": 2.0, "force_zero_asymmetry": 1.0, "force_crosstalk": 0.01, "EI": neck.beam.EI}[name]
        up, down = (chain.solve(pack(neck.replace(**{name: value + sign * step})), 1e-24)[0] for sign in (1.0, -1.0))
        np.testing.assert_allclose(found.dpose_dpar[:, :, i], (up - down) / (2.0 * step), rtol=1e-5, atol=1e-8)
    assert not found.jacobian[data.lam[:, 0] == 0.0, :, 0].any()
    assert found.jacobian[data.lam[:, 0] > 0.0, :, 0].all(axis=1).all()


def test_small_readings_are_those_of_slack_tendons(tmp_path: Path) -> None:
    """By hand: readings either side of zero."""
    path = tmp_path / "run.csv"
    path.write_text("lam_l_N,lam_r_N\n0.3,40\n-0.4,5\n20,-0.6\n")
    with pytest.raises(InputError, match=r"line 4, column lam_r_N: '-0\.6' \(allowed is a finite number >= -0\.5\)"):
        _read(path, 0.5)
    run = _read(path, 0.6)
    assert run.lam.tolist() == [[0.0, 40.0], [0.0, 5.0], [20.0, 0.0]]
    assert run.hanging.tolist() == [[True, False], [True, False], [False, True]]
    assert not run.select([0]).hanging[0, 1]


def _read(path: Path, slack: float) -> Measurements:
    (path.parent / "map.toml").write_text(f"slack = {slack}")
    return read_measurements(path, path.parent / "map.toml")
