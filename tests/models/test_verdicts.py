"""The verdict on a solve: what a load factor counts, what ends a branch, and what is refused."""

import numpy as np
import pytest
from scipy.optimize import brentq

import ecm_fast as ecm
from ecm_fast import FiniteElementModel, InputError, Mechanism, Status
from ecm_fast.kernels.condensed.step_memory import MOST_STEPS
from ecm_fast.kernels.layout import O_ITERATIONS
from ecm_fast.mechanism.derived import limits
from ecm_fast.mechanism.parameters import index
from ecm_fast.mechanism.vector import pack

BARE = Mechanism.preset("slender").replace(mass_per_length=0.0, **{"head.mass": 0.0})
STRIP = BARE.replace(length=0.1, EA=120.0, GA=33.3, EI=1e-4)
LONG = Mechanism.preset("slender").replace(length=0.4)
G = 9.81


def stretch(N: float, EA: float) -> float:
    """Stretch of the neo-Hookean law under an axial force."""
    return brentq(lambda g: EA / 3.0 * (g - g**-2) - N, 0.05, 1e3, xtol=1e-15)


def critical(neck: Mechanism, *, tension: bool = False) -> float:
    """Axial dead load at which a straight clamped column with shear turns aside.

    N theta (g - N/GA) is the moment that turns a section by theta, so EI theta'' = N (g - N/GA) theta: under pressure
    N < 0, and under tension where N > GA g, the solution is a quarter of a sine wave.
    """
    EA, GA, EI, length = neck.beam.EA, neck.beam.GA, neck.beam.EI, neck.beam.length
    sign = 1.0 if tension else -1.0

    def excess(P: float) -> float:
        N = sign * P
        return N * (N / GA - stretch(N, EA)) - (0.5 * np.pi / length) ** 2 * EI

    low = brentq(lambda N: N - GA * stretch(N, EA), 1e-3 * GA, 100.0 * GA) if tension else 1e-9
    return brentq(excess, low, 10.0 * GA, xtol=1e-12)


# What ends a branch


@pytest.mark.parametrize("wrench", [(75.0, 0.0, 0.0), (200.0, 0.0, 0.0)])
def test_tension_beyond_the_laws_own_stability(wrench):
    """Closed form: under tension the strip turns aside where N (N/GA - g) = (pi / 2 L)^2 EI."""
    model = FiniteElementModel(STRIP)
    eq = model.solve(wrench=wrench)
    assert eq.status is Status.SECTION_UNSTABLE
    assert abs(eq.load_factor * wrench[0] / critical(STRIP, tension=True) - 1.0) < 1e-6
    assert "N > GA gamma_x" in eq.message
    assert "shear_compression" in eq.message
    assert not eq.converged
    assert model.solve_batch([(0.0, 0.0)], wrench).status.tolist() == [Status.SECTION_UNSTABLE]


def test_a_shear_stiffness_that_grows_holds_the_tension():
    """Closed form: with Q = (GA + N) gamma_z a pulled strip is stable, as N < (GA + N) g always; x = L g(N)."""
    eq = FiniteElementModel(STRIP.replace(shear_compression=1.0)).solve(wrench=(75.0, 0.0, 0.0))
    assert eq.stable
    assert abs(eq.x - 0.1 * stretch(75.0, 120.0)) < 1e-9
    assert abs(eq.theta) < 1e-9


def test_a_column_under_pressure_is_no_law_that_fails():
    """Closed form: the shear-flexible column buckles where P (g + P/GA) = (pi / 2 L)^2 EI."""
    eq = FiniteElementModel(BARE).solve(wrench=(-600.0, 0.0, 0.0))
    assert eq.status is Status.UNSTABLE
    assert abs(eq.load_factor * 600.0 / critical(BARE) - 1.0) < 1e-6


def test_a_law_that_loses_its_stiffness_is_told_as_such():
    """Closed form: M = EI u (1 - a u^2) is largest at u^2 = 1/(3 a), M = 2/3 EI u; no couple is larger."""
    a, EI = 0.002, BARE.beam.EI
    largest = 2.0 / 3.0 * EI / np.sqrt(3.0 * a)
    eq = FiniteElementModel(BARE.replace(bending_cubic=-a)).solve(wrench=(0.0, 0.0, 1.3 * largest))
    assert eq.status is Status.SECTION_UNSTABLE
    assert abs(1.3 * eq.load_factor - 1.0) < 1e-4


