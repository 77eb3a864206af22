"""Rows of tendon robots: predicted, differentiated and fitted; against shooting (`tests/tables`) and differences."""

import numpy as np
import pytest
from robot_rows import pose_of, robot, sizes, tendon_numbers

import ecm_fast as ecm
from ecm_fast.mechanism.parameters import index
from ecm_fast.mechanism.vector import pack
from ecm_fast.models.instruments.robot_chain import RobotChain
from ecm_fast.testbed import Sensors, measure, tendon_test

TENTACLE = """
[[segment]]
length = 0.305
shape = "circle"
radius = [0.0154, 0.0064]
E = 0.37e6
nu = 0.49
density = 1175.0
[[segment]]
length = 0.055
radius = [0.0064, 0.0048]
[[tendon]]
name = "front"
route = "guided"
offset = [[0.0, 0.0114], [0.305, 0.0024]]
ends_at = 0.305
compliance = 1e-4
[[tendon]]
name = "back"
route = "chord"
plate = [0.0, -0.03]
pulley = [0.0, -0.05]
pulley_radius = 0.004
[[marker]]
name = "M1"
place = 0.1291
offset = [0.0, 0.0125]
[[marker]]
name = "M2"
place = 0.28
offset = [0.002, 0.01]
angle = 0.1
[[marker]]
name = "head"
place = "head"
offset = [0.008, 0.0]
[gravity]
tilt = 3.141592653589793
"""
FORCES = {"lam_front_N": [0.5, 2.0, 4.0], "lam_back_N": [0.0, 0.3, 0.0], "fz_N": [0.01, 0.0, 0.0]}
LENGTHS = {"len_front_mm": [305.0, 300.0, 296.0], "lam_back_N": [0.0, 0.2, 0.0]}
READ = {name: [None] * 3 for name in ("M1_x_mm", "M1_z_mm", "M2_theta_deg", "head_z_mm")}


@pytest.fixture(scope="module")
def tentacle(tmp_path_factory) -> ecm.Mechanism:
    path = tmp_path_factory.mktemp("robot") / "tentacle.toml"
    path.write_text(TENTACLE)
    return ecm.Mechanism.from_toml(path)


def row_of(row, loads, **noise) -> ecm.Measurements:
    """Return a row of a table as measurements: its loads, and what it says of the tip and of markers."""
    columns = {f"{name}_{unit}": [row[name]] for name, unit in (("fx", "N"), ("fz", "N"), ("tau", "Nm"))}
    for marker in ("tip", *(marker.name for marker in robot(row).markers)):
        names = ("x_m", "z_m", "theta_rad")
        own = names if marker == "tip" else [f"{marker}_{name}" for name in names]
        columns |= dict(zip(own, pose_of(row, marker)[:, None], strict=True))
    return ecm.Measurements.from_columns({**columns, **loads, **{name: [value] for name, value in noise.items()}})


def off(prediction: ecm.Prediction, row) -> float:
    """Return the largest misfit of poses, in rad and shares of the length."""
    residual = prediction.residual[0, [i for i, name in enumerate(prediction.channels) if not name.startswith("len_")]]
    return float(np.abs(residual.reshape(-1, 3) / sizes(row)).max())


@pytest.mark.slow
def test_rows_by_force_are_those_of_shooting(table):
    """Shooting: tip, markers and lengths of all stable rows within the accuracy that is promised, 1e-6."""
    for row in table("guided_planar"):
        if row["stable"] == "no":
            continue
        numbers = tendon_numbers(row)
        loads = {f"lam_t{i}_N": [row[f"t{i}_tension"]] for i in numbers}
        lengths = {f"len_t{i}_m": [row[f"length_{i}"]] for i in numbers}
        found = ecm.predict(robot(row), row_of(row, loads | lengths))
        assert found.status.tolist() == [0]
        assert off(found, row) <= 1e-6, row["id"]
        assert found.residual[0, -len(numbers) :] == pytest.approx(0.0, abs=1e-6 * row["L"])


@pytest.mark.slow
def test_rows_by_length_are_those_of_shooting(table):
    """Shooting: tip and markers of all rows within 1e-6, tendons that are slack or elastic among them."""
    for row in table("guided_planar_lengths"):
        loads = {f"len_t{i}_m": [row[f"t{i}_given"]] for i in tendon_numbers(row)}
        assert off(ecm.predict(robot(row), row_of(row, loads)), row) <= 1e-6, row["id"]


