"""The solver's verdict: which equilibrium it finds, whether that is stable, and what it says when there is none.

Two oracles that share nothing with it: shooting with SciPy, continued in small steps from the unloaded state, and the
dense tangent of the reference, whose eigenvalues decide on stability.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import newton, root

from ecm_fast import FiniteElementModel, InputError, Mechanism, NotConverged, Status
from ecm_fast.mechanism.vector import pack
from ecm_fast.models import reference

LADDER = {"length": 0.15, "EA": 7500.0, "GA": 2420.0, "EI": 3.0, "g": 0.0}
LADDER_WRENCH = np.array([-50.0, 40.0, -2.0])
"""The shared problem of the peers; their moment and angle turn x to z, the opposite of ours."""

FINITE_PULLEYS = {"pulley_z": 0.0645, "tendons.pulley_radius": 0.0055}
every_neck = pytest.mark.parametrize(
    ("preset", "pulleys"),
    [
        pytest.param("slender", FINITE_PULLEYS, id="slender-finite"),
        pytest.param("paper", {}, id="paper-point", marks=pytest.mark.slow),
        pytest.param("paper", FINITE_PULLEYS, id="paper-finite", marks=pytest.mark.slow),
        pytest.param("slender", {}, id="slender-point", marks=pytest.mark.slow),
    ],
)
BOX_TWICE = np.array([[-660.0, -160.0, -22.0], [40.0, 160.0, 22.0]])
"""Twice the wrench box of the paper: fx, fz, tau, lowest and highest."""


def shoot(mechanism, root_moment, wrench):
    """Integrate the strong form from the clamp: returns the tip's x, z, theta and the moment missing there."""
    beam = mechanism.beam
    third = 3.0 / beam.EA

    def stretch(N):
        if beam.axial_law == "hooke":
            return 1.0 + N / beam.EA
        g = 1.0
        for _ in range(8):  # Newton for g^3 - 3 N/EA g^2 - 1 = 0, from above -1/3 to rounding
            g -= (g - 1.0 / g**2 - third * N) / (1.0 + 2.0 / g**3)
        return g

    def slopes(_, y):
        c, s = np.cos(y[2]), np.sin(y[2])
        gamma_x = stretch(wrench[0] * c - wrench[1] * s)
        gamma_z = (wrench[0] * s + wrench[1] * c) / beam.GA
        dx, dz = gamma_x * c + gamma_z * s, gamma_z * c - gamma_x * s
        return [dx, dz, y[3] / beam.EI, dx * wrench[1] - dz * wrench[0]]

    start = [0.0, 0.0, 0.0, root_moment]
    y = solve_ivp(slopes, (0.0, beam.length), start, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    return y[:3], y[3] - wrench[2]


def connected_branch(mechanism, wrench, factors):
    """Return the root moments of the branch that grows from the unloaded state, one a load factor."""
    moments = [0.0, 0.0]
    for factor in factors:
        guess = 2.0 * moments[-1] - moments[-2]
        moments.append(
            newton(lambda m, f=factor: shoot(mechanism, m, f * wrench)[1], guess, x1=guess + 0.01, tol=1e-10)
        )
    return moments[2:]


def dead(wrench):
    """Return the reference's loads of a dead wrench alone."""
    return np.array([0.0, 0.0, *wrench, 1.0])


@pytest.mark.parametrize(
    ("factor", "x", "z", "theta", "tolerance"),
    [
        (1.0, 0.1458016623, 0.0288482753, 0.2896190646, 6e-11),
        (5.0, 0.06231, 0.12152, 1.55204, 6e-6),
        (10.0, -0.00730, 0.13352, 2.24373, 6e-6),
        (20.0, -0.06563, 0.13240, 2.85362, 6e-6),
    ],
)
def test_load_ladder_of_the_peers(factor, x, z, theta, tolerance):
    """Shooting, as printed in the survey of peers, to half of its last digit; at 20 there are two more equilibria."""
    model = FiniteElementModel(Mechanism().replace(axial_law="hooke", **LADDER), elements=8)
    pose = model.solve(wrench=factor * LADDER_WRENCH).raise_if_failed().pose
    np.testing.assert_allclose(pose * [1.0, 1.0, -1.0], [x, z, theta], rtol=0.0, atol=tolerance)


@pytest.mark.parametrize(
    ("law", "pose", "root_moment"),
    [
        ("hooke", (0.1458016623, 0.0288482753, 0.2896190646), 9.27448026),
        ("neo-hookean", (0.14580620, 0.02884962, 0.28962505), 9.27472894),
    ],
)
def test_root_moment_of_the_peers(law, pose, root_moment):
    """Shooting, as printed: the clamp's reaction in the reference's residual, for both axial laws."""
    mechanism = Mechanism().replace(axial_law=law, **LADDER)
    eq = FiniteElementModel(mechanism, elements=8).solve(wrench=LADDER_WRENCH).raise_if_failed()
    reaction = reference.residual(reference.named(pack(mechanism)), eq.discretization, dead(LADDER_WRENCH), eq.q)[:3]
    np.testing.assert_allclose(eq.pose * [1.0, 1.0, -1.0], pose, rtol=0.0, atol=6e-9)
    # a gradient of the energy: minus the wrench that the clamp exerts; 1e-9 of rounding, EA times 1e-16 times many
    np.testing.assert_allclose(reaction, [50.0, -40.0, root_moment], rtol=0.0, atol=6e-9)


def test_load_ladder_stays_on_the_connected_branch():
    """Shooting in 40 steps from the unloaded state: the solver finds the same branch at every rung, in one call."""
    mechanism = Mechanism().replace(axial_law="hooke", **LADDER)
    model = FiniteElementModel(mechanism, elements=8)
    factors = np.linspace(0.0, 20.0, 41)[1:]
    moments = connected_branch(mechanism, LADDER_WRENCH, factors)
    for factor, moment in zip(factors, moments, strict=True):
        exact, _ = shoot(mechanism, moment, factor * LADDER_WRENCH)
        # the shooting's own 1e-11, on which a beam bent by 2.9 rad builds; 7e-12 was seen
        np.testing.assert_allclose(model.solve(wrench=factor * LADDER_WRENCH).pose, exact, rtol=0.0, atol=5e-11)


@pytest.mark.slow
def test_dead_wrenches_stay_on_the_connected_branch():
    """Shooting in 20 steps: 25 wrenches of twice the paper's box on the slender neck, half of them past 0.5 rad."""
    mechanism = Mechanism().replace(g=0.0)
    model = FiniteElementModel(mechanism, elements=4)
    bends = []
    for wrench in np.random.default_rng(2).uniform(*BOX_TWICE, (25, 3)):
        moment = connected_branch(mechanism, wrench, np.linspace(0.0, 1.0, 21)[1:])[-1]
        exact, _ = shoot(mechanism, moment, wrench)
        pose = model.solve(wrench=wrench).raise_if_failed().pose
        # the shooting's own 1e-11; 4 elements of order 6 leave less
        np.testing.assert_allclose(pose, exact, rtol=0.0, atol=5e-11)
        bends.append(abs(pose[2]))
    assert np.median(bends) > 0.5


@pytest.mark.parametrize(
    "wrench", [(1864.0, -315.0, 150.0), pytest.param((1212.0, -208.0, 138.0), marks=pytest.mark.slow)]
)
def test_newton_may_not_jump_to_another_stable_branch(wrench):
    """Shooting in 200 steps: Newton at full load, unguarded, ends quietly at a stable coil, a full turn farther."""
    mechanism, wrench = Mechanism().replace(axial_law="hooke", g=0.0), np.array(wrench)
    moment = connected_branch(mechanism, wrench, np.linspace(0.0, 1.0, 201)[1:])[-1]
    exact, _ = shoot(mechanism, moment, wrench)
    pose = FiniteElementModel(mechanism, elements=8).solve(wrench=wrench).raise_if_failed().pose
    # 8 elements of order 6 leave 1.3e-10 where most of the turn is within a few millimeters
    np.testing.assert_allclose(pose, exact, rtol=0.0, atol=1e-9)


def test_branch_that_ends_at_a_fold():
    """Shooting: the root moment misses by f(m, load), and the branch turns back where f = df/dm = 0, at 0.555839."""
    mechanism, wrench = Mechanism().replace(g=0.0), np.array([-941.14, -287.09, -23.1])

    def missing(moment, factor):
        return shoot(mechanism, moment, factor * wrench)[1]

    def fold(y):
        return [missing(*y), (missing(y[0] + 1e-4, y[1]) - missing(y[0] - 1e-4, y[1])) / 2e-4]

    near = connected_branch(mechanism, wrench, np.arange(0.01, 0.5501, 0.01))[-1]
    found = root(fold, [near, 0.55])
    assert found.success

    eq = FiniteElementModel(mechanism, elements=8).solve(wrench=wrench)
    assert eq.status is Status.NOT_CONVERGED
    # the solver's last load step, 1e-8, times at most 2.5, and 1e-9 EA of 547 N: the error of the last iterate's force
    assert abs(eq.load_factor - found.x[1]) < 4e-8
    assert f" {eq.load_factor:.6g} of the load" in eq.message

    # what it leaves in q is the last equilibrium, where the beam has next to no stiffness left in one direction
    p, loads = reference.named(pack(mechanism)), dead(eq.load_factor * wrench)
    assert np.abs(reference.residual(p, eq.discretization, loads, eq.q)[3:]).max() < 1e-8
    softest = np.linalg.eigvalsh(reference.tangent(p, eq.discretization, loads, eq.q)[3:, 3:])[0]
    rest = reference.rest_coordinates(p, eq.discretization)
    unloaded = np.linalg.eigvalsh(reference.tangent(p, eq.discretization, dead([0.0] * 3), rest)[3:, 3:])[0]
    assert 0.0 < softest < 1e-4 * unloaded


@pytest.mark.parametrize("preset", ["paper", "slender"])
@pytest.mark.parametrize("pulleys", [{}, FINITE_PULLEYS], ids=["point", "finite"])
def test_tendons_of_the_paper_never_fail(preset, pulleys):
    """Theory: 160 N of tendon force buckles neither preset, so every one of 100000 pairs is certified as stable."""
    model = FiniteElementModel(Mechanism.preset(preset).replace(**pulleys))
    result = model.solve_batch(np.random.default_rng(0).uniform(0.0, 160.0, (100_000, 2)))
    assert result.counts()["converged"] == 100_000
    assert (result.load_factor == 1.0).all()
    assert np.isfinite(result.pose).all()


@every_neck
def test_verdict_far_outside_the_range(preset, pulleys):
    """Reference: what is called an equilibrium is one, stable where the dense tangent is positive; else it is refused.

    Tendons to 500 N, dead wrenches of twice the box, and axial dead loads, under which the straight neck buckles.
    """
    mechanism = Mechanism.preset(preset).replace(**pulleys)
    model = FiniteElementModel(mechanism)
    p = reference.named(pack(mechanism))
    rng = np.random.default_rng(7)
    lam, wrench = np.zeros((1020, 2)), np.zeros((1020, 3))
    lam[:500] = rng.uniform(0.0, 500.0, (500, 2))
    wrench[500:1000] = rng.uniform(*BOX_TWICE, (500, 3))
    wrench[1000:, 0] = -rng.uniform(0.0, 4000.0, 20)
    result = model.solve_batch(lam, wrench)
    failed = ~result.converged
    assert failed.mean() < 0.01
    assert (result.load_factor[~result.stable] < 1.0).all()
    assert (result.load_factor[result.stable] == 1.0).all()
    assert np.isnan(result.pose[failed]).all()
    assert np.isfinite(result.pose[~failed]).all()

    seen = set()
    for case in [*range(0, 1000, 50), *range(1000, 1020), *np.flatnonzero(failed)]:
        eq = model.solve(lam[case], wrench[case])
        seen.add(eq.status)
        loads = np.array([*lam[case], *wrench[case], 1.0])
        if not eq.converged:
            loads *= eq.load_factor
        # residuals are differences of forces up to 2 kN times the slopes of shape functions: 1e-16 times 1e5 for one
        # element of order 5; they grow as the square of the order, and with the number of elements
        rounding = 4e-11 * eq.discretization.order**2 * eq.discretization.n_elements
        # the condensed path inverts the axial law by polynomials, which hold to 1e-12 of EA
        rounding += 1e-12 * mechanism.beam.EA
        assert np.abs(reference.residual(p, eq.discretization, loads, eq.q)[3:]).max() < rounding
        eigenvalues = np.linalg.eigvalsh(reference.tangent(p, eq.discretization, loads, eq.q)[3:, 3:])
        assert (eigenvalues[0] > 0.0) == (eq.status is not Status.UNSTABLE)
    assert {Status.CONVERGED, Status.UNSTABLE} <= seen


@pytest.mark.slow
@every_neck
def test_one_call_agrees_with_fine_load_steps(preset, pulleys):
    """Reference: plain Newton led from the unloaded state in 15 small steps ends at the same equilibrium."""
    mechanism = Mechanism.preset(preset).replace(**pulleys)
    model = FiniteElementModel(mechanism)
    p, rng = reference.named(pack(mechanism)), np.random.default_rng(3)
    for case in range(4):
        lam, wrench = rng.uniform(0.0, 350.0, 2), rng.uniform(*BOX_TWICE)
        lam, wrench = (lam, 0.0 * wrench) if case % 2 else (0.0 * lam, wrench)
        q, _ = reference.solve(p, model.discretization, np.array([*lam, *wrench, 1.0]), load_steps=15)
        # both end with a step below 1e-9, which Newton squares once more, so that rounding is left
        np.testing.assert_allclose(model.solve(lam, wrench).raise_if_failed().q, q, rtol=0.0, atol=1e-13)


def test_tendon_pulled_up_to_its_pulley():
    """Geometry: far beyond the range a plate's end meets its pulley, where the branch ends, and the message says so."""
    mechanism = Mechanism.preset("slender")
    model = FiniteElementModel(mechanism)
    lam = np.random.default_rng(0).uniform(0.0, 1000.0, (200, 2))
    result = model.solve_batch(lam)
    short = np.flatnonzero(result.status == Status.TENDON_ZERO_LENGTH)
    assert 50 < short.size < 150
    p = reference.named(pack(mechanism))
    for case in short[:20]:
        eq = model.solve(lam[case])
        assert eq.status is Status.TENDON_ZERO_LENGTH
        assert 0.0 < eq.load_factor < 1.0
        free = [reference.tendon(p, side, eq.q[-3:])[2] for side in (-1.0, 1.0)]
        # it shrinks with the square root of the load that is missing: a twentieth of the beam is the last of it
        assert min(free) < 0.05 * mechanism.beam.length
        assert f"at {eq.load_factor:.6g} of the load a tendon is pulled up to its pulley" in eq.message


@pytest.mark.parametrize(
    ("alpha", "w", "u", "theta"),
    [
        (1.0, 0.30172, 0.05643, 0.46135),
        (2.0, 0.49346, 0.16064, 0.78175),
        (5.0, 0.71379, 0.38763, 1.21537),
        (10.0, 0.81061, 0.55500, 1.43029),
    ],
)
def test_elastica_cantilever(alpha, w, u, theta):
    """Mattiasson 1981, five digits: EA = GA = 1e5 EI / L^2 stretches by alpha / EA, 1e-4, which is taken off again."""
    mechanism = Mechanism().replace(length=1.0, EI=1.0, EA=1e5, GA=1e5, axial_law="hooke", g=0.0)
    eq = FiniteElementModel(mechanism, elements=8).solve(wrench=(0.0, alpha, 0.0)).raise_if_failed()
    expected = [1.0 - u, w + alpha / 1e5, -theta]
    np.testing.assert_allclose(eq.pose, expected, rtol=0.0, atol=6e-6)


def test_clamped_beam_of_geradin():
    """Geradin & Cardona, Simpson & Palacios 2013: L = 5 m under 600 kN; digits as re-derived in the survey of peers."""
    mechanism = Mechanism().replace(length=5.0, EI=9.346e6, GA=3.231e8, EA=4.8e8, axial_law="hooke", g=0.0)
    eq = FiniteElementModel(mechanism, elements=4).solve(wrench=(0.0, -600e3, 0.0)).raise_if_failed()
    np.testing.assert_allclose([eq.z, 5.0 - eq.x, eq.theta], [-2.1597, 0.5965, 0.6720], rtol=0.0, atol=5e-5)


@pytest.mark.parametrize(
    ("EA", "GA", "x", "z"),
    [(5.0, 1.0, 4.60760, -5.24233), (1e3, 1e3, 4.97853457, -3.46763571 - 20.0 / np.pi / 1e3 / 2.0)],
    ids=["simo", "inextensible"],
)
def test_cantilever_under_force_and_moment(EA, GA, x, z):
    """Harsch 2021, P = 10 EI / L^2 down and M = 2.5 P up; EA = GA lowers the inextensible tip by P L / EA more."""
    length, EI = 2.0 * np.pi, 2.0
    force = 10.0 * EI / length**2
    mechanism = Mechanism().replace(length=length, EI=EI, EA=EA, GA=GA, axial_law="hooke", g=0.0)
    eq = FiniteElementModel(mechanism, elements=8).solve(wrench=(0.0, -force, -2.5 * force)).raise_if_failed()
    np.testing.assert_allclose([eq.x, eq.z], [x, z], rtol=0.0, atol=6e-6)


def test_load_that_is_not_finite_is_refused_by_name():
    """Contract: `solve` raises InputError and names the load."""
    model = FiniteElementModel()
    for lam, wrench, name in [
        ((np.nan, 1.0), (0.0, 0.0, 0.0), "lam_l = nan"),
        ((1.0, np.inf), (0.0, 0.0, 0.0), "lam_r = inf"),
        ((1.0, 1.0), (np.inf, 0.0, 0.0), "fx = inf"),
        ((1.0, 1.0), (0.0, np.nan, 0.0), "fz = nan"),
        ((1.0, 1.0), (0.0, 0.0, -np.inf), "tau = -inf"),
    ]:
        with pytest.raises(InputError, match=f"^{name}: allowed is a finite number$"):
            model.solve(lam, wrench)


def test_load_that_is_not_finite_spoils_its_own_case_alone():
    """Contract: `solve_batch` gives that case a status and a pose of nan; its neighbors are as in a clean batch."""
    model, rng = FiniteElementModel(), np.random.default_rng(1)
    lam, wrench = rng.uniform(0.0, 160.0, (9, 2)), rng.normal(size=(9, 3)) * [50.0, 20.0, 3.0]
    clean = model.solve_batch(lam, wrench)
    lam[1, 0], lam[4, 1], wrench[6, 2] = np.nan, np.inf, -np.inf
    spoiled = model.solve_batch(lam, wrench)
    bad = np.isin(np.arange(9), (1, 4, 6))
    assert (spoiled.status == np.where(bad, Status.INVALID_INPUT, Status.CONVERGED)).all()
    assert np.isnan(spoiled.pose[bad]).all()
    np.testing.assert_allclose(spoiled.pose[~bad], clean.pose[~bad], rtol=0.0, atol=1e-15)
    assert "not a finite number" in Status(spoiled.status[1]).explain()


def test_tendon_that_pushes_is_refused():
    """Contract: a negative force names its row and its tendon."""
    model = FiniteElementModel()
    with pytest.raises(InputError, match=r"^lam_l = -1.0 N in row 0: allowed is >= 0"):
        model.solve((-1.0, 5.0))
    with pytest.raises(InputError, match=r"^lam_r = -3.0 N in row 2: allowed is >= 0"):
        model.solve_batch([[1.0, 2.0], [0.0, 0.0], [4.0, -3.0]])


def test_shapes_are_refused():
    """Contract: what was given and what is allowed."""
    model = FiniteElementModel()
    with pytest.raises(InputError, match=r"shape .*3.*: allowed is two"):
        model.solve((1.0, 2.0, 3.0))
    with pytest.raises(InputError, match=r"shape .*2.*: allowed is \(4, 3\)"):
        model.solve_batch(np.zeros((4, 2)), (1.0, 2.0))
    with pytest.raises(InputError, match=r"parameters has shape \(3, 1\): allowed is \(4, \d+\)"):
        model.solve_batch(np.zeros((4, 2)), parameters=np.zeros((3, 1)))


def test_failed_solve_gives_no_number():
    """Contract: pose and derivatives are nan, `raise_if_failed` raises with the message, and returns a stable solve."""
    model = FiniteElementModel(Mechanism().replace(g=0.0))
    eq = model.solve(wrench=(-941.14, -287.09, -23.1))
    assert not eq.converged
    assert np.isnan(np.hstack([eq.pose[:, None], eq.jacobian, eq.compliance])).all()
    with pytest.raises(NotConverged) as caught:
        eq.raise_if_failed()
    assert str(caught.value) == eq.message
    good = model.solve((10.0, 0.0))
    assert good.raise_if_failed() is good
    with pytest.raises(NotConverged, match=r"buckling load at 0\.539048 of its size"):  # 539.048 N: the closed form
        model.solve(wrench=(-1000.0, 0.0, 0.0)).raise_if_failed()
