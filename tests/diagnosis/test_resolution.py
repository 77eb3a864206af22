"""The discretization of a diagnosis: fine enough for the noise of its rows."""

import numpy as np
import pytest

from ecm_fast import FiniteElementModel, Mechanism, diagnose, predict
from ecm_fast.models.instruments.mesh_choice import mesh_for
from ecm_fast.testbed import Sensors, measure, tendon_test

LONG = Mechanism.preset("slender").replace(length=0.5)


@pytest.fixture(scope="module")
def bent():
    """Return measurements of the test bed on a neck of 0.5 m, which tendons bend far round."""
    return measure(LONG, tendon_test(60, lam_max=80.0, seed=1), Sensors(), seed=1)


@pytest.mark.slow
def test_the_mesh_follows_the_noise(bent):
    """Convergence: the error of every row, against twice as many elements, is below a tenth of its noise."""
    mesh, excess = mesh_for(LONG, bent)
    assert (mesh.n_elements, mesh.order) > (1, 5)
    assert np.nanmax(excess) <= 1.0
    own = FiniteElementModel(LONG, mesh.shares, mesh.order).solve_batch(bent.lam, bent.wrench)
    fine = FiniteElementModel(LONG, mesh.halved.shares, mesh.order).solve_batch(bent.lam, bent.wrench)
    both = own.stable & fine.stable
    sigma = np.column_stack([bent.sigma_x, bent.sigma_z, bent.sigma_theta])
    assert (np.abs(own.pose - fine.pose)[both] < 0.1 * sigma[both]).all()


def test_a_gentle_neck_keeps_one_element():
    """The estimate of one element of order 5 under the paper's tendons is far below the camera's noise."""
    neck = Mechanism.preset("slender")
    data = measure(neck, tendon_test(20, seed=1), Sensors(), seed=1)
    mesh, _ = mesh_for(neck, data)
    assert (mesh.n_elements, mesh.order) == (1, 5)


@pytest.mark.slow
def test_predictions_of_far_bends_are_the_test_beds(bent):
    """The test bed's shooting: what is left of its own readings is their noise, and no more."""
    left = np.abs(predict(LONG, bent).sigmas)
    assert np.nanmax(left) < 5.0


@pytest.mark.slow
def test_a_far_bent_neck_without_an_effect_has_none():
    """The test bed without an effect: one element of order 5 made this `shear_cubic`, -29.4."""
    data = measure(LONG, tendon_test(lam_max=80.0, seed=1), Sensors(), seed=1)
    assert diagnose(LONG, data).verdict == "nothing_found"
