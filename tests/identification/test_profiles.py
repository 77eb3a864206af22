"""Stiffness that changes along the beam: taper and soft spot, against closed forms and another method."""

import numpy as np
import pytest

from ecm_fast import FiniteElementModel, InputError, Mechanism
from ecm_fast.data.measurements import Measurements
from ecm_fast.mechanism.parameters import index
from ecm_fast.mechanism.vector import pack
from ecm_fast.testbed import equilibria

FREE = Mechanism().replace(g=0.0, axial_law="hooke")
TAPER, SPOT = {"stiffness_taper": 0.1}, {"soft_spot.size": 0.4, "soft_spot.place": 0.4, "soft_spot.width": 0.02}
ALIGNED = [0.4 * 0.109 - 0.01, 0.02, 0.6 * 0.109 - 0.01]


def compliance_share(neck):
    """Mean of 1/profile over the beam, by hand: a logarithm for the taper, lengths for the soft spot."""
    t, v = neck.effects.get("stiffness_taper", 0.0), neck.effects.get("soft_spot.size", 0.0)
    assert t * v == 0.0
    taper = np.log((1.0 + t) / (1.0 - t)) / (2.0 * t) if t else 1.0
    return taper + neck.effects.get("soft_spot.width", 0.015) / neck.beam.length * v / (1.0 - v)


@pytest.mark.parametrize("effect", [TAPER, SPOT], ids=["taper", "spot"])
def test_pure_bending_and_pure_compression(effect):
    """Closed forms: under a couple the tip turns by tau times the beam's compliance, under a push it shortens by it.

    6 Gauss points integrate 1/(1 + 0.1 u), its pole at u = -10, to 20^-12 = 2e-16.
    """
    neck = FREE.replace(**effect)
    beam, share = neck.beam, compliance_share(neck)
    for elements in (1, 7, ALIGNED):  # the soft spot's compliance is kept wherever the elements end
        model = FiniteElementModel(neck, elements, 6)
        bent = model.solve(wrench=(0.0, 0.0, 5.0)).raise_if_failed()
        assert bent.theta == pytest.approx(5.0 * beam.length / beam.EI * share, rel=1e-11)
        pushed = model.solve(wrench=(-50.0, 0.0, 0.0)).raise_if_failed()
        assert pushed.x - beam.length == pytest.approx(-50.0 * beam.length / beam.EA * share, rel=1e-10)
    rows = Measurements.from_columns({"lam_l_N": [0.0, 0.0], "fx_N": [0.0, -50.0], "tau_Nm": [5.0, 0.0]})
    (_, _, theta), (x, _, _) = equilibria(neck, rows).raise_if_failed().pose
    assert theta == pytest.approx(5.0 * beam.length / beam.EI * share, rel=1e-10)
    assert x - beam.length == pytest.approx(-50.0 * beam.length / beam.EA * share, rel=1e-9)


@pytest.mark.parametrize(("size", "place", "width"), [(0.2, 1 / 3, 0.015), (0.4, 0.15, 0.015), (0.4, 0.48, 0.007)])
def test_one_element_sees_where_a_soft_spot_is(size, place, width):
    """The strong form integrates up to the spot's ends: sharing it out by cells of the Gauss points misses 8e-4."""
    neck = Mechanism().replace(**{"soft_spot.size": size, "soft_spot.place": place, "soft_spot.width": width})
    rows = Measurements.from_columns({"lam_l_N": [160.0, 20.0, 90.0], "lam_r_N": [0.0, 140.0, 90.0]})
    known = equilibria(neck, rows).raise_if_failed().pose
    off = FiniteElementModel(neck).solve_batch(rows.lam).pose - known
    assert np.abs(off / [0.109, 0.109, 1.0]).max() < 5e-5


def test_a_spot_over_the_whole_beam_is_a_softer_beam():
    """Equivalence: a beam of 0.8 times the stiffness."""
    everywhere = Mechanism().replace(**{"soft_spot.size": 0.2, "soft_spot.place": 0.5, "soft_spot.width": 1.0})
    softer = Mechanism().replace(EA=0.8 * 7500.0, GA=0.8 * 2420.0, EI=0.8 * 3.0)
    one, other = (FiniteElementModel(neck).solve((90.0, 20.0)).pose for neck in (everywhere, softer))
    np.testing.assert_allclose(one, other, rtol=1e-13)


@pytest.mark.parametrize("elements", [1, ALIGNED], ids=["one", "aligned"])
def test_sensitivities_where_the_stiffness_varies(elements):
    """Central differences: steps of 1e-4 of a parameter err by 1e-8 of the derivative, beside rounding."""
    neck = Mechanism().replace(**TAPER, **SPOT)
    names = ["EA", "GA", "EI", "stiffness_taper", "soft_spot.size", "soft_spot.place", "soft_spot.width"]
    model, lam, par = FiniteElementModel(neck, elements, 4), [[90.0, 20.0]], pack(neck)
    found = model.sensitivities(names, lam)
    for column, name in enumerate(names):
        if elements == 1 or ("place" not in name and "width" not in name):  # ends of the spot: a kink there
            step = 1e-4 * par[index(name)] * np.eye(par.size)[index(name)]
            above, below = (
                model.solve_batch(lam, parameters=(par + sign * step)[None], tolerance=1e-13).pose for sign in (1, -1)
            )
            difference = (above - below)[0] / (2.0 * step.max())
            np.testing.assert_allclose(
                found.dpose_dpar[0, :, column], difference, rtol=2e-6, atol=1e-9 / step.max() * 1e-4
            )


def test_what_no_profile_can_be():
    """Contract: the text of the error."""
    for name, value in {"stiffness_taper": 1.0, "soft_spot.size": 1.0, "soft_spot.place": -0.1}.items():
        with pytest.raises(InputError, match=f"^effects.{name} = .*: allowed is a finite number from "):
            Mechanism().replace(**{name: value})


@pytest.mark.parametrize("division", [(1, 5), (ALIGNED, 4), (9, 1)], ids=["element", "aligned", "chain"])
def test_the_fast_paths_meet_the_general_path(division):
    """Another method: the general path."""
    model = FiniteElementModel(Mechanism().replace(**TAPER, **SPOT), *division)
    lam = np.random.default_rng(3).uniform(0.0, 160.0, (20, 2))
    one_by_one = [model.solve(loads).raise_if_failed().pose for loads in lam]
    np.testing.assert_allclose(model.solve_batch(lam, tolerance=1e-13).pose, one_by_one, rtol=0.0, atol=1e-12)
