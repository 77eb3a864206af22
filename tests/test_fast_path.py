"""The condensed fast path against the general path, which the tables vouch for."""

import importlib.util
import threading
from pathlib import Path

import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys

from ecm_fast import FiniteElementModel, Mechanism, Status

ROOT = Path(__file__).resolve().parent.parent
PULLEYS = {"pulley_z": 0.0645, "tendons.pulley_radius": 0.0055}
NECKS = {
    "slender": Mechanism.preset("slender"),
    "paper": Mechanism.preset("paper"),
    "pulleys": Mechanism.preset("slender").replace(**PULLEYS),
    "hooke": Mechanism.preset("slender").replace(axial_law="hooke"),
    "bent": Mechanism.preset("slender").replace(precurvature=0.7, clamp_tilt=0.2, gravity_tilt=-0.4, b=0.01),
    "steel": Mechanism.preset("slender").replace(EA=1e8, GA=1e8, axial_law="hooke"),
}


def general(model: FiniteElementModel, lam: np.ndarray, wrench: np.ndarray) -> list:
    return [model.solve(*case) for case in zip(lam, wrench, strict=True)]


@pytest.mark.parametrize("order", [3, 4, 5, 6])
@pytest.mark.parametrize("name", NECKS)
def test_it_is_the_discrete_solution_of_the_general_path(name, order):
    rng = np.random.default_rng(order)
    lam, wrench = rng.uniform(0.0, 160.0, (200, 2)), rng.normal(size=(200, 3)) * [10.0, 5.0, 0.5]
    model = FiniteElementModel(NECKS[name], order=order)
    pose, status = np.empty((200, 3)), np.empty(200, dtype=np.int64)
    model._condensed.solve(np.column_stack([lam, wrench, np.ones(200)]), pose, status)
    assert (status == Status.CONVERGED).mean() > 0.95
    expected = general(model, lam, wrench)
    known = status == Status.CONVERGED
    assert all(eq.stable for eq in np.array(expected, dtype=object)[known])
    # steel: the general path knows positions to 1e-16, so the axial force to 1e-14 EA, 1e-7 of what bends the neck
    tolerance = 1e-7 if name == "steel" else 1e-12
    np.testing.assert_allclose(pose[known], np.array([eq.pose for eq in expected])[known], rtol=0, atol=tolerance)


@pytest.mark.parametrize("preset", ["slender", "paper"])
@pytest.mark.parametrize("load", ["tendons", "wrench"])
def test_far_outside_the_working_range_it_is_right_or_leaves_the_case_to_the_general_path(preset, load):
    rng = np.random.default_rng(7)
    lam, wrench = np.zeros((400, 2)), np.zeros((400, 3))
    if load == "tendons":
        lam = rng.uniform(0.0, 900.0, (400, 2))
    else:
        wrench = rng.uniform([-1320.0, -320.0, -44.0], [80.0, 320.0, 44.0], (400, 3))
    model = FiniteElementModel(Mechanism.preset(preset))
    batch = model.solve_batch(lam, wrench)
    for pose, status, eq in zip(batch.pose, batch.status, general(model, lam, wrench), strict=True):
        assert status == eq.status
        np.testing.assert_allclose(pose, eq.pose, rtol=0, atol=1e-11)


@pytest.mark.parametrize("change", [{"neutral_axis_offset": 1e-3}, {"gauss": 6}])
def test_what_leaves_the_fast_path(change):
    model = FiniteElementModel(
        Mechanism().replace(**{name: value for name, value in change.items() if name.startswith("neutral")}),
        **{name: value for name, value in change.items() if not name.startswith("neutral")},
    )
    assert model._condensed is None
    batch = model.solve_batch([[40.0, 10.0]])
    np.testing.assert_array_equal(batch.pose[0], model.solve((40.0, 10.0)).pose)


def test_the_written_out_steps_are_up_to_date():
    spec = importlib.util.spec_from_file_location("write_condensed", ROOT / "tools" / "write_condensed.py")
    writer = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(writer)
    for order in writer.ORDERS:
        path = ROOT / "ecm_fast" / "kernels" / f"condensed{order}.py"
        assert path.read_text(encoding="utf-8") == writer.module(order)


def path_of_loads(n):
    t = np.linspace(0.0, 12.0, n)
    return np.column_stack([80.0 + 70.0 * np.sin(3.0 * t), 80.0 + 70.0 * np.cos(2.0 * t)])


@pytest.mark.parametrize("how", [{}, {"elements": 20, "order": 1}])
def test_a_control_loop_meets_the_cold_solutions(how):
    model = FiniteElementModel(NECKS["pulleys"], **how)
    step = model.stepper()
    for lam in path_of_loads(150):
        *pose, status = step(*lam)
        assert status == Status.CONVERGED
        np.testing.assert_allclose(pose, model.solve(lam).pose, rtol=0, atol=1e-10)


@pytest.mark.parametrize("bad", [(np.nan, 1.0), (1.0, np.inf), (-1.0, 2.0), (1.0, -np.inf)])
@pytest.mark.parametrize("how", [{}, {"elements": 20, "order": 1}])
def test_after_a_bad_load_the_next_good_one_is_right(how, bad):
    model = FiniteElementModel(**how)
    step = model.stepper()
    step(40.0, 10.0)
    *pose, status = step(*bad)
    assert status == Status.INVALID_INPUT
    assert np.isnan(pose).all()
    *pose, status = step(60.0, 10.0)
    assert status == Status.CONVERGED
    np.testing.assert_allclose(pose, model.solve((60.0, 10.0)).pose, rtol=0, atol=1e-12)


def test_a_load_that_has_no_equilibrium_gives_nan_and_a_status():
    step = FiniteElementModel().stepper()
    *pose, status = step(900.0, 800.0)
    assert status == Status.TENDON_ZERO_LENGTH
    assert np.isnan(pose).all()


def test_a_step_leaves_no_memory_behind():
    step = FiniteElementModel().stepper()
    step(40.0, 10.0)
    _nrt_python.memsys_enable_stats()
    before = rtsys.get_allocation_stats()
    for lam_l, lam_r in path_of_loads(500).tolist():
        step(lam_l, lam_r)
    after = rtsys.get_allocation_stats()
    # numba wraps each of the two arrays a step hands over, and lets go of the wrapper; the step itself asks for nothing
    assert after.alloc - before.alloc == after.free - before.free == 2 * 500


def test_two_threads_with_a_stepper_each_repeat_the_serial_run_bit_for_bit():
    model = FiniteElementModel(NECKS["pulleys"])
    loads = path_of_loads(4000).tolist()

    def run(into):
        step = model.stepper()
        into.extend(step(*lam) for lam in loads)

    serial, answers = [], ([], [])
    run(serial)
    threads = [threading.Thread(target=run, args=(into,)) for into in answers]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert answers[0] == serial
    assert answers[1] == serial
