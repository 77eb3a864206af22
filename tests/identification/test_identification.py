"""Identification: closed forms of the axial law, a truth made by the test bed, SciPy on the same sum, statistics."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import integrate, optimize, stats

from ecm_fast import FiniteElementModel, Mechanism, fit_compression, fit_shear, identify
from ecm_fast.data import datasets
from ecm_fast.data.measurements import Measurements
from ecm_fast.errors import InputError
from ecm_fast.identification.least_squares import Loss, minimize
from ecm_fast.models.instruments.prediction import predict
from ecm_fast.testbed import (
    Sensors,
    compression_test,
    equilibria,
    in_sequence,
    mass_test,
    readings,
    shear_test,
    tendon_test,
    tilt_test,
)

pytestmark = pytest.mark.slow

STIFFNESSES = ["EA", "GA", "EI"]
OFF = {"EA": 7000.0, "GA": 2800.0, "EI": 2.7}
EXACT = Sensors.perfect()
BESIDE = Path(__file__).resolve().parents[3] / "shared" / "data" / "measured"
MEASURED = Path(os.environ.get("ECM_FAST_MEASURED", BESIDE))
"""Data of others that this project does not copy: a folder beside the checkout, or named in the environment."""


def push(g):
    """Return the neo-Hookean force of a unit stiffness at the stretch g, (19)."""
    return (g - g**-2.0) / 3.0


def stretches(forces):
    """Return the neo-Hookean stretches of a unit stiffness."""
    return np.array([optimize.brentq(lambda g, N=N: push(g) - N, 0.1, 10.0, xtol=1e-15) for N in forces])


def sampled(neck, loads, sensors=None, seed=0):
    return readings(neck, equilibria(neck, loads).raise_if_failed(), sensors, seed)


@pytest.fixture(scope="module")
def tendons():
    """Return 80 tendon loads on the slender neck and their equilibria, found by the test bed."""
    return equilibria(Mechanism(), tendon_test(80, seed=5)).raise_if_failed()


# The paper's compression test, Table 1


def test_hooke_overestimates_an_exact_neo_hookean_specimen():
    """Closed form: a ratio of two sums over the exact positions."""
    # Hooke's x is L (1 + N / EA_H), so that (42) is linear in 1 / EA_H: a ratio of two sums, or of two integrals
    stretch = np.linspace(1.0, 0.8, 41)
    n = push(stretch)
    sums = (n @ n) / (n @ (stretch - 1.0))
    for length in (0.028, 0.040):
        specimen, pushes = compression_test(length, n=41)
        np.testing.assert_allclose(pushes.fx, 7500.0 * n, rtol=1e-12)
        found = fit_compression(specimen.replace(EA=6000.0), sampled(specimen, pushes, EXACT))
        assert found.neo_hookean["EA"].value == pytest.approx(7500.0, rel=1e-9)
        assert found.ratio == pytest.approx(sums, rel=1e-8)
        assert found.neo_hookean.rms["x_m"] < 1e-9 < found.hooke.rms["x_m"]
        assert "EA_" not in repr(found)
        assert "ratio 1.196" in repr(found)


def test_the_ratio_tends_to_its_closed_form():
    """Closed form: a ratio of two integrals, by SciPy's quad."""
    specimen, pushes = compression_test(0.040, n=2001)
    middle = 0.5 * (pushes.fx[1:] + pushes.fx[:-1])  # midpoints have no weight too many at the ends
    data = Measurements.from_columns({"fx_N": middle, "x_m": 0.040 * stretches(middle / 7500.0)})
    squares = integrate.quad(lambda g: push(g) ** 2, 0.8, 1.0)[0]
    product = integrate.quad(lambda g: push(g) * (g - 1.0), 0.8, 1.0)[0]
    assert squares / product == pytest.approx(1.1932, abs=5e-5)
    assert fit_compression(specimen, data).ratio == pytest.approx(squares / product, rel=1e-6)


