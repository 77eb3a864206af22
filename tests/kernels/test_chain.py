"""The fast path for many elements against the general path, a closed form, and its own promises."""

import numpy as np
import pytest
from scipy.optimize import brentq

from ecm_fast import FiniteElementModel, Mechanism, Status
from ecm_fast.kernels.chain.solve import follow_chain
from ecm_fast.kernels.layout import H_NEGATIVE, N_LOADS
from ecm_fast.models.loads import QUADRATIC, loads_of
from ecm_fast.models.paths.chain import Chain
from ecm_fast.models.paths.condensed import columns

SLENDER = Mechanism.preset("slender")
NECKS = {
    "slender": SLENDER,
    "paper": Mechanism.preset("paper"),
    "pulleys": SLENDER.replace(pulley_z=0.0645, **{"tendons.pulley_radius": 0.0055}),
    "hooke": SLENDER.replace(axial_law="hooke"),
    "bent": SLENDER.replace(precurvature=0.7, clamp_tilt=0.2, gravity_tilt=-0.4, b=0.01),
    "upside down": SLENDER.replace(clamp_tilt=-0.3, gravity_tilt=3.0, mass_per_length=30.0),
}
# largest squared last step of a solve to 1e-13
LAST2 = 1e-13 / QUADRATIC
UNEVEN = [3.0, 0.1, 1.0, 1.0, 0.02, 5.0, 1.0]
BAD = [
    [np.nan, 1, 0, 0, 0, 1],
    [1, np.nan, 0, 0, 0, 1],
    [1, 2, np.inf, 0, 0, 1],
    [1, 2, 0, np.nan, 0, 1],
    [1, 2, 0, 0, np.nan, 1],
    [1e300, 0, 0, 0, 0, 1],
    [0, 0, 0, 0, -1e200, 1],
]


def chain_of(model: FiniteElementModel) -> Chain | None:
    stations, tip, q_rest, _, _ = model._single.system
    return Chain.from_system(model.discretization, stations, tip, q_rest)


def solve(chain: Chain, loads) -> tuple[np.ndarray, np.ndarray]:
    loads = np.array(loads, dtype=float)
    out = columns(len(loads))
    chain.solve(loads[:, :2].copy(), loads[:, 2:5].copy(), LAST2, out)
    return np.stack(out[:3], axis=1), out[3]


def new_state(chain: Chain, loads) -> np.ndarray:
    state = chain.new_state()
    state[:N_LOADS] = loads_of(np.array([loads[:2]]), np.array([loads[2:5]]))[0]
    return state