# What a load factor counts


@pytest.mark.parametrize("times", [0.55, 1.0, 5.0])
def test_the_load_factor_counts_the_load_alone(times):
    """Closed form: a head of half the critical load leaves half of it for the wrench, whatever wrench is asked for."""
    load = critical(BARE)
    neck = BARE.replace(**{"head.mass": 0.5 * load / G, "head.h": 0.0})
    eq = FiniteElementModel(neck).solve(wrench=(-times * load, 0.0, 0.0))
    assert eq.status is Status.UNSTABLE
    assert abs(eq.load_factor * times - 0.5) < 1e-6
    assert eq.preload_factor == 1.0


def test_a_neck_that_its_own_weight_buckles():
    """Closed form: a head of 1.1 critical loads; lifted by 0.2 of them the neck stands."""
    load = critical(BARE)
    model = FiniteElementModel(BARE.replace(**{"head.mass": 1.1 * load / G, "head.h": 0.0}))
    eq = model.solve((10.0, 10.0))
    assert eq.status is Status.UNSTABLE
    assert eq.load_factor == 0.0
    assert abs(1.1 * eq.preload_factor - 1.0) < 1e-6
    assert f"at {eq.preload_factor:.6g} of its own weight" in eq.message
    assert "lower the load" not in eq.message
    lifted = model.solve(wrench=(0.2 * load, 0.0, 0.0))
    assert lifted.stable
    assert lifted.load_factor == 1.0
    batch = model.solve_batch([(10.0, 10.0), (0.0, 0.0)], [[0.0, 0.0, 0.0], [0.2 * load, 0.0, 0.0]])
    assert batch.load_factor.tolist() == [0.0, 1.0]
    assert abs(1.1 * batch.preload_factor[0] - 1.0) < 1e-6
    assert batch.preload_factor[1] == 1.0


@pytest.fixture
def bent():
    """Yield the name of a law that bends the section by itself: M + a (kappa^3 - 20^3)."""

    def law(a, gamma_x, gamma_z, kappa, place):
        return 0.0 * a, 0.0 * a, a * (kappa * kappa * kappa - 8000.0)

    ecm.effect("bent_by_itself", unit="N m^4", typical=1e-2, bounds=(-100.0, 100.0), enters="section")(law)
    yield "bent_by_itself"
    ecm.remove_effect("bent_by_itself")


@pytest.mark.parametrize("size", [1e-4, 1e-3, 1e-2, 1.0])
def test_a_law_that_strains_the_neck_without_load(bent, size):
    """Closed form: without load the couple is none, EI k + a (k^3 - 20^3) = 0, and the neck lies on a circle."""
    neck = BARE.replace(**{bent: size})
    eq = FiniteElementModel(neck).solve()
    kappa = brentq(lambda k: 3.0 * k + size * (k**3 - 8000.0), 0.0, 21.0, xtol=1e-14)
    angle = kappa * 0.109
    assert eq.stable
    exact = np.array([np.sin(angle) / kappa, (np.cos(angle) - 1.0) / kappa, angle])
    assert np.abs(eq.pose - exact).max() < 1e-6


def test_a_law_that_no_section_carries(bent):
    """Closed form: with a < 0 the couple 3 k + a (k^3 - 20^3) has its zero at a curvature where it falls, unstable."""
    eq = FiniteElementModel(BARE.replace(**{bent: -0.1})).solve((5.0, 5.0))
    assert not eq.converged
    assert eq.load_factor == eq.preload_factor == 0.0
    assert "even without tendon forces, wrench and weight" in eq.message
    assert "lower the load" not in eq.message


# Pulleys


@pytest.mark.parametrize("solve", ["solve", "batch", "stepper"])
def test_pulleys_beyond_the_plate_are_passed_outside(solve):
    """Statics of a straight column: tendons that leave the pulleys outside run parallel to it, and pull by 2 lam."""
    model = FiniteElementModel(BARE.replace(pulley_x=0.2, pulley_radius=0.01, pulley_z=0.06))
    pose = {
        "solve": lambda: model.solve((50.0, 50.0)).pose,
        "batch": lambda: model.solve_batch([(50.0, 50.0)]).pose[0],
        "stepper": lambda: np.array(model.stepper()(50.0, 50.0)[:3]),
    }[solve]()
    assert abs(pose[0] - 0.109 * stretch(100.0, 7500.0)) < 1e-9
    assert np.abs(pose[1:]).max() < 1e-12