def test_both_specimens_share_one_stiffness():
    """Closed form: the weighted mean of two estimates."""
    sets = [(*datasets.load(f"simulated_compression_{length}"), ("x",)) for length in ("28mm", "40mm")]
    alone = [identify(*entry[:2], ["EA"], channels=("x",))["EA"] for entry in sets]
    weights = np.array([estimate.std**-2.0 for estimate in alone])
    both = identify(sets, ["EA"])
    mean = weights @ [estimate.value for estimate in alone] / weights.sum()  # exact where x is linear in EA
    assert both["EA"].value == pytest.approx(mean, abs=0.05 * both["EA"].std)
    assert both["EA"].std == pytest.approx(weights.sum() ** -0.5, rel=0.01)
    assert [found.beam.length for found in both.mechanisms] == [0.028, 0.040]
    assert {found.beam.EA for found in both.mechanisms} == {both["EA"].value}
    assert both.rows == 82


@pytest.mark.skipif(not MEASURED.exists(), reason=f"{MEASURED} with measurements of others is not here")
def test_measured_silicone_is_neo_hookean():
    """Published: measurements of Meunier et al. 2008."""
    # Meunier, Chagnon, Favier, Orgeas & Vacher, Polymer Testing 27 (2008) 765-777; stretch, nominal stress [MPa]
    rows = np.loadtxt(MEASURED / "meunier2008_silicone_uniaxial.csv", delimiter=",", comments="#", skiprows=5)
    rows = rows[(rows[:, 0] >= 0.78) & (rows[:, 0] <= 1.0)]
    assert len(rows) == 5
    length, area = 0.028, 8.610e-3
    specimen = Mechanism().replace(length=length, mass_per_length=0.0, **{"head.mass": 0.0})
    columns = {"fx_N": 1e6 * area * rows[:, 1], "x_m": length * rows[:, 0]}
    found = fit_compression(specimen, Measurements.from_columns(columns))
    stretch, stress = rows.T
    neo_hookean = optimize.minimize_scalar(
        lambda E: np.sum((stretches(stress / E) - stretch) ** 2), bounds=(0.5, 2.0), options={"xatol": 1e-9}
    )
    hooke = (stress @ stress) / (stress @ (stretch - 1.0))  # MPa
    assert found.neo_hookean["EA"].value / area / 1e6 == pytest.approx(neo_hookean.x, rel=1e-5)
    assert found.hooke["EA"].value / area / 1e6 == pytest.approx(hooke, rel=1e-7)
    assert found.neo_hookean.rms["x_m"] < 0.6 * found.hooke.rms["x_m"]
    assert 1.15 < found.ratio < 1.30


# Recovery, and what the numbers claim


def test_recovery_from_the_test_bed_to_the_solver_s_last_digits(tendons):
    """Known truth of the test bed, without noise."""
    data = readings(Mechanism(), tendons, EXACT)
    fit = identify(Mechanism().replace(**OFF), data, STIFFNESSES)
    np.testing.assert_allclose(fit.values, [7500.0, 2420.0, 3.0], rtol=2e-6)
    assert fit.settled
    assert set(fit.noise.values()) == {"residual"}
    assert fit.mechanism == Mechanism().replace(**dict(zip(STIFFNESSES, fit.values.tolist(), strict=True)))


def test_recovery_with_noise_within_the_intervals_stated():
    """Known truth of the bundled simulated sets."""
    neck, data = datasets.load("simulated_slender_tendon")
    shear = datasets.load("simulated_slender_shear")[1]
    fit = identify(neck.replace(**OFF), [data, shear], STIFFNESSES, level=0.999)
    for name, truth in {"EA": 7500.0, "GA": 2420.0, "EI": 3.0}.items():
        assert fit[name].lower < truth < fit[name].upper
    assert (fit.rows, len(fit.residual), fit.left_out, fit.warnings) == (324, 324, (), ())
    np.testing.assert_allclose(fit.residual[:300], predict(fit.mechanism, data).residual, atol=1e-9)
    assert fit.rms["x_m"] == pytest.approx(np.sqrt(np.mean(fit.residual[:, 0] ** 2)))