def random_loads(n: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    wrench = rng.normal(size=(n, 3)) * [10.0, 5.0, 0.5]
    return np.column_stack([rng.uniform(0.0, 160.0, (n, 2)), wrench, np.ones(n)])


def agrees_with_the_general_path(model: FiniteElementModel, loads: np.ndarray, share: float) -> None:
    pose, status = solve(chain_of(model), loads)
    known = status == Status.CONVERGED
    assert known.mean() >= share
    expected = [model.solve(case[:2], case[2:5]) for case in loads[known]]
    assert all(eq.stable for eq in expected)
    np.testing.assert_allclose(pose[known], [eq.pose for eq in expected], rtol=0, atol=1e-12)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
@pytest.mark.parametrize("elements", [1, 2, 5, 10, 20, 160])
def test_it_is_the_discrete_solution_of_the_general_path(elements, order):
    """Another method: the general path, to 1e-12."""
    model = FiniteElementModel(NECKS["pulleys"], elements, order)
    agrees_with_the_general_path(model, random_loads(20, seed=order), share=0.95)


@pytest.mark.parametrize("how", [{"elements": 65, "order": 1}, {"elements": 3, "order": 6}])
@pytest.mark.parametrize("name", NECKS)
def test_it_takes_every_neck(name, how):
    """Another method: the general path, on necks that differ in law, pulleys, gravity and shape."""
    agrees_with_the_general_path(FiniteElementModel(NECKS[name], **how), random_loads(30, seed=5), share=0.9)


@pytest.mark.parametrize("order", [1, 2, 5])
def test_elements_may_differ_in_length(order):
    """Another method: the general path, on elements that differ 250 times in length."""
    agrees_with_the_general_path(FiniteElementModel(SLENDER, UNEVEN, order), random_loads(30, seed=6), share=0.95)


@pytest.mark.parametrize("order", [1, 2])
def test_the_section_may_differ_from_element_to_element(order):
    """Another method: the general path, with random stiffness, curvature and load by station."""
    model = FiniteElementModel(NECKS["bent"], 9, order)
    stations = model._single.system[0]
    # stiffness, curvature as built and dead load of every station
    stations[:, [2, 3, 4, 5, 8, 9]] *= np.random.default_rng(4).uniform(0.7, 1.4, (len(stations), 6))
    agrees_with_the_general_path(model, random_loads(30, seed=7), share=0.9)


@pytest.mark.parametrize("how", [{"elements": 20, "order": 1}, {"elements": 4, "order": 3}])
@pytest.mark.parametrize("load", ["tendons", "wrench"])
def test_far_outside_it_is_right_or_gives_up(load, how):
    """Another method: the general path, under loads five times the working range."""
    rng = np.random.default_rng(7)
    loads = np.zeros((200, 6))
    loads[:, 5] = 1.0
    if load == "tendons":
        loads[:, :2] = rng.uniform(0.0, 900.0, (200, 2))
    else:
        loads[:, 2:5] = rng.uniform([-1320.0, -320.0, -44.0], [80.0, 320.0, 44.0], (200, 3))
    agrees_with_the_general_path(FiniteElementModel(SLENDER, **how), loads, share=0.05)


def critical_load(length: float, EA: float, GA: float, EI: float) -> float:
    """Dead load at which the straight clamped-free column, short and soft in shear, becomes unstable [N]."""

    def excess(load: float) -> float:
        stretch = brentq(lambda g: EA / 3.0 * (g - g**-2) + load, 0.3, 1.0, xtol=1e-15)
        return float(load * (stretch + load / GA) - (np.pi / (2.0 * length)) ** 2 * EI)

    return float(brentq(excess, 1.0, 700.0, xtol=1e-10))


@pytest.mark.parametrize(("elements", "order", "within"), [(160, 1, 5e-2), (20, 2, 1e-4), (3, 4, 1e-5)])
def test_it_vouches_for_a_column_up_to_its_buckling_load(elements, order, within):
    """Closed form: the critical load of the shear-flexible compressible column."""
    weightless = SLENDER.replace(g=0.0)
    critical = critical_load(0.109, 7500.0, 2420.0, 3.0)
    assert critical == pytest.approx(539.05, abs=0.005)
    chain = chain_of(FiniteElementModel(weightless, elements, order))
    # the straight column is in equilibrium at every load
    shares = [0.2, 0.8, 1.0 - within, 1.0 + within, 1.1, 1.2]
    _, status = solve(chain, [[0.0, 0.0, -share * critical, 0.0, 0.0, 1.0] for share in shares])
    assert (status == [Status.CONVERGED] * 3 + [Status.NOT_CONVERGED] * 3).all()


@pytest.mark.parametrize(("share", "negative"), [(0.9, 2), (1.1, 3), (8.5, 3), (9.5, 4)])
def test_the_pivots_count_the_ways_to_buckle(share, negative):
    """Closed form: Euler's critical loads stand as 1, 9, 25, so the sign changes can be counted."""
    # stiff against shear and stretch: Euler's column, whose loads are 1, 9, 25, ... times the first
    stiff = SLENDER.replace(g=0.0, EA=1e6, GA=1e6, axial_law="hooke")
    chain = chain_of(FiniteElementModel(stiff, 64, 1))
    first = (np.pi / (2.0 * 0.109)) ** 2 * 3.0
    state = new_state(chain, [0.0, 0.0, -share * first, 0.0, 0.0, 1.0])
    x, *_, status = follow_chain(chain.con, state, LAST2, 0.0, 0.0)
    assert (status == Status.CONVERGED) == (share < 1.0)
    assert np.isnan(x) == (share > 1.0)
    assert state[H_NEGATIVE] == negative


@pytest.mark.parametrize("how", [{"elements": 20, "order": 1}, {"elements": 3, "order": 2}])
def test_after_a_bad_case_the_next_one_is_right(how):
    """Contract: a case leaves nothing behind; the next one is the same to the bit."""
    chain = chain_of(FiniteElementModel(SLENDER, **how))
    good = random_loads(1, seed=1)
    expected, _ = solve(chain, good)
    pose, status = solve(chain, np.vstack([[bad, good[0]] for bad in BAD]))
    assert (status == [Status.NOT_CONVERGED, Status.CONVERGED] * len(BAD)).all()
    np.testing.assert_array_equal(pose[1::2], np.repeat(expected, len(BAD), axis=0))


@pytest.mark.parametrize("how", [{"elements": 20, "order": 1}, {"elements": 3, "order": 2}])
def test_the_warm_path_meets_the_cold_one(how):
    """Another method: the cold solve of every load, to 1e-12, with invalid loads in between."""
    chain = chain_of(FiniteElementModel(NECKS["pulleys"], **how))
    t = np.linspace(0.0, 12.0, 200)
    lam = np.column_stack([80.0 + 70.0 * np.sin(3.0 * t), 80.0 + 70.0 * np.cos(2.0 * t)])
    cold, status = solve(chain, np.column_stack([lam, np.zeros((200, 3)), np.ones(200)]))
    assert (status == Status.CONVERGED).all()
    state = new_state(chain, [0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    for i, case in enumerate(lam):
        if i % 20 == 7:
            for bad in ((np.nan, 1.0), (1.0, np.inf), (-1.0, 1.0), (1e300, 0.0)):
                *pose, verdict = follow_chain(chain.con, state, LAST2, *bad)
                assert verdict == (Status.NOT_CONVERGED if bad[0] == 1e300 else Status.INVALID_INPUT)
                assert np.isnan(pose).all()
        *pose, verdict = follow_chain(chain.con, state, LAST2, *case)
        assert verdict == Status.CONVERGED
        np.testing.assert_allclose(pose, cold[i], rtol=0, atol=1e-12)


def test_a_model_uses_it():
    """Contract: batch and control step of a model of 20 elements run on this path."""
    model, loads = FiniteElementModel(SLENDER, elements=20, order=1), random_loads(5, seed=2)
    assert isinstance(model._single.fast, Chain)
    pose, _ = solve(chain_of(model), loads)
    np.testing.assert_array_equal(model.solve_batch(loads[:, :2], loads[:, 2:5], tolerance=1e-13).pose, pose)
    *pose, status = model.stepper(tolerance=1e-13)(40.0, 10.0)
    assert status == Status.CONVERGED
    np.testing.assert_allclose(pose, model.solve((40.0, 10.0)).pose, rtol=0, atol=1e-12)


def test_what_it_does_not_take():
    """Contract: coupled sections, more Gauss points than the order and mixed laws need the general path."""
    assert chain_of(FiniteElementModel(SLENDER.replace(neutral_axis_offset=1e-3), 5, 1)) is None
    assert chain_of(FiniteElementModel(SLENDER, 5, 1, gauss=2)) is None
    mixed = FiniteElementModel(SLENDER, 5, 1)
    mixed._single.system[0][2, 7] = 1.0  # Hooke's law in one element alone
    assert chain_of(mixed) is None
