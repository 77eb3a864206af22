"""Predictions: shooting solutions reached through the measuring chain, rows against models built by hand."""

import csv
from pathlib import Path

import numpy as np
import pytest

from ecm_fast.data.measurements import Measurements
from ecm_fast.errors import InputError
from ecm_fast.files import csv_text
from ecm_fast.mechanism.mechanism import Mechanism
from ecm_fast.models.finite_element import FiniteElementModel
from ecm_fast.models.instruments.prediction import predict

SHOOTING = [0.103008552345, 0.0230459870741, -0.436074844694]
"""Pose for (160, 0) N with a head of 1 kg at 0.05 m and a beam of 9.471 kg/m, by shooting, to 12 digits."""
TOO_MUCH = 2000.0
"""[N] in one tendon: it pulls its end of the plate up to the pulley."""


def rows(**columns: list[float | None]) -> Measurements:
    return Measurements.from_columns(columns)


def test_head_mass_and_extra_mass_add_up() -> None:
    """Shooting: the table's neck with a head of 1 kg, made of three parts."""
    neck = Mechanism().replace(**{"mass_per_length": 9.471, "head.mass": 0.3, "effects.head_mass": 0.1})
    found = predict(neck, rows(lam_l_N=[160.0], lam_r_N=[0.0], extra_mass_kg=[0.6]), order=6)
    np.testing.assert_allclose(found.pose, [SHOOTING], rtol=0, atol=1e-11)


def test_a_changed_row_is_a_model_with_these_values() -> None:
    """By hand: a model with each row's tilt and mass, solved alone."""
    neck = Mechanism().replace(**{"gravity_tilt": 0.1, "head.b": 0.01})
    data = rows(
        lam_l_N=[40.0, 0.0, 10.0],
        lam_r_N=[0.0, 25.0, 10.0],
        fz_N=[3.0, 0.0, 0.0],
        tau_Nm=[0.0, -0.5, 0.0],
        tilt_rad=[0.3, -0.7, 0.0],
        extra_mass_kg=[0.0, 2.0, 0.5],
    )
    found = predict(neck, data)
    for i, (tilt, mass) in enumerate([(0.4, 1.0), (-0.6, 3.0), (0.1, 1.5)]):
        model = FiniteElementModel(neck.replace(**{"gravity_tilt": tilt, "head.mass": mass}))
        alone = model.solve(data.lam[i], data.wrench[i]).raise_if_failed()
        np.testing.assert_allclose(found.pose[i], alone.pose, rtol=0, atol=1e-12)


def test_the_discretization_and_the_threads_are_passed_on() -> None:
    """Another way in: the model of the same discretization."""
    data = rows(lam_l_N=[160.0, 80.0], lam_r_N=[0.0, 0.0])
    paper = FiniteElementModel(elements=20, order=1).solve((160.0, 0.0)).raise_if_failed()
    found = predict(Mechanism(), data, elements=20, order=1, threads=2)
    np.testing.assert_allclose(found.pose[0], paper.pose, rtol=0, atol=1e-12)


def test_residual_rms_and_rows_count_measured_and_converged() -> None:
    """By hand: the prediction plus known steps."""
    # measured poses are the prediction plus known steps, so rms and rows can be worked out by hand
    clean = predict(Mechanism(), rows(lam_l_N=[30.0, 60.0, 0.0], lam_r_N=[0.0, 0.0, 0.0])).pose
    found = predict(
        Mechanism(),
        rows(
            lam_l_N=[30.0, 60.0, TOO_MUCH],
            lam_r_N=[0.0, 0.0, 0.0],
            x_m=[clean[0, 0] + 3e-3, clean[1, 0] - 4e-3, 0.1],
            theta_rad=[None, clean[1, 2] + 0.02, None],
        ),
    )
    assert found.rms["x_m"] == pytest.approx(np.sqrt((9e-6 + 16e-6) / 2))
    assert found.rms["z_m"] is None
    assert found.rms["theta_rad"] == pytest.approx(0.02)
    assert found.rows == 2
    assert found.counts == {
        "converged": 2,
        "unstable": 0,
        "not_converged": 0,
        "tendon_zero_length": 1,
        "invalid_input": 0,
        "section_unstable": 0,
    }
    np.testing.assert_allclose(found.residual[:2, 0], [3e-3, -4e-3])
    assert np.isnan(found.residual[2]).all()
    assert np.isnan(found.residual[:, 1]).all()
    assert 0.0 < found.load_factor[2] < 1.0
    assert repr(found) == (
        "<Prediction of 3 rows: 2 converged, 1 tendon_zero_length; rms x_m 0.00354, theta_rad 0.02>"
    )  # fmt: skip


def test_the_csv_reads_back_to_the_last_digit(tmp_path: Path) -> None:
    """Round trip through Python's csv module; what is unknown is blank."""
    found = predict(
        Mechanism(),
        rows(lam_l_N=[40.0, TOO_MUCH], lam_r_N=[10.0, 0.1], z_m=[0.01, None], tilt_rad=[1 / 3, 0.0]),
    )
    path = found.to_csv(tmp_path / "out.csv")
    with path.open(encoding="utf-8", newline="") as file:
        first, second = csv.DictReader(file)
    assert list(first) == [
        *("lam_l_N", "lam_r_N", "fx_N", "fz_N", "tau_Nm", "extra_mass_kg", "tilt_rad"),
        *("x_m", "z_m", "theta_rad", "x_measured_m", "z_measured_m", "theta_measured_rad", "status"),
    ]
    assert [float(first[name]) for name in ("x_m", "z_m", "theta_rad")] == found.pose[0].tolist()
    assert (float(first["tilt_rad"]), float(second["lam_r_N"]), float(second["lam_l_N"])) == (1 / 3, 0.1, TOO_MUCH)
    assert (first["z_measured_m"], first["x_measured_m"], first["status"]) == ("0.01", "", "converged")
    blank = ("x_m", "z_m", "theta_rad", "x_measured_m", "z_measured_m", "theta_measured_rad")
    assert {second[name] for name in blank} == {""}
    assert second["status"] == "tendon_zero_length"
    assert "nan" not in path.read_text(encoding="utf-8").lower()


def test_a_tilt_beyond_its_bounds_is_told_with_its_row() -> None:
    """Contract: the text of the error, written by hand."""
    data = rows(lam_l_N=[0.0, 0.0], tilt_rad=[1.0, 6.5])
    with pytest.raises(InputError) as caught:
        predict(Mechanism().replace(gravity_tilt=1.0), data)
    assert str(caught.value) == (
        "measurements: row 2: tilt = 6.5 makes effects.gravity_tilt = 7.5: allowed is a finite number from -7 to 7 rad"
    )


def test_the_text_of_a_csv() -> None:
    """By hand: the text."""
    columns = {"a": [0.1, float("nan")], "b": np.array([1, 2]), "c": ["x, y", None]}
    assert csv_text(columns) == 'a,b,c\n0.1,1,"x, y"\n,2,\n'
