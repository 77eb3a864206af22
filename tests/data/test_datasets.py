"""The data that ship with the package: their figures as published, and what the model makes of them."""

import csv
from importlib.resources import files

import numpy as np
import pytest

from ecm_fast.data import datasets
from ecm_fast.errors import InputError
from ecm_fast.mechanism.vector import pack
from ecm_fast.models.finite_element import FiniteElementModel
from ecm_fast.models.instruments.prediction import predict

DEFLECTIONS = [0.089, 0.149, 0.195, 0.227, 0.251, 0.268, 0.281]
"""Measured, [m], Belendez, Neipp & Belendez (2003)."""
ELASTICA = [0.0898, 0.1516, 0.1960, 0.2272, 0.2495, 0.2659, 0.2784]
"""The same strip, inextensible and without shear, by integrating its elastica, [m] to four digits."""


def test_every_dataset_has_its_files_and_its_source() -> None:
    """Contract: files, sources, and the mark of simulated data."""
    measured, simulated = datasets.available()[:2], datasets.available()[2:]
    assert measured == ("steel_cantilever", "silicone_cantilever")
    assert len(simulated) == 6
    for name in simulated:
        assert name.startswith("simulated_")
        assert datasets.describe(name).startswith("SIMULATED, nobody measured this.")
    for name in datasets.available():
        folder = files("ecm_fast.data.datasets") / ("measured" if name in measured else "simulated")
        assert (folder / f"{name}.csv").is_file()
        assert (folder / f"{name}.toml").is_file()
    assert "Int. J. Engng Ed. 19 (2003) 885-892" in datasets.describe("steel_cantilever")
    assert "Soft Robotics Lab, ETH Zurich" in datasets.describe("silicone_cantilever")
    assert "NOT made by this program" in datasets.reference_solutions().origin


def test_an_unknown_dataset_is_told_with_the_nearest() -> None:
    """Contract: the text of the error."""
    with pytest.raises(InputError) as caught:
        datasets.load("steel_cantilver")
    text = str(caught.value)
    assert text.startswith("dataset = 'steel_cantilver': allowed is 'steel_cantilever' or 'silicone_cantilever' or ")
    assert text.endswith(" (did you mean 'steel_cantilever'?)")


def test_the_steel_strip_is_the_published_one() -> None:
    """Published: Belendez, Neipp & Belendez 2003, as tabulated there."""
    mechanism, data = datasets.load("steel_cantilever")
    assert (-data.z).tolist() == DEFLECTIONS
    np.testing.assert_allclose(-data.fz, 0.098 * np.arange(7), rtol=0, atol=1e-15)
    assert data.tilt.tolist() == [np.pi / 2] * 7
    assert data.measured.tolist() == [[False, True, False]] * 7
    beam = mechanism.beam
    assert pytest.approx(194.3e9 * 0.025 * 0.0004**3 / 12, rel=2e-6) == beam.EI
    assert beam.mass_per_length * mechanism.gravity.g * beam.length == pytest.approx(0.3032, abs=1e-5)
    assert (beam.length, mechanism.head.mass) == (0.40, 0.0)


def test_the_steel_strip_bends_as_measured() -> None:
    """Published: the authors' own elastica, and their measurements; nothing is fitted."""
    prediction = predict(*datasets.load("steel_cantilever"))
    assert prediction.counts["converged"] == 7
    np.testing.assert_allclose(-prediction.pose[:, 1], ELASTICA, rtol=0, atol=6e-5)  # they are rounded to 1e-4
    assert np.abs(prediction.residual[:, 1]).max() <= 0.007 * 0.40


