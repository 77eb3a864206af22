"""The condensed fast path against the general path, which the tables vouch for, and against its own promises."""

import numpy as np
import pytest

from ecm_fast import FiniteElementModel, InputError, Mechanism, Status
from ecm_fast.data.measurements import Measurements
from ecm_fast.kernels.condensed.formulation import put_load, reset_straight, state_size
from ecm_fast.kernels.condensed.step import gauss_points, sweep
from ecm_fast.kernels.layout import LANES, R_EXTREME, R_PIVOT, R_SIZE, R_THETA, R_X, R_Z
from ecm_fast.mechanism.parameters import find, index
from ecm_fast.mechanism.vector import pack, unpack
from ecm_fast.models.batch import WORTH_A_GUESS
from ecm_fast.models.loads import QUADRATIC
from ecm_fast.models.paths.condensed import columns
from ecm_fast.testbed import equilibria

PULLEYS = {"pulley_z": 0.0645, "tendons.pulley_radius": 0.0055}
SLENDER = Mechanism.preset("slender")
NECKS = {
    "slender": SLENDER,
    "paper": Mechanism.preset("paper"),
    "pulleys": SLENDER.replace(**PULLEYS),
    "hooke": SLENDER.replace(axial_law="hooke"),
    "bent": SLENDER.replace(precurvature=0.7, clamp_tilt=0.2, gravity_tilt=-0.4, b=0.01),
}
STEEL = SLENDER.replace(EA=1e8, GA=1e8, axial_law="hooke")
BOX = np.array([[-330.0, -80.0, -11.0], [20.0, 80.0, 11.0]])
"""The wrench box: fx, fz [N], tau [N m], lowest and highest."""
SETS = [
    pytest.param(preset, load, id=f"{preset}-{load}")
    for preset in ("slender", "paper")
    for load in ("tendons", "box", "both")
]