def test_parameters_of_every_kind_from_a_mix_of_experiments():
    """Known truth of the test bed, without noise."""
    hidden = {"EA": 7300.0, "EI": 2.9, "head.mass": 1.3, "precurvature": 0.15, "pulley_x": 3e-3}
    truth = Mechanism().replace(**hidden)
    loads = in_sequence(
        tendon_test(30, seed=2),
        shear_test([-20.0, 20.0]),
        mass_test([0.0, 1.0, 2.0], [(20.0, 0.0), (60.0, 50.0)]),
        tilt_test([-0.5, 0.5], [(0.0, 0.0), (40.0, 0.0)]),
    )
    found = identify(Mechanism(), sampled(truth, loads, EXACT), list(hidden))
    np.testing.assert_allclose(found.values, list(hidden.values()), rtol=1e-5)


def test_the_shear_test_counts_z_and_theta_alone():
    """Contract: spoilt x changes nothing."""
    neck, data = datasets.load("simulated_slender_shear")
    spoilt = replace(data, x=data.x + 5e-3)
    fit = fit_shear(neck.replace(GA=2000.0, EI=3.3), spoilt)
    np.testing.assert_array_equal(fit.values, fit_shear(neck.replace(GA=2000.0, EI=3.3), data).values)
    assert abs(fit["EI"].value - 3.0) < 3.0 * fit["EI"].std
    assert set(fit.noise) == {"z", "theta"}
    assert fit.rms["x_m"] > 4e-3


def covered(tendons, sensors, count=500, **options):
    """Return how often each of three 90 % intervals holds the truth, and the mean of squared errors in variances."""
    hits, squares = np.zeros(3), np.zeros(3)
    for seed in range(count):
        fit = identify(Mechanism(), readings(Mechanism(), tendons, sensors, seed), STIFFNESSES, **options)
        for i, (name, truth) in enumerate(zip(STIFFNESSES, (7500.0, 2420.0, 3.0), strict=True)):
            hits[i] += fit[name].lower < truth < fit[name].upper
            squares[i] += ((fit[name].value - truth) / fit[name].std) ** 2
    return hits / count, squares / count


def test_intervals_hold_the_truth_as_often_as_they_claim():
    """Binomial: 500 simulated campaigns."""
    # a shear test beside the tendons, so that GA is seen well enough for an interval that is no more than a parabola
    loads = in_sequence(tendon_test(40, seed=5), shear_test(np.linspace(-60.0, 60.0, 20)))
    held, squares = covered(equilibria(Mechanism(), loads).raise_if_failed(), Sensors())
    assert np.all((held > 0.87) & (held < 0.93)), held
    assert np.all((squares > 0.8) & (squares < 1.25)), squares


def test_force_noise_widens_the_intervals_as_it_must():
    """Binomial: 500 simulated campaigns."""
    loads = in_sequence(tendon_test(40, seed=5), shear_test(np.linspace(-60.0, 60.0, 20)))
    found = equilibria(Mechanism(), loads).raise_if_failed()
    sensors = Sensors(camera_sigma=(2e-5, 2e-5, 2e-4), force_sigma=0.3)
    held, _ = covered(found, sensors)
    assert np.all((held > 0.87) & (held < 0.93)), held
    deaf, _ = covered(found, sensors, count=100, force_sigma=0.0)
    assert deaf.min() < 0.7
    fit = identify(Mechanism(), readings(Mechanism(), found, sensors), STIFFNESSES, force_sigma=0.0)
    assert any("times the noise" in text for text in fit.warnings)


