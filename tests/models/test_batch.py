"""Batches: each case is that of a single solve, on any number of threads, into any old result."""

import numpy as np
import pytest

from ecm_fast import BatchResult, FiniteElementModel, InputError, Mechanism, Status
from ecm_fast.mechanism.vector import pack

BOX = np.array([[-330.0, -80.0, -11.0], [20.0, 80.0, 11.0]])
"""The paper's wrench box: fx, fz, tau, lowest and highest."""


@pytest.mark.parametrize("order", [3, 4, 5, 6])
@pytest.mark.parametrize("law", ["neo-hookean", "hooke"])
def test_batch_is_the_single_solve(order, law):
    """The single solve: both solve the same equations, the batch to a tolerance of 1e-13.

    Beside the paper's range, a case in three is so far outside that no shortcut may be taken, or has no equilibrium.
    """
    model = FiniteElementModel(
        Mechanism().replace(axial_law=law, precurvature=0.3, pulley_z=0.0645, pulley_radius=0.0055), order=order
    )
    rng = np.random.default_rng(5)
    lam, wrench = rng.uniform(0.0, 160.0, (150, 2)), rng.uniform(*BOX, (150, 3))
    lam[::3] = rng.uniform(0.0, 1000.0, (50, 2))
    single = [model.solve(*case) for case in zip(lam, wrench, strict=True)]
    vectors = np.tile(pack(model.mechanism), (150, 1))
    for batch in (
        model.solve_batch(lam, wrench, tolerance=1e-13),
        FiniteElementModel(order=order).solve_batch(lam, wrench, parameters=vectors, tolerance=1e-13),
    ):
        assert batch.status.tolist() == [eq.status for eq in single]
        assert batch.load_factor.tolist() == [eq.load_factor for eq in single]
        np.testing.assert_allclose(batch.pose, [eq.pose for eq in single], rtol=0.0, atol=1e-12)
    assert 10 < batch.counts()["tendon_zero_length"] < 50


@pytest.mark.parametrize("threads", [2, 3, 500])
def test_threads_change_nothing(threads):
    """One thread: the same verdicts, and poses to the tolerance: cases that share a vector register stop together."""
    model, rng = FiniteElementModel(), np.random.default_rng(6)
    lam, wrench = rng.uniform(0.0, 300.0, (150, 2)), rng.normal(size=(150, 3)) * [100.0, 40.0, 5.0]
    lam[::10], wrench[::10] = 0.0, [-900.0, 0.0, 0.0]
    for tolerance in (1e-9, 1e-13):
        one = model.solve_batch(lam, wrench, tolerance=tolerance)
        many = model.solve_batch(lam, wrench, tolerance=tolerance, threads=threads)
        assert many.status.tolist() == one.status.tolist()
        assert many.load_factor.tolist() == one.load_factor.tolist()
        np.testing.assert_allclose(many.pose, one.pose, rtol=0.0, atol=tolerance)
        assert one.counts()["unstable"] == 15


@pytest.mark.parametrize("mesh", [{}, {"elements": 5, "order": 1}, {"family": "strain"}])
@pytest.mark.parametrize("one_each", [False, True], ids=["one mechanism", "one each"])
def test_a_result_that_is_overwritten_keeps_nothing(mesh, one_each):
    """A new result, whatever the old one holds: verdicts of other cases, numbers or none."""
    model, rng = FiniteElementModel(**mesh), np.random.default_rng(7)
    lam = rng.uniform(0.0, [[1.0], [900.0]] * 20, (40, 2))
    options = {"parameters": np.tile(pack(model.mechanism), (40, 1)) if one_each else None}
    known = model.solve_batch(lam, **options)
    assert 0 < known.counts()["converged"] < 40
    for status, number in ((Status.CONVERGED, 1.0), (Status.INVALID_INPUT, np.nan)):
        poses, statuses = (np.full(40, number) for _ in range(4)), np.full(40, status, dtype=np.int64)
        x, z, theta, factor = poses
        out = BatchResult(x, z, theta, statuses, factor)
        assert model.solve_batch(lam, out=out, **options) is out
        for name in ("x", "z", "theta", "status", "load_factor"):
            np.testing.assert_array_equal(getattr(out, name), getattr(known, name))
    with pytest.raises(InputError, match=r"^out has 40 cases: allowed is 39, as many as there are loads$"):
        model.solve_batch(lam[1:], out=out)


def test_empty_batch():
    """Contract: no cases, no results, no error."""
    batch = FiniteElementModel().solve_batch(np.zeros((0, 2)))
    assert len(batch) == 0
    assert batch.pose.shape == (0, 3)
