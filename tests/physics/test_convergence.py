"""Discretization errors: the orders that theory gives, and the figures that the project states, against the tables."""

import numpy as np
import pytest

from ecm_fast import FiniteElementModel, Mechanism

LAW = {"nh": "neo-hookean", "hooke": "hooke"}
STIFF = 1e3


@pytest.fixture(scope="module")
def elastica(table):
    """Return the tip error of a discretization on the inextensible beam at P L^2 / EI = 10, a tip angle of 82 degrees.

    Under Hooke's law with EA = GA, theta is that of the inextensible beam and the tip is P L / EA farther.
    """
    (row,) = [row for row in table("elastica_transverse_tip_load") if row["alpha"] == 10.0]
    exact = np.array([1.0 - row["u_over_L"], row["w_over_L"] + 10.0 / STIFF, -row["theta_tip_rad"]])
    mechanism = Mechanism().replace(length=1.0, EI=1.0, EA=STIFF, GA=STIFF, axial_law="hooke", g=0.0)

    def error(elements, order, gauss=None):
        model = FiniteElementModel(mechanism, elements, order, gauss)
        return np.abs(model.solve(wrench=(0.0, 10.0, 0.0)).raise_if_failed().pose - exact).max()

    return error


@pytest.mark.parametrize(("order", "coarse"), [(1, 16), (2, 8), (3, 4), (4, 2)])
def test_tip_converges_with_twice_the_order(elastica, order, coarse):
    """Theory: with as many Gauss points as the order, the tip's error falls as h^(2 order).

    The rate is that of two halvings; 0.15 leaves room for the next term of the expansion, as the coarse meshes must
    keep the finest error, 8e-11 for order 4, above that of the table, 1e-11.
    """
    rate = np.log2(elastica(coarse, order) / elastica(4 * coarse, order)) / 2.0
    assert abs(rate - 2 * order) < 0.15


def test_two_gauss_points_lock_linear_elements(elastica):
    """Theory: the shear of a bent linear element cannot vanish at two points, so it is too stiff, the more the thinner.

    The parasitic stiffness is of the relative size GA h^2 / (12 EI) = 0.2 here; one point leaves order h^2 alone.
    """
    one, two = elastica(20, 1, 1), elastica(20, 1, 2)
    assert one < 4e-3
    assert two > 10.0 * one


def test_two_gauss_points_lock_the_more_the_thinner_the_beam():
    """Closed form: a locked element of a linear beam is stiffer by the factor 1 + GA h^2 / (12 EI) in bending.

    The force is so small that the beam is linear: (f L^2 / EI)^2 = 1e-8.
    """
    for stiff in (1e3, 1e5):
        mechanism = Mechanism().replace(length=1.0, EI=1.0, EA=stiff, GA=stiff, axial_law="hooke", g=0.0)
        for gauss, stiffer in ((1, 1.0), (2, 1.0 + stiff / (12.0 * 20**2))):
            theta = FiniteElementModel(mechanism, 20, 1, gauss).solve(wrench=(0.0, 1e-4, 0.0)).raise_if_failed().theta
            # the slope of a linear element is exact at the nodes: what is left is the load squared
            assert abs(theta * stiffer / -0.5e-4 - 1.0) < 1e-8


def test_twenty_linear_elements_on_the_paper_beam(table):
    """Shooting: the paper's discretization leaves 9e-6 for L = 0.040 and 4.2e-4 for L = 0.109 (m or rad).

    The latter is met inside the wrench box, at (-328.752, -57.077, 7.157); at the corners and faces it is 3.2e-4.
    """
    largest = {0.040: 0.0, 0.109: 0.0, "corners": 0.0}
    for row in table("paper_beam_dead_tip_wrench"):
        mechanism = Mechanism().replace(g=0.0, length=row["L_m"], axial_law=LAW[row["law"]])
        model = FiniteElementModel(mechanism, elements=20, order=1)
        pose = model.solve(wrench=(row["fx_N"], row["fz_N"], row["tau_Nm"])).raise_if_failed().pose
        error = np.abs(pose - [row["x_L_m"], row["z_L_m"], row["theta_L_rad"]]).max()
        largest[row["L_m"]] = max(largest[row["L_m"]], error)
        if row["L_m"] == 0.109 and abs(row["tau_Nm"]) == 11.0:
            largest["corners"] = max(largest["corners"], error)
    # from below too: a mistaken table or load would show as an error that is too small for h^2
    assert 8e-6 < largest[0.040] < 9e-6
    assert 4.0e-4 < largest[0.109] < 4.2e-4
    assert 3.1e-4 < largest["corners"] < 3.2e-4


@pytest.mark.parametrize(("preset", "length"), [("paper", 0.040), ("slender", 0.109)])
def test_default_discretization_on_tendon_equilibria(table, preset, length):
    """Shooting: one element of order 6 leaves 1e-8 of the length, as the model's notes say."""
    errors = []
    for row in table("tendon_equilibria"):
        if row["L"] == length:
            changes = {"axial_law": LAW[row["law"]], "mass_per_length": row["rhoA"]}
            changes |= {"head.mass": row["mH"], "h": row["h"], "b": row["b"]}
            if row["routing"] == "pulley":
                changes |= {"pulley_z": 0.0645, "tendons.pulley_radius": 0.0055}
            model = FiniteElementModel(Mechanism.preset(preset).replace(**changes))
            pose = model.solve((row["lambda_l"], row["lambda_r"])).raise_if_failed().pose
            errors.append(pose - [row["x_L"], row["z_L"], row["theta_L_rad"]])
    assert len(errors) == 56
    assert np.abs(errors)[:, :2].max() < 1e-8 * length
    assert np.abs(errors)[:, 2].max() < 1e-8