def test_the_profile_of_a_parabola_is_the_interval(tendons):
    """Theory: profile and interval agree where the model is linear; SciPy's chi-squared."""
    fit = identify(Mechanism(), readings(Mechanism(), tendons, Sensors(), 3), STIFFNESSES)
    profile = fit.profile("EI")
    assert profile.lower == pytest.approx(fit["EI"].lower, abs=0.05 * fit["EI"].std)
    assert profile.upper == pytest.approx(fit["EI"].upper, abs=0.05 * fit["EI"].std)
    assert profile.threshold == pytest.approx(stats.chi2.ppf(0.9, 1))
    shear = fit.profile("GA")
    assert shear.upper - fit["GA"].value > fit["GA"].value - shear.lower  # pose goes with 1 / GA
    assert np.all(np.diff(shear.values) > 0.0)
    assert shear.rise.min() == 0.0
    inside = (shear.values >= shear.lower) & (shear.values <= shear.upper)
    assert np.all(shear.rise[inside] <= shear.threshold * 1.01)
    assert np.all(shear.rise[~inside] >= shear.threshold * 0.99)


def test_a_point_of_the_profile_is_a_fit_with_it_held(tendons):
    """Another way in: a fit with the parameter held."""
    data = readings(Mechanism(), tendons, Sensors(), 3)
    fit = identify(Mechanism(), data, STIFFNESSES)
    profile = fit.profile("GA")
    held = identify(Mechanism().replace(GA=float(profile.values[0])), data, ["EA", "EI"])
    assert held.chi2 - fit.chi2 == pytest.approx(profile.rise[0], rel=1e-6)


# The sum that is minimized


def test_scipy_finds_the_same_minimum(tendons):
    """SciPy's least_squares with finite differences."""
    data = readings(Mechanism(), tendons, Sensors(), 1)
    start = Mechanism().replace(**OFF)
    fit = identify(start, data, STIFFNESSES)
    scale, solves = np.array([7500.0, 2420.0, 3.0]), 0
    sigma = np.array([1e-4, 1e-4, 1e-3])

    def residual(u):
        nonlocal solves
        solves += data.n
        neck = Mechanism().replace(**dict(zip(STIFFNESSES, (u * scale).tolist(), strict=True)))
        return ((predict(neck, data).pose - data.pose) / sigma).ravel()

    other = optimize.least_squares(residual, np.array(list(OFF.values())) / scale, xtol=1e-12, ftol=1e-12, gtol=1e-12)
    std = np.array([fit[name].std for name in STIFFNESSES])
    assert np.all(np.abs(other.x * scale - fit.values) < 1e-3 * std)
    assert 3 * fit.solves <= solves
    assert fit.chi2 <= 2.0 * other.cost * (1.0 + 1e-12)


def test_finite_differences_do_not_reach_the_derivatives(tendons):
    """Finer mesh: derivatives by two elements, beside SciPy's forward differences."""
    neck, lam, scale = Mechanism(), tendons.loads.lam, np.array([7500.0, 2420.0, 3.0])

    def pose(u):
        changed = dict(zip(STIFFNESSES, (u * scale).tolist(), strict=True))
        return FiniteElementModel(neck.replace(**changed)).solve_batch(lam, tolerance=1e-12).pose.ravel()

    def exact(elements):
        model = FiniteElementModel(neck, elements)
        return model.sensitivities(STIFFNESSES, lam, tolerance=1e-12).dpose_dpar * scale

    forward = optimize.approx_fprime(np.ones(3), pose).reshape(-1, 3, 3)
    central = np.stack([(pose(1.0 + 1e-4 * e) - pose(1.0 - 1e-4 * e)) / 2e-4 for e in np.eye(3)], axis=-1)
    ours, finer = exact(1), exact(2)
    off = np.abs(ours - finer).max()
    assert off < 1e-8  # m and rad, by relative changes of the stiffnesses
    assert np.abs(forward - finer).max() > 10.0 * off
    np.testing.assert_allclose(central.reshape(-1, 3, 3), ours, rtol=0, atol=1e-8)


