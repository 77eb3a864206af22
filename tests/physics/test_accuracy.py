"""The discretization error that results carry, and the accuracy that a model promises."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipkinc, ellipkm1

from ecm_fast import FiniteElementModel, Mechanism
from ecm_fast.mechanism.vector import pack
from ecm_fast.models.loads import loads_of
from ecm_fast.models.refinement import jumps

STIFF = 1e3
BEAM = Mechanism().replace(length=1.0, EI=1.0, EA=STIFF, GA=STIFF, axial_law="hooke", g=0.0)


def elastica(alpha):
    """Return the tip (x, z, theta) of the inextensible cantilever under a transverse tip force, P L^2/EI = alpha.

    Elliptic integrals: sqrt(alpha) = K(m) - F(phi, m) with m = (1 + sin theta)/2 and sin(phi)^2 = 1/(2 m), see the
    head of `tables/elastica_transverse_tip_load.csv`. Under Hooke's law with EA = GA the tip is P L/EA farther. The
    unknown is log(1 - m): a far bend's tip stands within 1e-13 of a right angle, or nearer.
    """

    def rest(log_m1):
        m1 = np.exp(log_m1)
        phi = np.arcsin(np.sqrt(0.5 / (1.0 - m1)))
        return ellipkm1(m1) - ellipkinc(phi, 1.0 - m1) - np.sqrt(alpha)

    m = 1.0 - np.exp(brentq(rest, np.log(1e-40), np.log(0.5 - 1e-12), xtol=1e-15))
    phi = np.arcsin(np.sqrt(0.5 / m))
    deflection = 1.0 - 2.0 * (ellipe(m) - ellipeinc(phi, m)) / np.sqrt(alpha)
    along = np.sqrt(2.0 * (2.0 * m - 1.0) / alpha)
    return np.array([along, deflection + alpha / STIFF, -np.arcsin(2.0 * m - 1.0)])


@pytest.mark.parametrize("alpha", [1.0, 10.0, 50.0])
def test_elliptic_integrals_meet_the_table(table, alpha):
    """Table: the same integrals with 30 digits."""
    (row,) = [row for row in table("elastica_transverse_tip_load") if row["alpha"] == alpha]
    listed = [1.0 - row["u_over_L"], row["w_over_L"] + alpha / STIFF, -row["theta_tip_rad"]]
    assert np.abs(elastica(alpha) - listed).max() < 1e-7


@pytest.mark.parametrize("alpha", [1.0, 10.0, 50.0, 100.0, 200.0, 1000.0])
def test_far_bends_keep_the_accuracy(alpha):
    """Elliptic integrals: one element of order 5 is off by 0.46 at alpha = 1000; the default promises 1e-6."""
    eq = FiniteElementModel(BEAM).solve(wrench=(0.0, alpha, 0.0)).raise_if_failed()
    off = np.abs(eq.pose[:2] - elastica(alpha)[:2]).max()
    assert off < 1e-6
    # the integrals lose digits near the right angle, as 1 - m does
    assert off < max(eq.error, 1e-7)
    assert eq.error <= 1e-6


def test_a_beam_cast_round_is_a_circle():
    """Closed form: unloaded, the curvature is everywhere the one as built, 20/L."""
    eq = FiniteElementModel(BEAM.replace(precurvature=20.0)).solve()
    assert np.abs(eq.pose - [np.sin(20.0) / 20.0, -(1.0 - np.cos(20.0)) / 20.0, 20.0]).max() < 1e-6


def test_a_couple_of_two_turns_closes_the_circle():
    """Closed form: an end couple of 4 pi EI/L bends the beam into two whole turns."""
    eq = FiniteElementModel(BEAM).solve(wrench=(0.0, 0.0, 4.0 * np.pi))
    assert np.abs(eq.pose - [0.0, 0.0, 4.0 * np.pi]).max() < 1e-6


def test_a_soft_spot_keeps_the_accuracy():
    """Elements of half the length, and ends of elements where the stiffness jumps: inside one it would cost 1e-3."""
    neck = Mechanism.preset("slender").replace(**{"soft_spot.size": 0.9})
    eq = FiniteElementModel(neck).solve((40.0, 10.0))
    spot = 0.015 / neck.beam.length
    pieces = [1.0 / 3.0 - 0.5 * spot, spot, 2.0 / 3.0 - 0.5 * spot]
    assert jumps(pack(neck)[None]) == pytest.approx(np.cumsum(pieces)[:2])
    shares = np.repeat(np.array(pieces) / 8.0, 8)
    fine = FiniteElementModel(neck, shares, 6).solve((40.0, 10.0))
    assert np.abs((eq.pose - fine.pose) / [neck.beam.length, neck.beam.length, 1.0]).max() < 1e-6


def test_a_discretization_given_by_hand_is_kept_and_reports():
    """Closed form: two whole turns; one element of order 5 misses by 1.7e-2, and says so."""
    for model in (FiniteElementModel(BEAM, 1), FiniteElementModel(BEAM, order=5), FiniteElementModel(BEAM, gauss=5)):
        eq = model.solve(wrench=(0.0, 0.0, 4.0 * np.pi))
        assert eq.discretization is model.discretization
        off = np.abs(eq.pose - [0.0, 0.0, 4.0 * np.pi]).max()
        assert 1e-2 < off < eq.error < 3.0 * off


@pytest.mark.parametrize("family", ["se2", "strain"])
def test_other_families_report_their_error_too(family):
    """Elliptic integrals, for eight elements of the lowest order."""
    eq = FiniteElementModel(BEAM, 8, 1, family=family).solve(wrench=(0.0, 1.0, 0.0))
    off = np.abs(eq.pose - elastica(1.0)).max()
    assert off < eq.error < 3.0 * off


def test_an_accuracy_out_of_reach_is_said(monkeypatch):
    """Contract: where no finer discretization is allowed, the result says by how much it may be off."""
    monkeypatch.setattr("ecm_fast.models.refinement.MOST_ELEMENTS", 1)
    eq = FiniteElementModel(BEAM).solve(wrench=(0.0, 1000.0, 0.0))
    assert not eq.accurate
    assert "accuracy asked for 1e-06" in eq.message
    assert "error" in repr(eq)


def test_a_batch_refines_the_cases_that_need_it():
    """Elliptic integrals: far bends among gentle ones; the gentle ones stay on the condensed path."""
    alpha = np.array([0.5, 50.0, 1.0, 200.0])
    wrench = np.zeros((4, 3))
    wrench[:, 1] = alpha
    result = FiniteElementModel(BEAM).solve_batch(np.zeros((4, 2)), wrench)
    exact = np.array([elastica(value)[:2] for value in alpha])
    assert result.stable.all()
    assert np.abs(result.pose[:, :2] - exact).max() < 1e-6
    assert result.accurate.all()
    assert (result.error <= 1e-6).all()


def test_a_batch_on_a_discretization_given_by_hand_reports():
    """Closed form: two whole turns, which one element of order 5 misses by 1.7e-2."""
    result = FiniteElementModel(BEAM, 1).solve_batch(np.zeros((1, 2)), [[0.0, 0.0, 4.0 * np.pi]])
    off = np.abs(result.pose[0] - [0.0, 0.0, 4.0 * np.pi]).max()
    assert 1e-2 < off < result.error[0] < 3.0 * off


def test_a_control_step_reports_what_its_order_cannot_hold():
    """Elliptic integrals: a control step keeps its one element, and its `error` says what that leaves."""
    for alpha, worst in ((1.0, 1e-8), (50.0, 1.0)):
        step = FiniteElementModel(BEAM).stepper((0.0, alpha, 0.0))
        pose = np.array(step(0.0, 0.0)[:3])
        off = np.abs(pose - elastica(alpha)).max()
        assert off < step.error < worst
    assert step.error > 1e-6


def test_sensitivities_are_those_of_the_refined_model():
    """Elliptic integrals: sensitivities stand at the pose that keeps the accuracy."""
    found = FiniteElementModel(BEAM).sensitivities(["EI"], np.zeros((1, 2)), [[0.0, 50.0, 0.0]])
    assert np.abs(found.pose[0, :2] - elastica(50.0)[:2]).max() < 1e-6


def test_nodes_and_derivatives_recovered_from_the_condensed_path():
    """The general path on the same discretization: nodes, jacobian and compliance to the size of rounding."""
    model = FiniteElementModel(Mechanism.preset("slender"))
    eq = model.solve((40.0, 10.0))
    general = model._single._solve(loads_of(np.array([[40.0, 10.0]]), np.zeros((1, 3)))[0], None, None)
    assert np.abs(eq.q - general.q).max() < 1e-11
    assert np.abs(eq.jacobian / general.jacobian - 1.0).max() < 1e-7
    assert np.abs(eq.compliance - general.compliance).max() < 1e-9 * np.abs(general.compliance).max()
