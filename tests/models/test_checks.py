"""Checks of measurements: each fault is made by hand in simulated data; clean data give no finding."""

import numpy as np
import pytest

import ecm_fast as ecm
from ecm_fast.data import datasets
from ecm_fast.data.measurements import Measurements
from ecm_fast.diagnosis.checks.coverage import coverage
from ecm_fast.errors import InputError
from ecm_fast.mechanism.mechanism import Mechanism
from ecm_fast.models.instruments.checks.checks import check, faults
from ecm_fast.models.instruments.checks.matched_rows import smooth
from ecm_fast.testbed import Sensors, compression_test, in_sequence, measure, shear_test, tendon_test

pytestmark = pytest.mark.slow

NECK = Mechanism()


@pytest.fixture(scope="module")
def plain():
    return measure(NECK, tendon_test(80, seed=1), Sensors(force_sigma=0.1), 1)


def columns(data, **changes):
    """Return the measurements with some columns renamed or changed: new name = (quantity, factor, offset)."""
    names = {"lam_l_N": "lam_l", "lam_r_N": "lam_r", "fz_N": "fz", "x_m": "x", "z_m": "z", "theta_rad": "theta"}
    table = {name: getattr(data, quantity) for name, quantity in names.items()}
    extra = {"t_s": data.t, "dwell_s": data.dwell, "pose_id": data.pose_id, "sigma_lam_N": data.sigma_lam}
    for name, (quantity, factor, offset) in changes.items():
        table = {known: values for known, values in table.items() if names[known] != quantity} | {
            name: factor * table.get(name, getattr(data, quantity)) + offset
        }
        names[name] = quantity
    return Measurements.from_columns({**table, **extra}, source="run.csv")


def kinds(mechanism, data):
    return [finding.kind for finding in [*faults(mechanism, data), *coverage(data)]]


@pytest.mark.parametrize("name", [name for name in datasets.available() if name.startswith("simulated_")])
def test_nothing_is_refused_that_ships(name) -> None:
    """Known good data: the bundled sets."""
    check(*datasets.load(name))


def test_good_data_raise_no_finding(plain) -> None:
    """Known good data of the test bed."""
    assert kinds(NECK, plain) == []


@pytest.mark.parametrize(
    "hidden",
    [
        {"precurvature": 0.4},
        {"pulley_shift": 4e-3, "EI": 2.7},
        {"clamp_tilt": 0.02, "GA": 2000.0},
        {"neutral_axis_offset": 2e-3},
        {"EA": 6000.0, "EI": 3.5},
    ],
)
def test_effects_of_twice_their_typical_size_are_no_wrong_label(hidden) -> None:
    """Known truth: labels are right, effects are large."""
    data = measure(NECK.replace(**hidden), tendon_test(80, seed=1), Sensors(force_sigma=0.1), 1)
    assert not [finding for finding in faults(NECK, data) if finding.certain]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"x_m": ("x", 1e3, 0.0)}, r"x_m: the median is 10\d where the model says 0.10\d; .* label it x_mm"),
        ({"z_m": ("z", 1e3, 0.0)}, "z_m: .* millimetres; label it z_mm"),
        ({"z_mm": ("z", 1.0, 0.0)}, "z_mm: .* metres; label it z_m"),
        ({"x_cm": ("x", 1e3, 0.0)}, "x_cm: .* millimetres; label it x_mm"),
        ({"x_m": ("x", 1e3, 0.0), "theta_rad": ("theta", 180 / np.pi, 0.0)}, "label it x_mm.*label it theta_deg"),
        ({"theta_rad": ("theta", 180 / np.pi, 0.0)}, "theta_rad: .* degrees; label it theta_deg"),
        ({"theta_deg": ("theta", 1.0, 0.0)}, "theta_deg: .* radians; label it theta_rad"),
        ({"lam_l_N": ("lam_l", 1 / 9.81, 0.0), "lam_r_N": ("lam_r", 1 / 9.81, 0.0)}, "hold kgf; label them lam_l_kgf"),
        ({"lam_l_N": ("lam_l", 1e-3, 0.0), "lam_r_N": ("lam_r", 1e-3, 0.0)}, "hold kN; label them lam_l_kN"),
        ({"lam_l_N": ("lam_r", 1.0, 0.0)}, "lam_l_N"),
        ({"z_m": ("z", -1.0, 0.0)}, "z_m: its sign is the opposite"),
        ({"theta_rad": ("theta", -1.0, 0.0)}, "theta_rad: its sign is the opposite"),
        ({"x_m": ("x", 1.0, -0.109)}, "x_m: the readings lie -109 mm from the model.*take -109 mm off"),
        ({"z_m": ("z", 1.0, 0.03)}, r"z_m: the readings lie \+(29\.9|30).* mm from the model"),
        ({"theta_rad": ("theta", 1.0, np.pi / 2)}, "theta_rad: the readings lie .*15[67].* mrad"),
    ],
)
def test_a_wrong_label_is_named_with_its_cure(plain, changes, message) -> None:
    """By hand: one column spoilt, and the text of its cure."""
    if changes == {"lam_l_N": ("lam_r", 1.0, 0.0)}:
        swapped = {"lam_l_N": plain.lam_r, "lam_r_N": plain.lam_l, "x_m": plain.x, "z_m": plain.z}
        data = Measurements.from_columns({**swapped, "theta_rad": plain.theta}, source="run.csv")
        message = "run.csv: .* swapped; exchange the columns lam_l_N and lam_r_N, or mirror both z and theta"
    else:
        data = columns(plain, **changes)
    with pytest.raises(InputError, match=message) as caught:
        check(NECK, data)
    assert "\n" not in str(caught.value)


