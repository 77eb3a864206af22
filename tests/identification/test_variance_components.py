"""Noise from what a fit leaves: coverage against the truth, REML and degrees of freedom against closed forms."""

from functools import cache

import numpy as np
import pytest
from scipy import stats

from ecm_fast import Mechanism, identify
from ecm_fast.data.measurements import Measurements
from ecm_fast.errors import InputError
from ecm_fast.identification.variance_components import VarianceComponents, variance_components
from ecm_fast.models.sensitivity import Sensitivities
from ecm_fast.testbed import Sensors, equilibria, readings, tendon_test

pytestmark = pytest.mark.slow

ROWS, LEVEL = 200, 0.90
CAMERA = np.array([1e-4, 1e-4, 1e-3])


@cache
def clean() -> Measurements:
    """Return the test bed's poses without noise."""
    return readings(
        Mechanism(), equilibria(Mechanism(), tendon_test(ROWS, seed=5)).raise_if_failed(), Sensors.perfect()
    )


@cache
def slopes() -> np.ndarray:
    """Return derivatives of the poses by EA, GA, EI."""
    from ecm_fast import FiniteElementModel

    found: Sensitivities = FiniteElementModel(Mechanism()).sensitivities(["EA", "GA", "EI"], clean().lam)
    return np.asarray(found.dpose_dpar)


def split(residual: np.ndarray, jacobian: np.ndarray, *, robust: bool = False) -> VarianceComponents:
    """Return the variance components of one experiment where nothing is declared."""
    n, _, p = jacobian.shape
    groups = np.broadcast_to(np.eye(3, dtype=bool)[:, None, :], (3, n, 3))

    def whitening(sigma: np.ndarray) -> np.ndarray:
        return np.eye(3) / sigma[:, :, None]

    prior = np.zeros((p, p)), np.zeros(p)
    return variance_components(
        residual, jacobian, np.full((n, 3), np.nan), groups, CAMERA, whitening, prior, robust=robust
    )


def covered(count: int, noise: np.ndarray, columns: list[int], runs: int, seed: int) -> np.ndarray:
    """Return how often intervals from `count` rows hold the truth, 0, where the model is linear."""
    rng, hits = np.random.default_rng(seed), np.zeros(len(columns))
    for _ in range(runs):
        rows = rng.choice(ROWS, count, replace=False)
        jacobian, residual = slopes()[rows][:, :, columns], noise * rng.standard_normal((count, 3))
        found = split(residual, jacobian)
        A = (jacobian / found.sigma[:, :, None]).reshape(-1, len(columns))
        value = np.linalg.solve(A.T @ A, A.T @ (residual / found.sigma).ravel())
        reach = stats.t.ppf(0.5 * (1.0 + LEVEL), found.dof) * np.sqrt(np.diag(found.covariance))
        hits += np.abs(value) < reach
    return np.asarray(hits / runs)


@pytest.mark.parametrize("count", [3, 4, 6, 10])
def test_intervals_from_few_rows_hold_the_truth(count):
    """Linearized about the truth; 1000 runs, whose own standard deviation is 0.9 %, for EI alone and with EA and GA."""
    for columns in ([2], [0, 1, 2]):
        held = covered(count, CAMERA, columns, 1000, seed=count)
        assert np.all((held > 0.87) & (held < 0.93)), held


@pytest.mark.parametrize("factors", [(1.0, 1.0, 4.0), (1.0, 1.0, 0.25), (3.0, 1.0, 1.0), (1 / 3, 1.0, 3.0)], ids=str)
def test_a_camera_of_other_ratios_costs_width_not_coverage(factors):
    """The truth is up to 9 times from the ratios that the prior has; 400 runs: 1.5 % is one standard deviation."""
    for count in (3, 6, 20):
        held = covered(count, CAMERA * factors, [2], 400, seed=count)
        assert np.all((held > 0.85) & (held < 0.975)), (count, held)


@pytest.mark.parametrize("count", [3, 4, 6])
def test_whole_fits_hold_the_truth_as_linear_ones_do(count):
    """300 runs: 1.7 % is one standard deviation. A noise of its own for each channel gives 64, 68, 74 of 100 runs."""
    rng, hits, runs = np.random.default_rng(count), 0, 300
    for _ in range(runs):
        data = few(rng.choice(ROWS, count, replace=False), rng)
        fit = identify(Mechanism(), data, ["EI"])
        hits += fit["EI"].lower < 3.0 < fit["EI"].upper
    assert 0.85 < hits / runs < 0.95


@pytest.mark.parametrize("count", [3, 6, 10])
def test_intervals_of_three_stiffnesses_hold_the_truth(count):
    """300 runs: 1.7 % is one standard deviation. The data tell GA to a half; about its value poses are far from linear.

    Of 3 rows one fit in six ends at a neck that is rigid in shear; its intervals hold the truth more often than stated.
    """
    rng, hits, runs, truth = np.random.default_rng([5, count]), np.zeros(3), 300, (7500.0, 2420.0, 3.0)
    for _ in range(runs):
        fit = identify(Mechanism(), few(rng.choice(ROWS, count, replace=False), rng), ["EA", "GA", "EI"])
        hits += [found.lower < value < found.upper for found, value in zip(fit.parameters.values(), truth, strict=True)]
    assert np.all((hits / runs > 0.85) & (hits / runs < 0.98)), hits


