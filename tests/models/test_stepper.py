"""The control step: the cold solution at every call, whatever was before, and what it promises to a control loop."""

import gc
import sys
import threading

import numpy as np
import pytest
from allocations import assert_no_memory

from ecm_fast import FiniteElementModel, InputError, Mechanism, Status
from ecm_fast.models.paths.condensed import Condensation, compiled_step

SLENDER = Mechanism.preset("slender")
PULLEYS = SLENDER.replace(pulley_z=0.0645, **{"tendons.pulley_radius": 0.0055})
OFFSET = PULLEYS.replace(neutral_axis_offset=1e-3)
MODELS = {
    "condensed": (PULLEYS, {}),
    "chain": (PULLEYS, {"elements": 20, "order": 1}),
    "chain of cubics": (PULLEYS, {"elements": 2, "order": 3}),
    "robust": (OFFSET, {}),
}
VARIANTS = [{}, {"derivatives": True}, {"lam_max": 160.0}, {"lam_max": 160.0, "derivatives": True}]
every_model = pytest.mark.parametrize("name", MODELS)
every_variant = pytest.mark.parametrize("how", VARIANTS, ids=lambda how: "+".join(how) or "plain")
WRENCH = (-20.0, 5.0, 0.4)
NOT_A_FORCE = [(np.nan, 1.0), (1.0, np.nan), (np.inf, 1.0), (1.0, np.inf), (-1.0, 2.0), (2.0, -1e-300), (1.0, -np.inf)]
TOO_MUCH = [(1e300, 0.0), (0.0, 1e8), (1e154, 1e154), (900.0, 800.0), (sys.float_info.max,) * 2]


def model_of(name: str) -> FiniteElementModel:
    mechanism, how = MODELS[name]
    return FiniteElementModel(mechanism, **how)


def path_of_loads(n: int) -> list:
    t = np.linspace(0.0, 12.0, n)
    return np.column_stack([80.0 + 70.0 * np.sin(3.0 * t), 80.0 + 70.0 * np.cos(2.0 * t)]).tolist()


def jumps(n: int) -> list:
    """Return tendon forces of which none is near the one before; one is slack now and then."""
    lam = np.random.default_rng(5).uniform(-20.0, 160.0, (n, 2))
    return np.maximum(lam, 0.0).tolist()


def sizes(derivative: np.ndarray, compliance: np.ndarray) -> np.ndarray:
    """Return the size that each entry of a jacobian or a compliance may be compared with."""
    if derivative.shape == (3, 2):
        return np.abs(derivative).max(axis=1, keepdims=True)
    own = np.sqrt(np.diag(compliance))
    return np.outer(own, own)


# The cold solution


@every_model
@every_variant
@pytest.mark.parametrize("loads", [path_of_loads, jumps])
def test_each_step_is_the_cold_solution(name, how, loads):
    """`model.solve`, at 1e-13: pose, and where asked for its derivatives.

    Those come from the factor of the last step, which was taken at a distance of sqrt(1e-13 / 10) = 1e-7 at most.
    """
    model = model_of(name)
    step = model.stepper(WRENCH, tolerance=1e-13, **how)
    for lam in loads(60):
        *pose, status = step(*lam)
        eq = model.solve(lam, WRENCH)
        assert status == eq.status == Status.CONVERGED
        np.testing.assert_allclose(pose, eq.pose, rtol=0, atol=1e-12)
        if "derivatives" in how:
            for found, exact in ((step.jacobian, eq.jacobian), (step.compliance, eq.compliance)):
                # of what a coordinate moves under loads on itself: each has its own unit
                assert (np.abs(found - exact) <= 1e-6 * sizes(exact, eq.compliance)).all()


@pytest.mark.parametrize("order", [3, 4, 6])
def test_every_order_is_its_cold_solution(order):
    """Another method: the cold solve, to 1e-12, along a path and over jumps."""
    model = FiniteElementModel(PULLEYS, order=order)
    for how in VARIANTS:
        step = model.stepper(WRENCH, tolerance=1e-13, **how)
        for lam in [*path_of_loads(40), *jumps(20)]:
            np.testing.assert_allclose(step(*lam)[:3], model.solve(lam, WRENCH).pose, rtol=0, atol=1e-12)