def test_side_forces_tell_swapped_tendons_from_mirrored_axes() -> None:
    """By hand: both axes mirrored."""
    both = in_sequence(tendon_test(60, seed=1), shear_test(np.linspace(-60.0, 60.0, 30)))
    data = measure(NECK, both, Sensors(), 1)
    mirrored = columns(data, z_m=("z", -1.0, 0.0), theta_rad=("theta", -1.0, 0.0))
    assert kinds(NECK, mirrored)[:2] == ["mirrored", "mirrored"]


def test_another_neck_is_asked_about_and_not_blamed_on_a_unit(plain) -> None:
    """Known truth: right units, another mechanism."""
    found = faults(Mechanism.preset("paper"), plain)
    assert not [finding for finding in found if finding.kind == "unit"]
    assert any("mechanism file" in finding.cure or finding.kind == "origin" for finding in found)


def test_outliers_are_named_by_row(plain) -> None:
    """By hand: two rows moved by 3 mm."""
    z = plain.z.copy()
    z[[7, 41]] += 3e-3
    data = columns(plain, z_m=("z", 0.0, z))
    found = check(NECK, data)
    assert found.outliers == (data.rows[7], data.rows[41])
    assert f"rows {data.rows[7]}, {data.rows[41]}" in repr(found)


def test_outliers_are_told_from_a_missing_effect() -> None:
    """Known truth: an effect and no outlier."""
    data = measure(NECK.replace(precurvature=0.2, EI=2.8), tendon_test(150, seed=1), Sensors(), 1)
    assert check(NECK, data).outliers == ()


def test_a_camera_that_stands_still_is_noticed(plain) -> None:
    """By hand: repeated poses."""
    still = columns(plain, x_m=("x", 0.0, 0.1), z_m=("z", 0.0, 0.0), theta_rad=("theta", 0.0, 0.0))
    with pytest.raises(InputError, match="all 80 poses are the same"):
        check(NECK, still)
    pose = plain.pose.copy()
    pose[20:26] = pose[20]
    data = columns(plain, x_m=("x", 0.0, pose[:, 0]), z_m=("z", 0.0, pose[:, 1]), theta_rad=("theta", 0.0, pose[:, 2]))
    (stuck,) = [finding for finding in faults(NECK, data) if finding.kind == "stuck"]
    assert stuck.rows == tuple(data.rows[20:26])


def test_what_loads_cannot_tell_is_said(plain) -> None:
    """By hand: selections of rows."""
    right = plain.select(plain.lam_l < plain.lam_r)
    assert "one-sided" in kinds(NECK, right)
    alone = columns(plain.select(plain.lam_r < 20.0), lam_r_N=("lam_r", 0.0, 0.0))
    assert "one tendon" in kinds(NECK, alone)
    assert "few rows" in kinds(NECK, plain.select(np.arange(8)))
    same = columns(plain, lam_l_N=("lam_l", 0.0, 20.0), lam_r_N=("lam_r", 0.0, 20.0))
    assert "equal loads" in kinds(NECK, same)