@pytest.mark.parametrize("loss", ["huber", "soft_l1"])
def test_a_robust_minimum_is_that_of_scipy(loss):
    """SciPy's least_squares with the same loss."""
    rng = np.random.default_rng(4)
    t = np.linspace(0.0, 2.0, 60)
    y = 3.0 * np.exp(-1.2 * t) + 0.05 * rng.standard_normal(t.size)
    y[::7] += 2.0

    def residual(v):
        return (v[0] * np.exp(-v[1] * t) - y) / 0.05

    def both(v):
        return residual(v), np.column_stack([np.exp(-v[1] * t), -v[0] * t * np.exp(-v[1] * t)]) / 0.05

    start, far = np.array([1.0, 0.1]), np.full(2, 1e3)
    ours = minimize(both, start, -far, far, Loss(loss, 1.3))
    theirs = optimize.least_squares(
        residual, start, lambda v: both(v)[1], loss=loss, f_scale=1.3, xtol=1e-14, ftol=1e-14, gtol=1e-14
    )
    assert ours.settled
    np.testing.assert_allclose(ours.values, theirs.x, rtol=1e-5)
    assert ours.total == pytest.approx(2.0 * theirs.cost, rel=1e-9)


def test_a_minimum_on_a_bound_is_that_of_scipy():
    """SciPy's lsq_linear."""
    t = np.linspace(0.0, 1.0, 20)
    A = np.column_stack([np.ones_like(t), t, t**2])
    y = 1.0 - 0.5 * t + 0.3 * t**2
    lower, upper = np.array([-5.0, 0.0, -5.0]), np.array([5.0, 5.0, 0.1])
    ours = minimize(lambda v: (A @ v - y, A), np.array([0.0, 1.0, 0.0]), lower, upper)
    theirs = optimize.lsq_linear(A, y, (lower, upper), tol=1e-14)
    np.testing.assert_allclose(ours.values, theirs.x, atol=1e-7)


def test_outliers_hardly_move_a_robust_fit(tendons):
    """Known truth: the same readings without their outliers."""
    sensors = Sensors(outlier_share=0.1, outlier_size=30.0)
    data = readings(Mechanism(), tendons, sensors, 8)
    clean = identify(Mechanism(), readings(Mechanism(), tendons, replace(sensors, outlier_share=0.0), 8), STIFFNESSES)
    plain = identify(Mechanism(), data, STIFFNESSES)
    assert any("times the noise" in text for text in plain.warnings)
    std = np.array([clean[name].std for name in STIFFNESSES])
    astray = np.linalg.norm((plain.values - clean.values) / std)
    for loss in ("huber", "soft_l1"):
        robust = identify(Mechanism(), data, STIFFNESSES, loss=loss)
        assert robust.settled
        assert np.linalg.norm((robust.values - clean.values) / std) < 0.3 * astray
        assert np.all(np.abs(robust.values - [7500.0, 2420.0, 3.0]) < 4.0 * std)


def test_a_robust_fit_that_estimates_its_noise_is_not_fooled(tendons):
    """Known truth: stiffnesses and noise of the test bed."""
    sensors = Sensors(outlier_share=0.1, outlier_size=30.0, declared=False)
    fit = identify(Mechanism(), readings(Mechanism(), tendons, sensors, 8), STIFFNESSES, loss="huber")
    assert np.all(np.abs(fit.sigma - [1e-4, 1e-4, 1e-3]) < [4e-5, 4e-5, 4e-4])
    assert np.all(np.abs(fit.values - [7500.0, 2420.0, 3.0]) < 4.0 * np.array([fit[n].std for n in STIFFNESSES]))


# Where the noise comes from