@pytest.mark.parametrize("loads", [FORCES, LENGTHS], ids=["by force", "by length"])
def test_derivatives_are_central_differences(tentacle, loads):
    """Differences of readings: by parameters of the body, of tendons and of markers, and by the forces that are read.

    Steps of 1e-6 leave 1e-5 of a derivative, most of it what Newton's method leaves of the readings.
    """
    data = ecm.Measurements.from_columns({**loads, **READ})
    chain, par = RobotChain(tentacle, data), pack(tentacle)
    names = ["segment1.E", "segment1.density", "segment1.radius_start", "segment2.radius_end", "tendon1.offset_1",
             "tendon1.compliance", "tendon1.zero", "tendon2.pulley_x", "tendon2.pulley_radius", "tendon2.gain",
             "marker1.place", "marker1.offset_z", "marker2.angle", "marker3.offset_x", "gravity.tilt"]  # fmt: skip
    found = chain.sensitivities(names, par, 1e-24)
    assert found.status.tolist() == [0, 0, 0]
    for i, name in enumerate(names):
        step = np.zeros(par.size)
        step[index(name)] = 1e-6 * max(abs(par[index(name)]), 1e-3)
        difference = (chain.solve(par + step, 1e-24)[0] - chain.solve(par - step, 1e-24)[0]) / (2.0 * step.sum())
        largest = np.abs(difference).max()
        assert np.abs(difference - found.dpose_dpar[:, :, i]).max() <= 2e-5 * largest + 1e-9, name
    for i, name in enumerate(("lam_front_N", "lam_back_N")):
        if name in loads:
            higher, lower = ({**loads, name: np.array(loads[name]) + step} for step in (2e-6, 0.0))  # one-sided
            poses = [RobotChain(tentacle, ecm.Measurements.from_columns({**each, **READ})).solve(par, 1e-24)[0]
                     for each in (higher, lower)]  # fmt: skip
            difference = (poses[0] - poses[1]) / 2e-6
            assert found.jacobian[:, :, i] == pytest.approx(difference, rel=1e-3, abs=1e-6)
        else:
            assert not found.jacobian[:, :, i].any()


@pytest.mark.parametrize(("name", "kind"), [("guided_planar", "neck_segments"), ("guided_planar_lengths", "tentacle")])
def test_stiffnesses_are_found_again(table, name, kind):
    """Shooting: from a start 30 % off, EI and GA of a robot are those that its tip and markers were computed with."""
    row = next(row for row in table(name) if row["kind"].startswith(kind))
    given = "t{}_given" if name.endswith("lengths") else "t{}_tension"
    column = "len_t{}_m" if name.endswith("lengths") else "lam_t{}_N"
    loads = {column.format(i): [row[given.format(i)]] for i in tendon_numbers(row)}
    data = row_of(row, loads, sigma_x_m=1e-7, sigma_z_m=1e-7, sigma_theta_rad=1e-6)
    start = robot(row).replace(**{"segment1.EI_start": 1.3 * row["EI"]})
    fit = ecm.identify(start, data, ["segment1.EI_start"])
    estimate = fit["segment1.EI_start"]
    assert estimate.value == pytest.approx(row["EI"], rel=1e-4)
    assert abs(estimate.value - row["EI"]) <= 4.0 * estimate.std