def test_missing_columns_name_what_cannot_be_told(plain) -> None:
    """By hand: columns left out."""
    bare = {"lam_l_N": plain.lam_l, "lam_r_N": plain.lam_r, "x_m": plain.x, "z_m": plain.z}
    text = " ".join(map(str, coverage(Measurements.from_columns(bare))))
    for words in ("t_s", "stiffness_drift", "dwell_s", "creep", "theta_rad", "pose_id", "sigma_lam_N"):
        assert words in text
    blank = {"lam_l_N": plain.lam_l, "x_m": [None] * plain.n}
    with pytest.raises(InputError, match="no row holds a measured pose"):
        check(NECK, Measurements.from_columns(blank))


def test_thirty_thousand_rows_are_checked(plain) -> None:
    """By hand: 375 copies of 80 rows."""
    lam = np.tile(plain.lam, (375, 1))
    pose = np.tile(plain.pose, (375, 1)) + 1e-5 * np.random.default_rng(1).standard_normal((30000, 3))
    table = dict(zip(("lam_l_N", "lam_r_N", "x_m", "z_m", "theta_rad"), np.column_stack([lam, pose]).T, strict=True))
    data = Measurements.from_columns(table)
    assert "many rows" in kinds(NECK, data)


def test_rows_that_are_not_in_the_order_of_measurement_are_said(plain) -> None:
    """Sorted by a force, time stamps intact: friction and memory could not be told any more."""
    data = plain.select(np.argsort(plain.lam_l, kind="stable"))
    found = next(finding for finding in faults(NECK, data) if finding.kind == "order")
    assert len(found.rows) == int((np.diff(data.t) < 0.0).sum()) > 10
    assert "sort them by t_s" in str(found)
    assert "order" not in kinds(NECK, plain.select(np.arange(0, plain.n, 2)))


def forces(data, factor):
    """Return measurements whose force columns hold another unit than they say."""
    return columns(data, lam_l_N=("lam_l", factor, 0.0), lam_r_N=("lam_r", factor, 0.0))


@pytest.mark.parametrize(
    ("unit", "newtons"), [("gf", 9.80665e-3), ("kgf", 9.80665), ("lbf", 4.4482216152605)], ids=["gf", "kgf", "lbf"]
)
def test_forces_in_another_unit_are_blamed_on_the_forces(plain, unit, newtons) -> None:
    """Grams-force labelled N were told as z ten times too large, and obeying left no row with an equilibrium."""
    certain = [finding for finding in faults(NECK, forces(plain, 1.0 / newtons)) if finding.certain]
    assert [finding.kind for finding in certain] == ["unit"]
    assert f"lam_l_N, lam_r_N: the neck bends as under {newtons:.4g} times" in certain[0].sentence
    assert certain[0].cure == f"the columns hold {unit}; label them lam_l_{unit} and lam_r_{unit}"


@pytest.mark.parametrize(
    ("zero", "message"), [(0.109, "head of the straight neck, 109.0 mm"), (0.1088, "neck at rest, 108.8")]
)
def test_a_frame_set_to_zero_at_rest_is_recognized(zero, message) -> None:
    """With EA 6 % off the median row lay 109.2 mm away; what was taken off x is what the cure puts back."""
    data = measure(NECK.replace(EA=1.06 * NECK.beam.EA), tendon_test(80, seed=1), Sensors(force_sigma=0.1), 1)
    at_rest = NECK.beam.length - 0.109 * 9.80665 * (1.0 + 0.5 * 9.47 * 0.109) / (1.06 * NECK.beam.EA)
    assert at_rest == pytest.approx(
        0.1088, abs=2e-5
    )  # L (1 - (m + rho L/2) g / EA): the closed form of pure compression
    (finding,) = [entry for entry in faults(NECK, columns(data, x_m=("x", 1.0, -zero))) if entry.certain]
    assert f"x was set to zero {'at' if zero == 0.109 else 'with'} the {message}" in finding.cure
    assert f"take -{1e3 * zero:.4g} mm off" in finding.cure


def test_a_wrong_axial_stiffness_is_no_origin() -> None:
    """An x that was fine was told to be 0.24 mm off; what calibration explains needs no cure."""
    for share in (0.94, 1.06):
        data = measure(NECK.replace(EA=share * NECK.beam.EA), tendon_test(80, seed=1), Sensors(force_sigma=0.1), 1)
        assert faults(NECK, data) == []


def test_columns_of_x_and_z_exchanged_are_named(plain) -> None:
    """Known truth: the two columns were exchanged by hand."""
    data = columns(plain, x_m=("x", 0.0, plain.z), z_m=("z", 0.0, plain.x))
    (finding,) = [entry for entry in faults(NECK, data) if entry.certain]
    assert finding.cure == "exchange the columns x_m and z_m"