def test_noise_from_replicates_and_from_the_residual():
    """Known truth: the noise of the test bed."""
    loads = tendon_test(40, replicated=20, replicates=4, seed=3)
    found = equilibria(Mechanism(), loads).raise_if_failed()
    data = readings(Mechanism(), found, Sensors(camera_sigma=(1e-4, 5e-5, 2e-3), declared=False), 2)
    truth = np.array([1e-4, 5e-5, 2e-3])
    repeated = identify(Mechanism(), data, STIFFNESSES)
    assert repeated.noise == dict.fromkeys(("x", "z", "theta"), "replicates")
    np.testing.assert_allclose(repeated.sigma[0], truth, rtol=0.3)  # 60 degrees of freedom: 3 sigma are 0.28
    lonely = identify(Mechanism(), replace(data, pose_id=np.full(data.n, "")), STIFFNESSES)
    assert lonely.noise == dict.fromkeys(("x", "z", "theta"), "residual")
    np.testing.assert_allclose(lonely.sigma[0], truth, rtol=0.25)
    assert lonely.chi2 == pytest.approx(lonely.dof, rel=1e-2)
    # Student's t for 60 degrees of freedom, see any table: 1.671
    assert repeated["EI"].dof == 60.0
    EI = repeated["EI"]
    assert 1.0 / EI.value - 1.0 / EI.upper == pytest.approx(1.671 * EI.std / EI.value**2, rel=3e-4)
    wider = identify(Mechanism(), replace(data, sigma_z=np.full(data.n, 5e-5)), STIFFNESSES)
    assert wider.noise == {"x": "replicates", "z": "declared", "theta": "replicates"}


def test_replicates_do_not_count_force_noise_twice():
    """Known truth: the camera's noise of the test bed."""
    loads = tendon_test(60, replicated=60, replicates=5, seed=3)
    found = equilibria(Mechanism(), loads).raise_if_failed()
    sensors = Sensors(camera_sigma=(1e-4, 1e-4, 1e-3), force_sigma=0.3, declared=False)
    data = readings(Mechanism(), found, sensors, 2)
    fit = identify(Mechanism(), data, STIFFNESSES, force_sigma=0.3)
    np.testing.assert_allclose(fit.sigma[0], [1e-4, 1e-4, 1e-3], rtol=0.25)
    assert fit.chi2 == pytest.approx(fit.dof, rel=0.15)


# Warnings


def test_what_pure_compression_cannot_see_is_told():
    """Theory: pure compression does not depend on GA."""
    specimen, data = datasets.load("simulated_compression_28mm")
    fit = identify(specimen, data, ["EA", "GA"])
    assert len(fit.warnings) == 1
    assert fit.warnings[0].startswith("GA cannot be seen in the data (relative singular value 0)")
    assert (fit["GA"].value, fit["GA"].std, fit["GA"].upper) == (2420.0, np.inf, np.inf)
    assert fit["EA"].std == pytest.approx(identify(specimen, data, ["EA"])["EA"].std)
    with pytest.raises(InputError, match=r"^GA has no profile: the data do not see it$"):
        fit.profile("GA")


def test_a_combination_that_is_not_seen_is_named(tendons):
    """Theory: two masses act only as their sum."""
    data = readings(Mechanism(), tendons, Sensors(), 3)
    names = ["EI", "head.mass", "effects.head_mass"]  # the masses act only as their sum
    fit = identify(Mechanism(), data, names)
    unseen = [text for text in fit.warnings if "cannot be seen" in text]
    assert len(unseen) == 1
    assert "the combination " in unseen[0]
    assert "head.mass" in unseen[0]
    assert "effects.head_mass" in unseen[0]
    assert "EI" not in unseen[0]
    assert np.isinf([fit["head.mass"].std, fit["effects.head_mass"].std]).all()
    assert np.isfinite(fit["EI"].std)
    weighed = identify(Mechanism(), data, names, priors={"effects.head_mass": (0.0, 0.01)})
    assert np.isfinite(weighed["head.mass"].std)
    assert weighed["effects.head_mass"].std == pytest.approx(0.01, rel=1e-6)


def test_a_value_on_its_bound_is_told():
    """By hand: readings that ask for a negative mass."""
    truth = Mechanism().replace(**{"head.mass": 0.0})
    data = sampled(truth, tendon_test(40, seed=1))
    lifted = replace(data, theta=data.theta * 0.99)  # as if the head weighed less than nothing
    fit = identify(Mechanism(), lifted, ["head.mass"])
    assert fit["head.mass"].value == fit["head.mass"].lower == 0.0
    assert "head.mass = 0 sits on its bound 0 kg: it wants to go beyond" in fit.warnings


