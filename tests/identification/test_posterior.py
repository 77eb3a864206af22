"""Posterior samples against a density that is integrated on a grid, and against the best fit's covariance."""

import numpy as np
import pytest
from scipy import stats

import ecm_fast as ecm
from ecm_fast.data import datasets
from ecm_fast.errors import InputError
from ecm_fast.identification.posterior import _complaints, posterior

pytestmark = pytest.mark.slow

emcee = pytest.importorskip("emcee", reason="no sampler here: emcee is not installed")


def measured(sigma: float = 2e-4) -> ecm.Measurements:
    """Few and coarse readings of a neck with EI = 2.8: the posterior is wide, and bounded by the prior."""
    rng = np.random.default_rng(1)
    lam = np.array([[20.0, 0.0], [60.0, 20.0], [0.0, 90.0]])
    pose = ecm.FiniteElementModel(ecm.Mechanism().replace(EI=2.8)).solve_batch(lam).pose
    z = pose[:, 1] + sigma * rng.standard_normal(3)
    columns = {"lam_l_N": lam[:, 0], "lam_r_N": lam[:, 1], "z_m": z, "sigma_z_m": np.full(3, sigma)}
    return ecm.Measurements.from_columns(columns)


def test_samples_of_one_parameter_have_its_density() -> None:
    """The density integrated on a grid."""
    data, prior = measured(), (3.0, 0.1)
    found = posterior(ecm.Mechanism(), data, ["EI"], priors={"EI": prior}, steps=500, seed=3)
    grid = np.linspace(2.3, 3.5, 121)
    logs = []
    for value in grid:
        model = ecm.FiniteElementModel(ecm.Mechanism().replace(EI=value), 10, 2)
        z = [model.solve(lam).z for lam in data.lam]
        logs.append(-0.5 * np.sum(((data.z - z) / 2e-4) ** 2) - 0.5 * ((value - prior[0]) / prior[1]) ** 2)
    density = np.exp(np.array(logs) - max(logs))
    density /= density.sum()
    mean = density @ grid
    std = np.sqrt(density @ (grid - mean) ** 2)
    independent = len(found.samples) / found.autocorrelation[0]
    assert independent > 100
    assert found["EI"].mean() == pytest.approx(mean, abs=4.0 * std / np.sqrt(independent))
    assert found["EI"].std() == pytest.approx(std, rel=4.0 / np.sqrt(2.0 * independent))


def test_many_readings_give_the_covariance_of_the_best_fit() -> None:
    """Theory: with many readings the posterior is normal with the fit's covariance."""
    neck, whole = datasets.load("simulated_slender_tendon")
    few = slice(None, None, 6)
    columns = {"lam_l_N": whole.lam_l, "lam_r_N": whole.lam_r, "x_m": whole.x, "z_m": whole.z, "theta_rad": whole.theta}
    data = ecm.Measurements.from_columns({name: values[few] for name, values in columns.items()})
    names = ["EA", "EI"]
    fit = ecm.identify(neck, data, names, force_sigma=0.1)
    found = posterior(neck, data, names, force_sigma=0.1, steps=300, seed=1)
    spread = np.sqrt(np.diag(fit.covariance))
    assert np.abs(found.samples.mean(axis=0) - fit.values).max() < 0.3 * spread.max()
    assert np.sqrt(np.diag(found.covariance)) == pytest.approx(spread, rel=0.3)
    low, high = found.interval("EI")
    assert low < fit["EI"].value < high
    assert found.solves >= 300 * 8 * data.n
    again = posterior(neck, data, names, force_sigma=0.1, steps=300, seed=1)
    assert np.array_equal(again.samples, found.samples)


def test_samples_from_few_rows_are_as_wide_as_students_t() -> None:
    """EI is all but linear here, so its density is the Student's t of the fit: quantiles from SciPy's tables of it."""
    neck, whole = datasets.load("simulated_slender_tendon")
    columns = {"lam_l_N": whole.lam_l, "lam_r_N": whole.lam_r, "x_m": whole.x, "z_m": whole.z, "theta_rad": whole.theta}
    data = ecm.Measurements.from_columns({name: values[3:7] for name, values in columns.items()})
    fit = ecm.identify(neck, data, ["EI"])
    assert fit["EI"].dof < 10.0
    found = posterior(neck, data, ["EI"], steps=1500, seed=2)
    for level in (0.5, 0.9):
        low, high = found.interval("EI", level)
        reach = stats.t(fit["EI"].dof).ppf(0.5 + 0.5 * level) * fit["EI"].std
        assert 0.5 * (high - low) == pytest.approx(reach, rel=0.1)
    with pytest.raises(InputError, match=r"^no samples of EI: no interval for EI: the noise of x, z, theta is not d"):
        posterior(neck, data.select([0, 1]), ["EI"], steps=100)


def test_what_cannot_be_sampled_is_said() -> None:
    """Contract: the text of errors and warnings."""
    assert _complaints(np.array([3.0, 16.0]), 1000) == ()
    data = measured()
    with pytest.raises(InputError, match=r"^walkers = 3, steps = 1000: allowed is an even number from 2 up, and from"):
        posterior(ecm.Mechanism(), data, ["EI"], walkers=3)
    found = posterior(ecm.Mechanism(), data, ["EI"], steps=100)
    assert found.warnings[0].startswith("100 steps are few for an autocorrelation time of ")
    with pytest.raises(InputError, match=r"^'EJ' was not sampled; these were: EI$"):
        found["EJ"]
    with pytest.raises(InputError, match=r"^level = 1: allowed is a number between 0 and 1$"):
        found.interval("EI", 1)