def test_side_forces_in_another_unit_or_sign_are_named() -> None:
    """Known truth: one column was changed by hand, by a sign and by 9.80665 N/kgf."""
    both = in_sequence(tendon_test(60, seed=1), shear_test(np.linspace(-60.0, 60.0, 30)))
    data = measure(NECK, both, Sensors(), 1)
    for factor, message in ((-1.0, "turn the sign of fz_N"), (1.0 / 9.80665, "holds kgf; label it fz_kgf")):
        (finding,) = [entry for entry in faults(NECK, columns(data, fz_N=("fz", factor, 0.0))) if entry.certain]
        assert message in finding.cure


WRONG = [
    ({"theta_rad": ("theta", -1.0, 0.0)}, "turn the sign of theta_rad"),
    ({"theta_rad": ("theta", 180.0 / np.pi, 0.0)}, "label it theta_deg"),
    ({"z_m": ("z", 1e3, 0.0)}, "label it z_mm"),
]


@pytest.mark.parametrize(("changes", "cure"), WRONG, ids=["sign", "degrees", "millimetres"])
def test_every_command_has_the_same_checks(plain, changes, cure) -> None:
    """`identify` gave EI 0.01742 +- 0.00011 for theta with its sign turned, `predict` rms 0.19 rad, without a word."""
    data = columns(plain, **changes)
    for command in (ecm.Study(NECK, data).check, lambda: ecm.diagnose(NECK, data),
                    lambda: ecm.identify(NECK, data, ["EA", "GA", "EI"])):  # fmt: skip
        with pytest.raises(InputError, match=cure):
            command()
    found = ecm.predict(NECK, data)
    assert cure in found.warnings[0]
    assert cure in repr(found)


def test_what_a_fit_is_asked_for_is_no_wrong_label(plain) -> None:
    """A camera 30 mm off is an origin to the checks, and a parameter to a fit that has it."""
    data = columns(plain, z_m=("z", 1.0, 0.03))
    with pytest.raises(InputError, match="z_m: the readings lie"):
        ecm.identify(NECK, data, ["EI"])
    fit = ecm.identify(NECK, data, ["EI", "camera_z_offset"])
    assert fit["camera_z_offset"].value == pytest.approx(0.03, abs=1e-4)


def test_a_stiffness_of_which_nothing_is_known_is_fitted(plain) -> None:
    """Forces of another unit would explain a neck that is ten times too stiff as well; EI is what is asked."""
    fit = ecm.identify(NECK.replace(EA=75000.0, GA=24200.0, EI=30.0), plain, ["EA", "GA", "EI"])
    assert fit["EI"].value == pytest.approx(3.0, rel=0.01)


def test_a_channel_that_stands_still_is_refused(plain) -> None:
    """Known truth: the column was overwritten; a neck that is only pushed keeps its z, and that is no fault."""
    still = columns(plain, theta_rad=("theta", 0.0, 0.0))
    with pytest.raises(InputError, match="theta_rad: one number in all 80 rows though the loads change"):
        check(NECK, still)
    specimen, pushes = compression_test()
    assert not faults(specimen, measure(specimen, pushes, Sensors.perfect(), 1))


def test_loads_that_are_compared_are_bridged_by_a_polynomial() -> None:
    """By hand: a parabola through four rows a coefficient is itself anywhere; of fewer rows nothing is said."""
    loads = np.zeros((12, 7))
    loads[:, 0] = np.linspace(10.0, 120.0, 12)
    at = np.full((1, 7), 33.0)
    parabola = 2.0 - 3.0 * loads[:, :1] + 0.5 * loads[:, :1] ** 2
    assert smooth(loads, parabola, at) == pytest.approx(2.0 - 3.0 * 33.0 + 0.5 * 33.0**2)
    assert smooth(loads[:7], parabola[:7], at) is None


def test_coarse_readings_are_said() -> None:
    """A step of 10 mrad with a noise of 1 mrad; a step of a tenth of the noise is none."""
    for step, message in ((0.01, ["quantized"]), (1e-4, [])):
        use = Sensors(force_sigma=0.1, camera_resolution=(0.0, 0.0, step))
        data = measure(NECK, tendon_test(80, seed=1), use, 1)
        assert [finding.kind for finding in faults(NECK, data)] == message