@every_variant
def test_the_default_tolerance_is_kept(how):
    """Another tolerance: solutions to 1e-13, over 4000 steps."""
    model, loads = model_of("condensed"), [*path_of_loads(2000), *jumps(2000)]
    step = model.stepper(**how)
    exact = model.solve_batch(loads, tolerance=1e-13).pose
    pose = np.array([step(*lam)[:3] for lam in loads])
    shares = [model.mechanism.beam.length, model.mechanism.beam.length, 1.0]
    assert np.linalg.norm((pose - exact) / shares, axis=1).max() < 1e-9


def test_derivatives_without_which_none_are_made():
    """`step.jacobian` is that of the last call, whatever kind of call it was: nan where there is no equilibrium."""
    for name in MODELS:
        step = model_of(name).stepper(derivatives=True)
        for bad in [*NOT_A_FORCE, *TOO_MUCH]:
            assert step(40.0, 10.0)[3] == Status.CONVERGED
            assert np.isfinite(step.jacobian).all()
            assert np.isfinite(step.compliance).all()
            assert step(*bad)[3] != Status.CONVERGED
            assert np.isnan(step.jacobian).all()
            assert np.isnan(step.compliance).all()


# What may come in


@every_model
@every_variant
def test_after_any_load_the_next_good_one_is_right(name, how):
    """A clean stepper and the cold solve; what is no force does not even touch the memory of the fast path."""
    model = model_of(name)
    step, clean = model.stepper(**how), model.stepper(**how)
    good = path_of_loads(len(NOT_A_FORCE + TOO_MUCH))
    for lam, bad in zip(good, NOT_A_FORCE + TOO_MUCH, strict=True):
        *pose, status = step(*bad)
        assert np.isnan(pose).all()
        if bad in NOT_A_FORCE:
            assert status == Status.INVALID_INPUT
        else:
            assert status in (Status.NOT_CONVERGED, Status.TENDON_ZERO_LENGTH)
        answer, expected = step(*lam), clean(*lam)
        assert answer[3] == Status.CONVERGED
        if bad in NOT_A_FORCE and name == "condensed":
            assert answer == expected
        np.testing.assert_allclose(answer[:3], expected[:3], rtol=0, atol=1e-9)
        np.testing.assert_allclose(answer[:3], model.solve(lam).pose, rtol=0, atol=1e-9)


@pytest.mark.parametrize("wrench", [(np.nan, 0.0, 0.0), (0.0, np.inf, 0.0), (0.0, 0.0, -np.inf), (1e300, 0.0, 0.0)])
@every_model
@every_variant
def test_a_wrench_that_cannot_be_gives_a_status(name, how, wrench):
    """Contract: nan and a status, no exception."""
    step = model_of(name).stepper(wrench, **how)
    for lam in ((40.0, 10.0), (0.0, 0.0), (41.0, 10.0)):
        *pose, status = step(*lam)
        assert np.isnan(pose).all()
        assert status != Status.CONVERGED
        assert (status == Status.INVALID_INPUT) == (not np.isfinite(wrench).all())


@pytest.mark.parametrize("lam_max", [np.nan, -1.0, np.inf])
def test_ranges_that_cannot_be(lam_max):
    """Contract: the text of the error."""
    with pytest.raises(InputError, match=r"^lam_max = .*: allowed is a finite number, 0 or more$"):
        FiniteElementModel().stepper(lam_max=lam_max)


@pytest.mark.parametrize("order", [3, 4, 5, 6])
def test_numbers_of_any_kind_compile_nothing(order):
    """Contract: one compiled signature, whatever the type of the arguments."""
    model = FiniteElementModel(order=order)
    step, compiled = model.stepper(), compiled_step(order)
    for kind in (float, int, bool, np.float64, np.float32, np.int64, np.int32, np.uint8, np.bool_):
        assert step(kind(1), kind(0))[3] == Status.CONVERGED
        np.testing.assert_allclose(step(kind(1), kind(0))[:3], model.solve((1.0, 0.0)).pose, rtol=0, atol=1e-9)
    for other in ("40", None, 1j, [1.0]):
        with pytest.raises(TypeError):
            step(other, 1.0)
    assert len(compiled.signatures) == 1
    assert step(1, 0)[3] == Status.CONVERGED