def test_a_file_is_read_and_written_again(tentacle, tmp_path):
    """By hand: units, blanks, and which reading drives a row; what is written reads back."""
    path = tmp_path / "run.csv"
    path.write_text("lam_front_N,len_front_mm,lam_back_N,M1_x_mm,M2_theta_deg,sigma_M1_x_mm,sigma_theta_deg\n"
                    "1.5,303.5,0,129.1,,0.1,0.5\n,301,0.2,,10,,0.5\n")  # fmt: skip
    data = ecm.read_measurements(path)
    names = tentacle.tendon_names
    assert data.channels == ("x", "z", "theta", "len_front", "M1_x", "M2_theta")
    assert data.forces(names) == pytest.approx(np.array([[1.5, 0.0], [np.nan, 0.2]]), nan_ok=True)
    assert data.lengths(names) == pytest.approx(np.array([[np.nan, np.nan], [0.301, np.nan]]), nan_ok=True)
    read = data.readings(("len_front", "M1_x", "M2_theta"))
    assert read == pytest.approx(np.array([[0.3035, 0.1291, np.nan], [np.nan, np.nan, np.radians(10)]]), nan_ok=True)
    sigmas = data.sigmas(("M1_x", "M2_theta"))
    assert sigmas == pytest.approx(np.array([[1e-4, np.radians(0.5)], [np.nan, np.radians(0.5)]]), nan_ok=True)
    again = ecm.read_measurements(data.to_csv(tmp_path / "again.csv"))
    assert again.named.keys() == data.named.keys()
    for name, values in data.named.items():
        np.testing.assert_array_equal(again.named[name], values)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"lam_frnt_N": [1.0]}, "column lam_frnt_N: the mechanism has no tendon 'frnt' (did you mean 'front'?)"),
        ({"M4_x_mm": [1.0]}, "column M4_x_mm: the mechanism has no marker 'M4'"),
        ({"lam_l_N": [1.0], "lam_front_N": [1.0]}, "column lam_l: the mechanism has no tendon 'l'"),
        ({"lam_front_N": [None], "M1_x_mm": [130.0]}, "row 1: tendon front has neither a force nor a length"),
        ({"lam_front_N": [1.0], "M1_x_mm": [130e3]}, "M1_x, M1_z: up to 130 m from the clamp"),
        ({"lam_front_N": 1.0 + np.arange(6), "head_z_mm": -30.0 * np.arange(6.0), "M1_z_mm": -5.0 * np.arange(6.0)},
         "head_z_m, M1_z_m: the other way round than predicted in every row"),
    ],
)  # fmt: skip
def test_columns_that_do_not_fit_the_robot_are_refused(tentacle, columns, message):
    """Contract: one line that names the column or the row, and what is allowed."""
    with pytest.raises(ecm.InputError) as error:
        ecm.identify(tentacle, ecm.Measurements.from_columns(columns), ["E"])
    assert message in str(error.value)


def test_a_neck_refuses_columns_of_robots():
    """Contract: a name that no tendon of a neck has is an error with a hint, wherever measurements are used."""
    neck, data = ecm.Mechanism(), ecm.Measurements.from_columns({"lam_left_N": [10.0], "x_mm": [109.0]})
    for use in (lambda: ecm.predict(neck, data), lambda: ecm.identify(neck, data, ["EI"])):
        with pytest.raises(ecm.InputError, match=r"column lam_left_N: the mechanism has no tendon 'left' .*'lam_l_N'"):
            use()


def test_a_body_of_more_pieces_than_the_mesh_is_refused(tentacle):
    """Contract: no element crosses a break. A segment that outgrows the tendon which ended with it has one more."""
    model = ecm.FiniteElementModel(tentacle)
    par = pack(tentacle.replace(**{"segment1.length": 0.31}))
    with_markers = RobotChain(tentacle, ecm.Measurements.from_columns({**FORCES, **READ}))
    assert with_markers.solve(par, 1e-20)[1].tolist() == 3 * [ecm.Status.INVALID_INPUT]
    result = model.solve_batch([(1.0, 0.0)], parameters=[par], path="ignore")
    assert not result.converged.any()


@pytest.mark.parametrize(
    "use",
    [
        lambda robot, data: ecm.diagnose(robot, data),
        lambda robot, data: ecm.plan(robot, data),
        lambda robot, data: measure(robot, tendon_test(), Sensors(), seed=0),
        lambda robot, data: ecm.FiniteElementModel(robot).inverse(theta=0.1, co_contraction=1.0),
    ],
    ids=["diagnose", "plan", "test bed", "inverse"],
)
def test_what_knows_necks_alone_refuses_robots(tentacle, use):
    """Contract: one sentence instead of the answer for a neck that is not there."""
    data = ecm.Measurements.from_columns({**FORCES, "M1_x_mm": [129.0, 128.0, 127.0], "M1_z_mm": [15.0, 20.0, 30.0]})
    with pytest.raises(ecm.InputError, match=r"allowed for a neck with the pair of \[tendons\]"):
        use(tentacle, data)
