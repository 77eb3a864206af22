"""Fits whose first start leads astray, and fits that must leave rows out: against closed forms of rubber in tension."""

import os
from pathlib import Path

import numpy as np
import pytest
from scipy import optimize

from ecm_fast import Mechanism, identify
from ecm_fast.data.measurements import Measurements
from ecm_fast.identification.least_squares import minimize

BESIDE = Path(__file__).resolve().parents[3] / "shared" / "data" / "measured"
MEASURED = Path(os.environ.get("ECM_FAST_MEASURED", BESIDE))
"""Data of others that this project does not copy: a folder beside the checkout, or named in the environment."""
STRIP = Mechanism().replace(length=0.1, GA=1e6, EI=1e3, mass_per_length=0.0, **{"head.mass": 0.0})


def ogden(stretch, EA, m):
    """Return the force of Ogden's law with one term."""
    return 2.0 * EA / (3.0 * m) * (stretch ** (m - 1.0) - stretch ** (-0.5 * m - 1.0))


def pulled(force, stretch, noise=0.0):
    x = 0.1 * stretch + noise * np.random.default_rng(0).standard_normal(stretch.size)
    return Measurements.from_columns({"fx_N": force, "x_m": x})


@pytest.mark.slow
@pytest.mark.parametrize("start", [(120.0, 0.0), (3.0, -1.0), (1e3, -1.0), (7500.0, 0.0), (1e5, 15.0)], ids=str)
def test_the_best_minimum_is_found_from_far_away(start):
    """The law's closed form with EA = 37.5 N, m = 3, and 0.1 mm of noise; downhill alone ends at 0.33 m or nowhere."""
    stretch = np.linspace(1.05, 7.5, 20)
    data = pulled(ogden(stretch, 37.5, 3.0), stretch, 1e-4)
    fit = identify(STRIP.replace(EA=start[0], ogden=start[1]), data, ["EA", "ogden"], channels=("x",))
    assert (fit.rows, fit.settled, fit.warnings) == (20, True, ())
    assert fit.rms["x_m"] < 1.5e-4
    assert fit["EA"].value == pytest.approx(37.5, abs=4.0 * fit["EA"].std)
    assert fit["ogden"].value == pytest.approx(1.0, abs=4.0 * fit["ogden"].std)


@pytest.mark.skipif(not MEASURED.exists(), reason=f"{MEASURED} with measurements of others is not here")
@pytest.mark.parametrize("EA", [120.0, 7500.0])
def test_treloar_s_rubber_is_met_as_scipy_meets_it(EA):
    """Treloar, Trans. Faraday Soc. 40 (1944) 59-70: least squares of x by SciPy on the law's closed form."""
    rows = np.loadtxt(MEASURED / "treloar1944_uniaxial_hyperdata.csv", delimiter=",", skiprows=3)
    stretch, force = rows[:, 0], 100.0 * rows[:, 1]

    def misses(values):
        found = [optimize.brentq(lambda g, N=N: ogden(g, np.exp(values[0]), values[1]) - N, 0.5, 50.0) for N in force]
        return 0.1 * (np.array(found) - stretch)

    other = optimize.least_squares(misses, [np.log(40.0), 3.0])
    fit = identify(STRIP.replace(EA=EA), pulled(force, stretch), ["EA", "ogden"], channels=("x",))
    assert fit.rms["x_m"] == pytest.approx(np.sqrt(np.mean(other.fun**2)), rel=1e-4)
    assert fit["ogden"].value == pytest.approx(other.x[1] - 2.0, abs=1e-3)
    assert fit.warnings[-1].startswith("the fit leaves 0.0411 m of x, 17% of what it varies by")


@pytest.mark.slow
def test_a_fit_that_leaves_rows_out_says_so_first():
    """Beyond N = GA g, where EA/3 (g - g^-2) = EA/3.6 g, a straight strip gives way sideways: from g = 6^(1/3) on."""
    stretch = np.linspace(1.1, 2.6, 16)
    data = pulled(ogden(stretch, 120.0, 2.0), stretch)
    weak = STRIP.replace(EA=100.0, GA=120.0 / 3.6, EI=1e-4)
    fit = identify(weak, data, ["EA"], channels=("x",))
    lost = int((stretch > 6.0 ** (1.0 / 3.0)).sum())
    assert fit["EA"].value == pytest.approx(120.0, rel=1e-6)
    assert len(fit.left_out) == lost
    assert fit.warnings[0].startswith(f"{lost} of 16 rows are left out, because the fitted mechanism has no stable equ")
    assert repr(fit).startswith(f"<Identification from {16 - lost} of 16 rows, ")


def test_a_search_that_is_barred_has_not_settled():
    """The least squares of (v - 2) lie at 2, where there are no residuals beyond 1: stopping there is no minimum."""

    def residuals(values):
        return None if values[0] > 1.0 else (values - 2.0, np.eye(1))

    found = minimize(residuals, np.array([0.0]), np.array([-9.0]), np.array([9.0]))
    assert not found.settled
    assert found.blocked is not None
    assert found.blocked[0] > 1.0