# A call that depends on nothing but its arguments


@every_model
@pytest.mark.parametrize("derivatives", [False, True])
@pytest.mark.parametrize("lam_max", [160.0, 40.0, 900.0])
def test_with_a_range_no_call_depends_on_those_before(name, derivatives, lam_max):
    """Bit for bit: inside the range, beyond it, where the general path decides, where no polynomial fits (900 N)."""
    model = model_of(name)
    loads = [*path_of_loads(20), *NOT_A_FORCE, *TOO_MUCH, (500.0, 40.0), (480.0, 500.0), (0.0, 0.0), (300.0, 0.0)]

    def stepper():
        return model.stepper(derivatives=derivatives, lam_max=lam_max)

    def bits(step, lam):
        answer = [np.array(step(*lam))]
        return b"".join(array.tobytes() for array in answer + ([step.jacobian, step.compliance] if derivatives else []))

    alone, step = [bits(stepper(), lam) for lam in loads], stepper()
    for i in np.random.default_rng(1).permutation(2 * len(loads)) % len(loads):
        assert bits(step, loads[i]) == alone[i]


def test_where_it_starts_from():
    """A polynomial where one fits; where none does, still the right answers."""
    model = model_of("condensed")
    assert isinstance(model._single.fast, Condensation)
    assert model._single.fast.fit_guess(160.0, np.zeros(3)) is not None
    assert model._single.fast.fit_guess(900.0, np.zeros(3)) is None
    for lam_max in (20.0, 160.0, 900.0):
        step = model.stepper(lam_max=lam_max)
        for lam in jumps(50):
            *pose, status = step(*lam)
            assert status == Status.CONVERGED
            np.testing.assert_allclose(pose, model.solve(lam).pose, rtol=0, atol=1e-9)


# Memory, threads


@pytest.mark.parametrize("order", [4, 5])
@every_variant
def test_a_step_asks_for_no_memory(order, how):
    """Numba's own count and Python's: ten thousand steps leave nothing, and only the answer's numbers come and go."""
    step = FiniteElementModel(order=order).stepper(**how)
    loads = path_of_loads(10_000)
    step(*loads[0])
    assert_no_memory(step, loads)


@every_model
@every_variant
def test_two_threads_with_a_stepper_each_repeat_the_serial_run(name, how):
    """Contract: the serial run, bit for bit."""
    model, loads = model_of(name), path_of_loads(4000 if name == "condensed" else 400)

    def run(into):
        step = model.stepper(**how)
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


@pytest.mark.slow
@every_model
@every_variant
def test_a_step_outlives_its_model(name, how):
    """Contract: the stepper keeps what its kernel points to."""
    model, loads = model_of(name), path_of_loads(50)
    expected = [model.stepper(**how)(*lam) for lam in loads[:1]]
    step = model.stepper(**how)
    del model
    gc.collect()
    others = [np.full(size, np.nan) for size in range(1, 3000)]  # into the room that would be free
    answers = [step(*lam) for lam in loads]
    assert answers[:1] == expected
    del others
    np.testing.assert_allclose(
        [answer[:3] for answer in answers], model_of(name).solve_batch(loads, tolerance=1e-13).pose, rtol=0, atol=1e-9
    )


def test_steppers_of_one_model_do_not_disturb_each_other():
    """Contract: the same answers alone and in turn, bit for bit."""
    model = model_of("condensed")
    left, right = model.stepper(), model.stepper(WRENCH, derivatives=True)
    alone = [model.stepper()(*lam) for lam in path_of_loads(1)]
    between = []
    for lam in path_of_loads(1):
        right(100.0, 3.0)
        between.append(left(*lam))
    assert between == alone