def test_one_tendon_to_a_pulley_beyond_the_plate():
    """Closed form: a small pull at the lever d turns the tip by lam d L / EI, and moves it by -lam d L^2 / (2 EI)."""
    model = FiniteElementModel(BARE.replace(pulley_x=0.2, pulley_radius=0.01, pulley_z=0.06))
    _, z, theta = model.solve((1e-3, 0.0)).pose
    assert abs(theta / (1e-3 * 0.07 * 0.109 / 3.0) - 1.0) < 1e-4
    assert abs(z / (-1e-3 * 0.07 * 0.109**2 / 6.0) - 1.0) < 1e-4


# What is refused


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"pulley_radius": 0.005, "effects.pulley_radius": -0.006},
         "tendons.pulley_radius + effects.pulley_radius = -0.001 m: allowed is 0 or more"),
        ({"effects.beam_length": -0.2}, "beam.length + effects.beam_length = -0.091 m: allowed is a number above 0"),
        ({"beam_mass": -10.0}, "beam.mass_per_length + effects.beam_mass = -0.53 kg/m: allowed is 0 or more"),
        ({"head_mass": -1.5}, "head.mass + effects.head_mass = -0.5 kg: allowed is 0 or more"),
        ({"force_gain": -0.5, "force_gain_asymmetry": 1.2},
         "1 + effects.force_gain - effects.force_gain_asymmetry/2 = -0.1: allowed is a number above 0"),
        ({"bonded_ends.size": -0.8, "bonded_ends.decay": 10.0},
         "1 + effects.bonded_ends.size (1 + exp(-length/effects.bonded_ends.decay)) = -0.591327: allowed is a number "
         "above 0"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)  # fmt: skip
def test_what_parameters_make_together_must_be_possible(changes, text):
    """Arithmetic: each value is within its own bounds, their sum is not."""
    with pytest.raises(InputError) as refused:
        Mechanism.preset("slender").replace(**changes)
    assert str(refused.value) == text
    row = pack(Mechanism.preset("slender"))
    for name, value in changes.items():
        row[index(name)] = value
    result = FiniteElementModel().solve_batch([(10.0, 5.0)] * 2, parameters=np.stack([pack(Mechanism()), row]))
    assert result.status.tolist() == [Status.CONVERGED, Status.INVALID_INPUT]
    assert np.isnan(result.pose[1]).all()


def test_limits_are_where_the_sum_becomes_impossible():
    """Arithmetic: what a fit may reach of one parameter while the others stay."""
    neck = Mechanism.preset("slender").replace(pulley_radius=0.005)
    assert limits("effects.pulley_radius", pack(neck))[0] == pytest.approx(-0.005, abs=1e-15)
    assert limits("effects.head_mass", pack(neck))[0] == pytest.approx(-1.0, abs=1e-15)
    assert limits("effects.beam_length", pack(neck))[0] == pytest.approx(-0.109, abs=1.1e-6)
    assert limits("effects.force_gain_asymmetry", pack(neck.replace(force_gain=-0.5))) == pytest.approx(
        (-1.0, 1.0), abs=1e-5
    )
    assert limits("EI", pack(neck)) == (1e-12, 1e15)


@pytest.mark.parametrize(
    ("changes", "bad"),
    [
        ({"force_zero": -100.0}, (50.0, 120.0)),
        ({"force_crosstalk": -0.9}, (20.0, 120.0)),
        ({"force_nonlinearity": -0.9}, (20.0, 300.0)),
        ({"force_zero_asymmetry": 60.0}, (50.0, 10.0)),
    ],
    ids=["zero", "crosstalk", "nonlinearity", "asymmetry"],
)
def test_a_reading_that_makes_a_tendon_push(changes, bad):
    """Arithmetic of the catalogue's law of the force cells: a force below -10 N is no error of a reading near zero."""
    model, good = FiniteElementModel(BARE.replace(**changes)), (130.0, 125.0)
    step = model.stepper()
    assert model.solve(bad).status is Status.INVALID_INPUT
    assert "push" in model.solve(bad).message
    assert model.solve_batch([good, bad]).status.tolist() == [Status.CONVERGED, Status.INVALID_INPUT]
    assert model.sensitivities(["EI"], [good, bad]).status.tolist() == [Status.CONVERGED, Status.INVALID_INPUT]
    assert step(*good)[3] == Status.CONVERGED
    assert step(*bad)[3] == Status.INVALID_INPUT
    assert step(*good)[3] == Status.CONVERGED


