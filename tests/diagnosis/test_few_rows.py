"""Measurements that are hardly any: a diagnosis of them ends, whatever is missing."""

import numpy as np

import ecm_fast as ecm
from ecm_fast.diagnosis.problem.progress import Progress
from ecm_fast.diagnosis.proof.discrepancy import remainder
from ecm_fast.diagnosis.proof.holdout_error import Residuals
from ecm_fast.diagnosis.proof.localization import compliances
from ecm_fast.diagnosis.search.subsample import search_all


def test_a_remainder_needs_no_row_that_is_whole() -> None:
    """With x alone no row has x, z and theta together: there is nothing to smooth, so the wrench is zero."""
    fx = np.arange(8.0)
    data = ecm.Measurements.from_columns({"fx_N": fx, "x_mm": 107.0 + 0.1 * fx, "sigma_x_mm": np.full(8, 0.1)})
    problem = ecm.Study(ecm.Mechanism(), data).problem(progress=Progress())
    found = search_all(problem, 0.01, 0, 0)
    before = found.null.state(problem)
    weights = problem.weights(found.view.noise, before)
    left = remainder(
        problem,
        found.view,
        Residuals.from_states(problem, before, before, weights, found.scale, {}),
        compliances(problem, before),
        problem.locked,
    )
    assert not np.nan_to_num(left.wrench).any()