def test_a_stiffness_beyond_what_readings_tell_has_a_lower_end():
    """A push along a straight bar that, by its noise, grows longer: L/EA is below what the noise leaves of x/F.

    Closed form: x = L (1 - F/EA), so that 1/EA is below t sigma/(F L sqrt(n)), Gaussian for a noise that is declared.
    """
    neck = Mechanism().replace(axial_law="hooke", g=0.0)
    length, force, n, sigma = neck.beam.length, 100.0, 4, 1e-4
    data = Measurements.from_columns({"fx_N": [-force] * n, "x_m": [length + 1e-7 * i for i in range(1, n + 1)]})
    fit = identify(neck, data.with_noise({"x_m": sigma}), ["EA"])
    assert (fit["EA"].std, fit["EA"].upper) == (np.inf, fit["EA"].value)
    assert fit["EA"].lower == pytest.approx(force * length * np.sqrt(n) / (stats.norm.ppf(0.95) * sigma), rel=0.2)


def few(rows: np.ndarray, rng: np.random.Generator) -> Measurements:
    """Return rows of the test bed with noise that they do not declare."""
    data = clean()
    x, z, theta = (data.pose[rows] + CAMERA * rng.standard_normal((len(rows), 3))).T
    columns = {"lam_l_N": data.lam_l[rows], "lam_r_N": data.lam_r[rows], "x_m": x, "z_m": z, "theta_rad": theta}
    return Measurements.from_columns(columns)


@pytest.mark.parametrize("count", [1, 2])
def test_fewer_than_three_rows_give_no_interval_but_the_reason(count):
    """Counting: the noise of three channels cannot be told from fewer readings; the text by hand."""
    fit = identify(Mechanism(), few(np.arange(3, 3 + count), np.random.default_rng(0)), ["EI"])
    assert (fit["EI"].std, fit["EI"].lower, fit["EI"].upper) == (np.inf, -np.inf, np.inf)
    assert fit.warnings[0].startswith("no interval for EI: the noise of x, z, theta is not declared, and ")
    with pytest.raises(InputError, match=r"^EI has no profile: too few readings tell their noise$"):
        fit.profile("EI")
    declared = few(np.arange(3, 3 + count), np.random.default_rng(0)).with_noise({"x_mm": 0.1, "z_mm": 0.1})
    known = identify(Mechanism(), declared.with_noise({"theta_mrad": 1.0}), ["EI"])
    assert known["EI"].lower < 3.0 < known["EI"].upper
    assert known.warnings == ()


def test_one_row_that_the_model_misses_is_no_proof():
    """A row whose z the fit misses by 1.2 mm once gave EI +- 1.5e-9."""
    neck = Mechanism().replace(length=0.1, EA=276.0, GA=76.7, EI=0.0207, mass_per_length=0.0, **{"head.mass": 0.0})
    row = Measurements.from_columns({"fz_N": [0.6], "x_mm": [98.81], "z_mm": [12.0], "theta_deg": [-8.2]})
    fit = identify(neck, row, ["EI"])
    assert not np.isfinite(fit["EI"].std)
    assert "is not declared" in fit.warnings[0]


def test_one_channel_is_the_textbook_fit_of_a_line():
    """Ordinary least squares: s^2 = RSS / (n - 2), covariance s^2 (A'A)^-1, n - 2 degrees of freedom."""
    rng, t = np.random.default_rng(2), np.linspace(0.0, 1.0, 7)
    A, y = np.column_stack([np.ones_like(t), t]), 1.0 + 2.0 * t + 0.1 * rng.standard_normal(7)
    jacobian, residual, sigma = np.zeros((7, 3, 2)), np.zeros((7, 3)), np.full((7, 3), np.nan)
    jacobian[:, 0], residual[:, 0] = A, y
    mask = np.zeros((1, 7, 3), dtype=bool)
    mask[0, :, 0] = True

    def whitening(filled: np.ndarray) -> np.ndarray:
        return np.eye(3) / np.nan_to_num(filled, nan=np.inf)[:, :, None]

    prior = np.zeros((2, 2)), np.zeros(2)
    found = variance_components(residual, jacobian, sigma, mask, CAMERA, whitening, prior, robust=False)
    line = stats.linregress(t, y)
    np.testing.assert_allclose(found.dof, 5.0, rtol=1e-6)
    assert np.sqrt(found.covariance[1, 1]) == pytest.approx(line.stderr, rel=1e-6)
    assert np.sqrt(found.covariance[0, 0]) == pytest.approx(line.intercept_stderr, rel=1e-6)


def test_many_rows_are_the_maximum_of_the_restricted_likelihood():
    """REML by hand: minus twice the restricted log-likelihood, found smallest by SciPy; 200 rows overrule the prior."""
    from scipy import optimize

    rng = np.random.default_rng(1)
    residual = CAMERA * [1.0, 0.6, 1.5] * rng.standard_normal((ROWS, 3))
    found = split(residual, slopes())

    def restricted(log_sigma):
        A = (slopes() / np.exp(log_sigma)[:, None]).reshape(-1, 3) * [7500.0, 2420.0, 3.0]
        y = (residual / np.exp(log_sigma)).ravel()
        off = y - A @ np.linalg.lstsq(A, y, rcond=None)[0]
        return off @ off + 2.0 * ROWS * log_sigma.sum() + np.linalg.slogdet(A.T @ A)[1]

    best = optimize.minimize(restricted, np.log(CAMERA), method="Nelder-Mead", options={"xatol": 1e-6, "fatol": 1e-9})
    np.testing.assert_allclose(np.log(found.sigma[0]), best.x, atol=0.02)  # the prior's pull: 1 row in 200
