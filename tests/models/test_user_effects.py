"""Effects that a user adds at run time, against twins in the catalogue and against differences."""

import json
from pathlib import Path

import numpy as np
import pytest

import ecm_fast as ecm
from ecm_fast.__main__ import main
from ecm_fast.mechanism.vector import pack, unpack

NECK = ecm.Mechanism.preset("slender")
LAM = np.random.default_rng(0).uniform(0.0, 160.0, (12, 2))


def cubic(a, gamma_x, gamma_z, kappa, place):
    return 0.0, 0.0, 3.0 * a * kappa * kappa * kappa


def spring(a, x, z, theta):
    return 0.0, 0.0, -a * theta


def stop(a, angle, x, z, theta):
    return 0.0, 0.0, -a * (theta - angle) if theta.real > angle.real else 0.0 * theta


@pytest.fixture
def add():
    """Return a function that adds an effect for the length of a test."""
    added = []

    def effect(name, *more, **entry):
        def register(law):
            ecm.effect(name, *more, **{"unit": "-", "typical": 1e-3, **entry})(law)
            added.append(name)

        return register

    yield effect
    for name in added:
        ecm.remove_effect(name)


def poses(**changes):
    result = ecm.FiniteElementModel(NECK.replace(**changes)).solve_batch(LAM, tolerance=1e-13)
    assert result.stable.all()
    return result.pose


def test_a_section_law_is_its_twin_of_the_catalogue(add):
    """The catalogue: M = EI kappa (1 + a kappa^2) written by a user, its poses and its derivative by the size."""
    add("own_cubic", enters="section", typical=0.004)(cubic)
    assert np.abs(poses(own_cubic=0.006) - poses(bending_cubic=0.006)).max() < 1e-13
    by = ecm.FiniteElementModel(NECK).sensitivities(["own_cubic", "bending_cubic"], LAM).dpose_dpar
    assert np.abs(by[:, :, 0] - by[:, :, 1]).max() < 1e-12 * np.abs(by).max()


@pytest.mark.slow
def test_a_head_law_is_its_twin_of_the_catalogue(add):
    """The catalogue: a rotational spring, and a stop with a further parameter, by solver and control step."""
    add("own_spring", enters="head", typical=0.2)(spring)
    add("own_stop", ecm.also("angle", "rad", "where it begins", 0.2, (0.0, 1.0), 0.1), enters="head")(stop)
    assert np.abs(poses(own_spring=0.4) - poses(rotational_spring=0.4)).max() < 1e-12
    twin = {"contact_stop_one_sided.stiffness": 5.0, "contact_stop_one_sided.angle": 0.1}
    assert np.abs(poses(**{"own_stop.size": 0.05, "own_stop.angle": 0.1}) - poses()).max() > 1e-6
    own = ecm.FiniteElementModel(NECK.replace(**{"own_stop.size": 0.1, "own_stop.angle": 0.1}))
    assert np.abs(np.array(own.stepper()(20.0, 120.0)[:3]) - own.solve((20.0, 120.0)).pose).max() < 1e-10
    other = ecm.FiniteElementModel(NECK.replace(**{**twin, "contact_stop_one_sided.stiffness": 0.1}))
    assert np.abs(own.solve((20.0, 120.0)).pose - other.solve((20.0, 120.0)).pose).max() < 1e-12


def test_a_law_of_rows_is_its_twin_of_the_catalogue(add):
    """The catalogue: a camera that drifts, predicted and differentiated."""
    add("own_drift", enters="rows", mirror="path")(lambda a, rows: {"camera_z_offset": a * rows.hours})
    data = ecm.Measurements.from_columns({"lam_l_N": LAM[:, 0], "lam_r_N": LAM[:, 1], "t_s": 600.0 * np.arange(12)})
    own, twin = ecm.predict(NECK.replace(own_drift=1e-3), data), ecm.predict(NECK.replace(camera_drift_z=1e-3), data)
    assert np.array_equal(own.pose, twin.pose)
    assert np.abs(own.pose - ecm.predict(NECK, data).pose).max() > 1e-3


def test_it_is_absent_at_zero_and_takes_part_in_files(add, tmp_path):
    """Bit for bit: the poses of a neck that does not know it; the file and the vector give it back."""
    before = poses()
    add("own_cubic", enters="section", typical=0.004)(cubic)
    assert np.array_equal(poses(), before)
    neck = NECK.replace(own_cubic=0.003, creep=0.01)
    neck.to_toml(tmp_path / "neck.toml")
    assert ecm.Mechanism.from_toml(tmp_path / "neck.toml") == neck
    assert unpack(pack(neck)) == neck