def test_a_drift_away_from_a_prior_is_told_with_its_size(tendons):
    """Closed form: the mean of two normal densities."""
    data = readings(Mechanism(), tendons, Sensors(), 3)
    free = identify(Mechanism(), data, STIFFNESSES)["EA"]
    fit = identify(Mechanism(), data, STIFFNESSES, priors={"EA": (7900.0, 75.0)})
    weights = np.array([free.std**-2.0, 75.0**-2.0])
    mean = weights @ [free.value, 7900.0] / weights.sum()  # two normal densities multiplied
    # x goes with 1 / EA: where EA rises by 1 %, its weight falls by 2 to 4 %
    assert fit["EA"].value == pytest.approx(mean, abs=0.04 * (mean - free.value))
    off = (fit["EA"].value - 7900.0) / 75.0
    text = f"EA = {fit['EA'].value:.6g} drifts {off:+.1f} standard deviations away from its prior, 7900 +- 75 N"
    assert text in fit.warnings
    assert not any("drifts" in text for text in identify(Mechanism(), data, ["EA"], priors={"EA": (7500, 75)}).warnings)


def test_strong_correlation_is_told(tendons):
    """By hand: the correlation and the text."""
    data = readings(Mechanism(), tendons, Sensors(), 3)
    fit = identify(Mechanism(), data, ["EA", "EI", "head.mass"])
    assert fit.correlation[1, 2] > 0.99
    assert any(text.startswith("EI and head.mass are correlated by +0.99") for text in fit.warnings)


def test_a_law_that_does_not_hold_is_told():
    """Known truth: the simulated specimen is neo-Hookean."""
    specimen, data = datasets.load("simulated_compression_28mm")
    found = fit_compression(specimen, data)
    assert found.neo_hookean.warnings == ()
    assert any("times the noise" in text for text in found.hooke.warnings)


# Rows and input


def test_rows_without_an_equilibrium_are_left_out():
    """By hand: loads beyond any equilibrium among good ones."""
    neck, loads = Mechanism(), Measurements.from_columns({"lam_l_N": [20.0, 80.0, 10.0], "lam_r_N": [0.0, 10.0, 90.0]})
    clean = sampled(neck, loads, EXACT)
    spoilt = Measurements.from_columns(
        {
            "lam_l_N": [*clean.lam_l, 2000.0, 40.0],
            "lam_r_N": [*clean.lam_r, 0.0, 0.0],
            "x_m": [*clean.x, 0.1, None],
            "z_m": [*clean.z, 0.0, None],
            "theta_rad": [*clean.theta, 0.0, None],
        },
        source="run.csv",
    )
    fit = identify(neck.replace(EI=2.8), spoilt, ["EI"])
    assert fit["EI"].value == pytest.approx(3.0, rel=1e-7)
    assert fit.left_out == (("run.csv: row 4", "tendon zero length"),)
    assert (fit.rows, fit.used[3:].any()) == (3, False)
    assert fit.warnings[0].startswith(
        "1 of 4 rows are left out, because the fitted mechanism has no stable equilibrium"
    )
    assert fit.warnings[0].endswith("run.csv: row 4: tendon zero length")
    assert "left out: run.csv: row 4" in repr(fit)


def test_rows_that_only_the_fit_can_carry_come_back_in():
    """Known truth of the test bed, from a start that fails in one row."""
    # the start is so weak that the last pair of tendons pulls it up to a pulley
    truth = Mechanism()
    loads = Measurements.from_columns({"lam_l_N": [20.0, 60.0, 400.0], "lam_r_N": [0.0, 10.0, 250.0]})
    data = sampled(truth, loads, EXACT)
    start = truth.replace(EI=1.0)
    assert predict(start, data).counts["converged"] == 2
    fit = identify(start, data, ["EI"], order=6)  # order 5 is made for 160 N
    assert fit["EI"].value == pytest.approx(3.0, rel=1e-7)
    assert (fit.rows, fit.left_out) == (3, ())