def test_the_silicone_beam_is_the_published_one() -> None:
    """Published: motion capture of ETH's Soft Robotics Lab, 2021."""
    mechanism, data = datasets.load("silicone_cantilever")
    np.testing.assert_allclose(-1e3 * data.z, [6.3, 16.5, 24.6])
    np.testing.assert_allclose(np.degrees(data.theta), [4.9, 13.8, 24.6])
    np.testing.assert_allclose(data.extra_mass, [0.0, 0.052, 0.101])
    np.testing.assert_allclose(data.tilt, np.pi / 2)
    beam = mechanism.beam
    assert beam.mass_per_length == pytest.approx(1070 * 0.03**2)
    # one modulus in all three stiffnesses: square section, Poisson ratio 0.5, shear factor 5/6
    modulus = beam.EI / (0.03**4 / 12)
    assert modulus == pytest.approx(0.3068e6, rel=1e-4)
    assert pytest.approx(modulus * 0.03**2, rel=1e-4) == beam.EA
    assert pytest.approx(5 / 6 * modulus / 3 * 0.03**2, rel=1e-4) == beam.GA


def test_one_modulus_explains_sag_but_not_rotation() -> None:
    """Published: measured sags and rotations."""
    prediction = predict(*datasets.load("silicone_cantilever"))
    sag, rotation = -1e3 * prediction.pose[:, 1], np.degrees(prediction.pose[:, 2])
    assert sag[0] == pytest.approx(6.3, abs=0.01)
    np.testing.assert_allclose(sag[1:], [16.5, 24.6], rtol=0.10)
    short = [4.9, 13.8, 24.6] - rotation
    assert (np.diff(short) > 1.0).all()  # ever shorter of the measured rotation, as the load grows


def test_another_modulus_gives_what_another_program_found() -> None:
    """Another program: its figures at 0.283 MPa."""
    mechanism, data = datasets.load("silicone_cantilever")
    modulus = 0.283e6
    softer = mechanism.replace(EA=modulus * 9e-4, GA=modulus * 2.5e-4, EI=modulus * 6.75e-8)
    prediction = predict(softer, data)
    np.testing.assert_allclose(-1e3 * prediction.pose[:, 1], [6.8, 16.5, 25.4], rtol=0, atol=0.06)
    np.testing.assert_allclose(np.degrees(prediction.pose[:, 2]), [4.7, 12.7, 20.2], rtol=0, atol=0.06)


def test_one_element_of_order_six_meets_the_reference_solutions() -> None:
    """Shooting: the reference solutions."""
    known = datasets.reference_solutions()
    assert (len(known.loads), known.loads.count("tendons")) == (22, 12)
    assert {mechanism.beam.axial_law for mechanism in known.mechanisms} == {"neo-hookean", "hooke"}
    assert {mechanism.tendons.pulley_radius for mechanism in known.mechanisms} == {0.0, 0.0055}
    par = np.array([pack(mechanism) for mechanism in known.mechanisms])
    found = FiniteElementModel(order=6).solve_batch(known.lam, known.wrench, parameters=par)
    assert found.stable.all()
    np.testing.assert_allclose(found.pose, known.pose, rtol=0, atol=5e-9)


def test_the_reference_solutions_are_for_their_mechanism() -> None:
    """By hand: the numbers of the file's header."""
    beam, tendons = (getattr(datasets.reference_solutions().mechanisms[0], name) for name in ("beam", "tendons"))
    assert (beam.EA, beam.GA, beam.EI) == (7500.0, 2420.0, 3.0)
    assert (tendons.plate_half_width, tendons.pulley_x) == (0.070, 0.0)


def test_the_reference_solutions_are_rows_of_the_tables(table) -> None:
    """The tables of `tests/tables`, from which they were taken."""
    # table: the whole tables from which a few rows ship with the package
    poses = {(row["x_L"], row["z_L"], row["theta_L_rad"]) for row in table("tendon_equilibria")}
    poses |= {(row["x_L_m"], row["z_L_m"], row["theta_L_rad"]) for row in table("paper_beam_dead_tip_wrench")}
    rounded = {tuple(round(value, 15) for value in pose) for pose in poses}
    text = (files("ecm_fast.data.datasets") / "reference_solutions.csv").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    shipped = [tuple(float(row[name]) for name in ("x_m", "z_m", "theta_rad")) for row in csv.DictReader(lines)]
    assert len(set(shipped)) == 22
    assert set(shipped) <= rounded