def cases(load: str, n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return tendon forces over [0, 160]^2 N, dead wrenches over the box, or both."""
    rng, lam, wrench = np.random.default_rng(seed), np.zeros((n, 2)), np.zeros((n, 3))
    if load != "box":
        lam = rng.uniform(0.0, 160.0, (n, 2))
    if load != "tendons":
        wrench = rng.uniform(*BOX, (n, 3))
    return lam, wrench


def fast(model: FiniteElementModel, lam: np.ndarray, wrench: np.ndarray, tolerance: float, guess=None) -> tuple:
    """Return what the fast path says, without the general path behind it: poses and statuses."""
    out = columns(len(lam))
    model._single.fast.solve(lam, wrench, tolerance / QUADRATIC, out, guess)
    return np.stack(out[:3], axis=1), out[3]


def general(model: FiniteElementModel, lam: np.ndarray, wrench: np.ndarray) -> list:
    return [model.solve(*case) for case in zip(lam, wrench, strict=True)]


# The same discrete solution


@pytest.mark.parametrize("order", [3, 4, 5, 6])
@pytest.mark.parametrize("name", NECKS)
def test_it_is_the_discrete_solution_of_the_general_path(name, order):
    """Another method: the general path, to 1e-12, on every neck and order."""
    rng = np.random.default_rng(order)
    lam, wrench = rng.uniform(0.0, 160.0, (200, 2)), rng.normal(size=(200, 3)) * [10.0, 5.0, 0.5]
    model = FiniteElementModel(NECKS[name], order=order)
    pose, status = fast(model, lam, wrench, 1e-13)
    known = status == Status.CONVERGED
    assert known.mean() > 0.95
    expected = np.array(general(model, lam, wrench), dtype=object)[known]
    assert all(eq.stable for eq in expected)
    np.testing.assert_allclose(pose[known], np.stack([eq.pose for eq in expected]), rtol=0, atol=1e-12)


def test_a_neck_of_steel_meets_the_differential_equations():
    """The strong form: the general path loses digits here, as it knows the force to 1e-16 EA; the fast path does not.

    Its error is the discretization's, 1e-10 for one element of order 6 under these loads, and rounding.
    """
    lam = np.random.default_rng(3).uniform(0.0, 100.0, (40, 2))
    exact = equilibria(STEEL, Measurements.from_columns({"lam_l_N": lam[:, 0], "lam_r_N": lam[:, 1]}))
    for order, within in ((4, 1e-6), (6, 1e-9)):
        pose, status = fast(FiniteElementModel(STEEL, order=order), lam, np.zeros((1, 3)), 1e-9)
        known = status == Status.CONVERGED
        assert known.mean() > 0.95
        np.testing.assert_allclose(pose[known], exact.pose[known], rtol=0, atol=within)


@pytest.mark.parametrize("preset", ["slender", "paper"])
@pytest.mark.parametrize("load", ["tendons", "wrench"])
def test_far_outside_the_batch_is_the_general_path(preset, load):
    """Another method: the general path, poses and statuses, under loads four to six times the range."""
    rng = np.random.default_rng(7)
    lam, wrench = np.zeros((400, 2)), np.zeros((400, 3))
    if load == "tendons":
        lam = rng.uniform(0.0, 900.0, (400, 2))
    else:
        wrench = rng.uniform(4.0 * BOX[0], 4.0 * BOX[1], (400, 3))
    model = FiniteElementModel(Mechanism.preset(preset), order=5)
    batch = model.solve_batch(lam, wrench, tolerance=1e-13)
    expected = general(model, lam, wrench)
    assert batch.status.tolist() == [eq.status for eq in expected]
    np.testing.assert_allclose(batch.pose, [eq.pose for eq in expected], rtol=0, atol=1e-11)


@pytest.mark.parametrize(("change", "how"), [({"neutral_axis_offset": 1e-3}, {}), ({}, {"gauss": 6})])
def test_what_leaves_the_fast_path(change, how):
    """Contract: such a model has no fast path, and its batch is the general solve to the bit."""
    model = FiniteElementModel(SLENDER.replace(**change), **how)
    assert model._single.fast is None
    np.testing.assert_array_equal(model.solve_batch([[40.0, 10.0]]).pose[0], model.solve((40.0, 10.0)).pose)


# The tolerance


@pytest.mark.slow
@pytest.mark.parametrize(("preset", "load"), SETS)
def test_the_default_tolerance_is_kept(preset, load):
    """The general path, on 200 of 20000 cases, and the fast path at 1e-13, which is the general path's to 1e-12."""
    model, (lam, wrench) = FiniteElementModel(Mechanism.preset(preset)), cases(load, 20_000, seed=1)
    shares = [model.mechanism.beam.length, model.mechanism.beam.length, 1.0]
    pose, exact = (model.solve_batch(lam, wrench, **how).pose for how in ({}, {"tolerance": 1e-13}))
    np.testing.assert_allclose(
        exact[:200], [eq.pose for eq in general(model, lam[:200], wrench[:200])], rtol=0, atol=1e-12
    )
    assert np.linalg.norm((pose - exact) / shares, axis=1).max() < 1e-9
    rough = model.solve_batch(lam, wrench, tolerance=1e-5).pose
    assert np.linalg.norm((rough - exact) / shares, axis=1).max() < 1e-5


@pytest.mark.parametrize("order", [3, 5])
@pytest.mark.parametrize(("preset", "load"), SETS)
def test_newton_leaves_less_than_the_square_of_its_last_step(preset, load, order):
    """Newton's quadratic convergence, step by step: how far each iterate is from the limit, over its own step squared.

    Only iterates that could be the last one count: vouched for, and below the largest tolerance that is allowed.
    1.2 was seen, with forces and wrenches together and order 3.
    """
    model, largest = FiniteElementModel(Mechanism.preset(preset), order=order), 0.0
    length, con = model.mechanism.beam.length, model._single.fast.con
    for seed in range(30):
        lam, wrench = cases(load, LANES, seed)
        limit = fast(model, lam, wrench, 1e-13)[0]
        state = state_before_the_first_step(model, lam, wrench)
        rows = state.reshape(-1, LANES)
        for _ in range(6):
            sweep(gauss_points(order), con, state)
            pose = rows[[R_X, R_Z, R_THETA]].T
            error = np.linalg.norm((pose - limit) / [length, length, 1.0], axis=1)
            size, sound = rows[R_SIZE], (rows[R_EXTREME] <= 1.0) & (rows[R_PIVOT] > 0.0)
            last = sound & (size <= 1e-3 / QUADRATIC) & (size > 1e-10)
            assert (error[sound & (size <= 1e-10)] < 1e-9).all()
            largest = max(largest, (error[last] / size[last]).max(initial=0.0))
    assert 1e-3 < largest < QUADRATIC


def state_before_the_first_step(model, lam, wrench):
    """Return a block of straight beams under loads."""
    order = model.discretization.order
    state = np.zeros(LANES * state_size(order))
    for j in range(LANES):
        put_load(state, LANES, j, lam[j], wrench[j])
        reset_straight(model._single.fast.con, 1, 0, state, LANES, j, order)
    return state


@pytest.mark.parametrize("tolerance", [0.0, -1e-9, 1e-14, 0.1, np.nan, np.inf])
def test_tolerances_that_cannot_be(tolerance):
    """Contract: the one line of the error, at every way in."""
    model = FiniteElementModel()
    for call in (model.solve_batch, lambda lam, **how: model.sensitivities([], lam, **how)):
        with pytest.raises(InputError, match=r"^tolerance = .*: allowed is a number from 1e-13 to 1e-3$"):
            call([[1.0, 2.0]], tolerance=tolerance)
    with pytest.raises(InputError, match=r"^tolerance = "):
        model.stepper(tolerance=tolerance)


# Where a solve starts from


@pytest.mark.parametrize("name", NECKS)
def test_a_large_batch_is_each_of_its_cases(name):
    """It starts from polynomials; cases in small batches start from the straight beam."""
    model = FiniteElementModel(NECKS[name])
    lam, wrench = np.random.default_rng(2).uniform(0.0, 160.0, (WORTH_A_GUESS, 2)), np.array([-20.0, 5.0, 0.3])
    assert model._single.fast.fit_guess(lam.max(), wrench) is not None
    for tolerance, within in ((1e-9, 1e-9), (1e-13, 1e-12)):
        large = model.solve_batch(lam, wrench, tolerance=tolerance)
        for part in np.array_split(np.arange(len(lam)), 3):
            small = model.solve_batch(lam[part], wrench, tolerance=tolerance)
            assert large.status[part].tolist() == small.status.tolist()
            np.testing.assert_allclose(large.pose[part], small.pose, rtol=0, atol=within)


def test_polynomials_serve_only_where_they_were_fitted():
    """Another start: outside the fitted range the answer is that of the straight start, to the bit."""
    model, wrench = FiniteElementModel(), np.zeros(3)
    guess = model._single.fast.fit_guess(60.0, wrench)
    lam = np.random.default_rng(3).uniform(0.0, 160.0, (500, 2))
    pose, status = fast(model, lam, wrench[None], 1e-13, guess)
    straight, same = fast(model, lam, wrench[None], 1e-13)
    outside = (lam > 60.0).any(axis=1)
    assert 50 < outside.sum() < 450
    assert status.tolist() == same.tolist()
    np.testing.assert_array_equal(pose[outside], straight[outside])
    np.testing.assert_allclose(pose, straight, rtol=0, atol=1e-12)


@pytest.mark.parametrize("spoil", [900.0, 1e300, np.inf, np.nan])
def test_a_large_batch_where_no_polynomial_can_be_fitted(spoil):
    """One case so far out that no stable neck is there, or not a number: the others are as without it."""
    model, lam = FiniteElementModel(), np.random.default_rng(4).uniform(0.0, 160.0, (WORTH_A_GUESS, 2))
    clean = model.solve_batch(lam[1:])
    lam[0] = spoil, 0.9 * spoil
    assert model._single.fast.fit_guess(lam.max(), np.zeros(3)) is None
    spoiled = model.solve_batch(lam)
    assert not spoiled.stable[0]
    assert np.isnan(spoiled.pose[0]).all()
    assert spoiled.stable[1:].all()
    np.testing.assert_allclose(spoiled.pose[1:], clean.pose, rtol=0, atol=1e-9)


# Mechanisms side by side


def near(preset: str, rng: np.random.Generator) -> np.ndarray:
    """Return an allowed parameter vector about a preset, of either law; one in four has an offset neutral axis."""
    par = pack(Mechanism.preset(preset))
    for name in ("length", "EA", "GA", "EI", "mass_per_length", "head.mass", "h", "plate_half_width"):
        par[index(name)] *= rng.uniform(0.8, 1.25)
    par[index("axial_law")] = rng.integers(2)
    par[index("tendons.pulley_radius")] = rng.choice([0.0, 0.0055])
    for name in ("precurvature", "clamp_tilt", "gravity_tilt", "pulley_height", "pulley_height_asymmetry"):
        par[index(name)] = 2.0 * find(name).typical * rng.normal()
    for name in ("pulley_spacing", "pulley_shift", "pulley_x", "b", "effects.head_mass"):
        par[index(name)] = find(name).typical * rng.normal()
    par[index("neutral_axis_offset")] = rng.choice([0.0, 0.0, 0.0, 1e-3])
    return par


@pytest.mark.parametrize("order", [3, 4, 5, 6])
def test_a_batch_of_mechanisms_is_one_model_a_row(order):
    """150 rows: two blocks of lanes and a part of a third; the general path of each mechanism alone."""
    rng = np.random.default_rng(order)
    par = np.stack([near(("slender", "paper")[i % 2], rng) for i in range(150)])
    lam, wrench = rng.uniform(0.0, 160.0, (150, 2)), rng.normal(size=(150, 3)) * [10.0, 5.0, 0.5]
    lam[7] = 1e4
    batch = FiniteElementModel(order=order).solve_batch(lam, wrench, parameters=par, tolerance=1e-13)
    alone = [
        FiniteElementModel(unpack(row), order=order).solve(*case) for row, *case in zip(par, lam, wrench, strict=True)
    ]
    assert batch.status.tolist() == [eq.status for eq in alone]
    assert batch.stable.sum() >= 140
    assert not batch.stable[7]
    np.testing.assert_allclose(batch.pose, [eq.pose for eq in alone], rtol=0, atol=1e-12)
    # and the mechanisms' own fast path, at the default tolerance
    rough = FiniteElementModel(order=order).solve_batch(lam, wrench, parameters=par)
    np.testing.assert_allclose(rough.pose, batch.pose, rtol=0, atol=1e-9)