def test_a_missing_channel_counts_nothing(tendons):
    """Another way in: the same channels chosen by name."""
    data = readings(Mechanism(), tendons, Sensors(force_sigma=0.1), 3)
    blank = replace(data, x=np.full(data.n, np.nan))
    fit, only = identify(Mechanism(), blank, ["EI"]), identify(Mechanism(), data, ["EI"], channels=("z", "theta"))
    assert fit["EI"] == only["EI"]
    assert fit.rms["x_m"] is None


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"names": ["EJ"]}, "no parameter is called 'EJ' (did you mean"),
        ({"names": ["EA", "axial_law"]}, "axial_law is a choice, not a number: fit once with each and compare the rms"),
        ({"names": ["EA", "beam.EA"]}, "a parameter is named twice in EA, beam.EA"),
        ({"names": []}, "nothing to fit: name at least one parameter"),
        ({"names": ["EA", "GA", "EI", "g"]}, "3 readings and priors do not determine 4 parameters; at least 4 are"),
        ({"channels": ("y",)}, "channel = 'y': allowed is 'x' or 'z' or 'theta'"),
        ({"channels": ()}, "run.csv: no channel to fit; allowed are x, z, theta"),
        ({"loss": "hubber"}, "loss = 'hubber': allowed is 'linear' or 'huber' or 'soft_l1' (did you mean 'huber'?)"),
        ({"loss_scale": -1.0}, "scale of the loss = -1.0: allowed is a finite number > 0"),
        ({"priors": {"GA": (1.0, 1.0)}}, "a prior for GA, which is not fitted: fit it too, or set it in the mechanism"),
        ({"priors": {"EA": (1.0, 0.0)}}, "standard deviation 0.0 of the prior for EA: allowed is a finite number > 0"),
        ({"priors": {"EA": (-1.0, 1.0)}}, "beam.EA = -1.0: allowed is a finite number from 1e-12 to 1e+15 N"),
        ({"level": 1.0}, "level = 1.0: allowed is a number between 0 and 1"),
        ({"force_sigma": -0.1}, "force_sigma = -0.1: allowed is a finite number >= 0"),
    ],
    ids=str,
)
def test_what_cannot_be_meant_is_told(options, text):
    """Contract: the text of the error."""
    columns = {"lam_l_N": [40.0], "lam_r_N": [10.0], "x_m": [0.1], "z_m": [0.01], "theta_rad": [-0.1]}
    data = Measurements.from_columns(columns, source="run.csv")
    with pytest.raises(InputError) as caught:
        identify(Mechanism(), data, **{"names": ["EA"], **options})
    assert str(caught.value).startswith(text)


def test_a_reading_without_noise_is_refused_with_its_row(tendons):
    """Contract: the text of the error."""
    data = readings(Mechanism(), tendons, Sensors())
    sigma = np.where(np.arange(data.n) == 6, 0.0, data.sigma_z)
    with pytest.raises(InputError, match="row 7: sigma_z = 0: a fit weighs readings by their noise"):
        identify(Mechanism(), replace(data, sigma_z=sigma), ["EI"])


def test_no_equilibrium_at_all_is_told():
    """Contract: the text of the error."""
    data = Measurements.from_columns({"lam_l_N": [2000.0], "lam_r_N": [0.0], "x_m": [0.1]})
    with pytest.raises(InputError, match=r"^0 readings and priors \(1 rows have no stable equilibrium\) do not"):
        identify(Mechanism(), data, ["EI"])


def test_the_result_reads_well_and_names_what_it_does_not_hold(tendons):
    """By hand: the text."""
    fit = identify(Mechanism(), readings(Mechanism(), tendons, Sensors(), 3), ["EI"])
    lines = repr(fit).splitlines()
    assert lines[0] == "<Identification from 80 rows, 90% intervals; noise: x declared, z declared, theta declared"
    assert lines[1].startswith("  EI ")
    assert " N m^2 (" in lines[1]
    with pytest.raises(InputError, match=r"^'EA' was not fitted.*; these were: EI$"):
        fit["EA"]