@pytest.mark.slow
def test_it_is_gone_when_removed(add):
    """The others keep their laws when places in the vector move."""
    ecm.effect("own_cubic", unit="m^2", typical=0.004, enters="section")(cubic)
    add("own_spring", enters="head", typical=0.2)(spring)
    with_both = poses(own_spring=0.4)
    ecm.remove_effect("own_cubic")
    assert np.abs(poses(own_spring=0.4) - with_both).max() < 1e-13
    with pytest.raises(ecm.InputError, match="no parameter is called 'own_cubic'"):
        NECK.replace(own_cubic=0.1)
    with pytest.raises(ecm.InputError, match="no effect that was added"):
        ecm.remove_effect("own_cubic")


@pytest.mark.parametrize(
    ("name", "enters", "law", "message"),
    [
        ("clamp_tilt", "head", spring, "exists already"),
        ("Own", "head", spring, "small letters"),
        ("own", "plate", spring, "enters = 'plate'"),
        ("own", "head", lambda a, x, z, theta: (a * z, 0.0, 0.0), "a law needs an energy"),
        ("own", "head", lambda a, x, z, theta: (0.0, 0.0, -theta), "must vanish"),
    ],
)
def test_what_cannot_be_an_effect_is_refused(name, enters, law, message):
    """One error with the cure, and nothing is left behind."""
    parameters = list(ecm.PARAMETERS)
    with pytest.raises(ecm.InputError, match=message):
        ecm.effect(name, unit="-", typical=1.0, enters=enters)(law)
    assert parameters == ecm.PARAMETERS


@pytest.mark.parametrize(
    ("scale", "value"), [("typical", 0.0), ("typical", np.nan), ("tolerance", -1.0), ("tolerance", np.nan)]
)
def test_scales_that_cannot_be_are_refused(scale, value):
    """Contract: the text of the error."""
    with pytest.raises(ecm.InputError, match=f"{scale} = {value}: allowed is a finite number"):
        ecm.effect("own", unit="-", enters="head", **{"typical": 1.0, "bounds": (-1.0, 1.0), scale: value})(spring)


@pytest.mark.slow
def test_its_tolerance_counts_as_those_of_the_catalogue(add):
    """Two of one law: what is in a build as drawn adds its variance to that of the measured size."""
    add("own_spring", enters="head", typical=0.2)(spring)
    add("drawn_spring", enters="head", typical=0.2, tolerance=0.05)(spring)
    data, _ = ecm.hide(design="T", seed=1)
    (alone,), (drawn,) = (ecm.plan(NECK, data, candidates=[name]).sights for name in ("own_spring", "drawn_spring"))
    (free,) = ecm.plan(NECK, data, candidates=["own_spring"], uncertain={"drawn_spring": 1e-9}).sights
    expected = free.sigmas / np.hypot(1.0, free.sigmas * 0.05 / 0.2)
    assert [alone.sigmas, drawn.sigmas] == pytest.approx([expected, expected], rel=0.01)


def test_the_command_line_takes_a_file_of_effects(tmp_path, monkeypatch, capsys):
    """Every command: the file adds the effect, the mechanism has it, the prediction feels it."""
    monkeypatch.chdir(tmp_path)
    Path("own.py").write_text(
        "import ecm_fast as ecm\n"
        "@ecm.effect('own_spring', unit='N m', typical=0.2, enters='head')\n"
        "def own_spring(a, x, z, theta):\n"
        "    return 0.0, 0.0, -a * theta\n"
    )
    Path("neck.toml").write_text("[effects]\nown_spring = 0.4\n")
    solve = ["solve", "--tendons", "20", "120", "--mechanism", "neck.toml", "--json", "--plugin"]
    assert main([*solve, "own.py"]) == 0
    assert json.loads(capsys.readouterr().out)["theta"] == pytest.approx(
        ecm.FiniteElementModel(NECK.replace(rotational_spring=0.4)).solve((20.0, 120.0)).theta, rel=1e-10
    )
    ecm.remove_effect("own_spring")
    Path("wrong.py").write_text("1 / 0\n")
    for name, message in (("wrong.py", "wrong.py: ZeroDivisionError: division by zero"), ("no.py", "no.py: ")):
        assert main([*solve, name]) == 2
        assert capsys.readouterr().err.startswith(f"ecm-fast: {message}")