def test_an_axial_law_in_between_is_none():
    """The paper has two axial laws, numbered 0 and 1."""
    par = np.stack([pack(BARE)] * 2)
    par[1, index("beam.axial_law")] = 0.5
    with pytest.raises(
        InputError, match=r"^row 1 of parameters: beam.axial_law = 0.5: allowed is 0 \(neo-hookean\) or 1"
    ):
        FiniteElementModel(BARE).solve_batch([(1.0, 1.0)] * 2, parameters=par)


def test_a_stiffness_that_has_drifted_away():
    """Arithmetic: EA, GA, EI (1 + a t) with a = -0.1 per hour are nothing left after ten hours."""
    columns = {"lam_l_N": [10.0] * 3, "lam_r_N": [5.0] * 3, "t_s": [0.0, 3600.0 * 9.0, 3600.0 * 11.0]}
    found = ecm.predict(BARE.replace(stiffness_drift=-0.1), ecm.Measurements.from_columns(columns))
    assert found.status.tolist() == [Status.CONVERGED, Status.CONVERGED, Status.INVALID_INPUT]


# The control step


@pytest.mark.parametrize("order", [3, 5])
def test_a_failing_step_is_bounded_and_never_wrong(order):
    """Batches, each case from the unloaded neck: a step's verdict is the same, or that it was not finished."""
    model = FiniteElementModel(order=order)
    step, rng = model.stepper(), np.random.default_rng(1)
    memory, places = step._core.system
    iterations = places["out"] + O_ITERATIONS
    lam = np.concatenate([rng.uniform(0.0, 3000.0, (500, 2)), 10.0 ** rng.uniform(-3.0, 6.0, (500, 2))])
    alone = model.solve_batch(lam)
    for i, forces in enumerate(lam.tolist()):
        memory[iterations] = 0.0
        *pose, status = step(*forces)
        assert memory[iterations] <= MOST_STEPS
        assert status in (alone.status[i], Status.NOT_CONVERGED)
        assert np.isfinite(pose).all() == (status == Status.CONVERGED)
        if status == Status.CONVERGED:
            assert np.abs(pose - alone.pose[i]).max() < 1e-8


def test_what_a_call_does_not_finish_the_next_ones_do():
    """`model.solve`, which follows the load as far as it takes: loads that are held are reached call by call."""
    model = FiniteElementModel(LONG, order=5)
    eq = model.solve((78.0, 80.0))
    assert eq.stable
    pose, calls = held(model.stepper(), (78.0, 80.0))
    assert calls > 1
    assert np.abs(pose - eq.pose).max() < 1e-8


def held(step, lam):
    """Hold tendon forces until the step has their equilibrium; returns the pose and how many calls that took."""
    for calls in range(1, 200):
        *pose, status = step(*lam)
        if status == Status.CONVERGED:
            return np.array(pose), calls
        assert status == Status.NOT_CONVERGED
    raise AssertionError(lam)


def test_a_step_says_whether_it_followed_the_calls_before():
    """Hysteresis of a neck that co-contraction has buckled: two states are stable under (80.5, 79.5) N."""
    model = FiniteElementModel(LONG, order=5)
    step, fresh = model.stepper(), model.stepper()
    held(step, (78.0, 80.0))
    assert held(step, (80.5, 79.5))[0][1] < -0.2
    assert step.followed
    pose, _ = held(fresh, (80.5, 79.5))
    assert pose[1] > 0.2
    assert np.abs(pose - model.solve((80.5, 79.5)).pose).max() < 1e-8
    slender = FiniteElementModel(order=5).stepper()
    assert slender(40.0, 10.0)[3] == Status.CONVERGED
    assert not slender.followed
    assert slender(41.0, 10.0)[3] == Status.CONVERGED
    assert slender.followed
