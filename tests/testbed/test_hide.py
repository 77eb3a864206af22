"""Sealed measurements: the truth is in the data, nothing else is, and the data do not say what."""

import json

import numpy as np
import pytest
from scipy import stats

from ecm_fast import Mechanism, Truth, hide, read_measurements
from ecm_fast.__main__ import main
from ecm_fast.errors import InputError
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.mechanism.sections import EFFECT_QUANTITIES
from ecm_fast.testbed import DESIGNS, OUTSIDE, design, equilibria, laws
from ecm_fast.testbed.sealed.hide import NOISES, TOLERANCES, conditions, drawn

pytestmark = pytest.mark.slow

SIGMA = np.array([1e-4, 1e-4, 1e-3])


def built(truth, neck=None):
    """Return the mechanism that a truth describes."""
    effects = {f"effects.{name}": value for name, value in {**truth.effects, **truth.tolerance}.items()}
    return (neck or Mechanism()).replace(**truth.values, **effects)


def test_the_truth_explains_the_data_to_the_noise():
    """Chi-squared: residuals of the truth; without the hidden effects ten times more."""
    data, truth = hide(effects={"precurvature": -0.3, "contact_stop": None}, design="grid7", seed=5, noise="geometry")
    assert truth.names == ("precurvature", "contact_stop")
    assert set(truth.tolerance) == set(TOLERANCES)
    residual = (data.pose - equilibria(built(truth), data).pose) / SIGMA
    low, high = stats.chi2(residual.size).ppf([1e-5, 1.0 - 1e-5])
    assert low < np.sum(residual**2) < high
    without = (data.pose - equilibria(Mechanism(), data).pose) / SIGMA
    assert np.sum(without**2) > 10.0 * high


def test_the_seed_makes_all_of_it():
    """Contract: the same seed, the same bytes; another seed, other data."""
    one, other, third = (hide(effects={"random": None}, design="grid2", seed=seed, noise="force") for seed in (3, 3, 4))
    assert one[1] == other[1] != third[1]
    np.testing.assert_array_equal(one[0].pose, other[0].pose)
    assert (one[0].pose != third[0].pose).all()


def test_noise_and_effect_are_drawn_apart():
    """The same seed with another effect has the same loads and the same material."""
    (plain, clean), (bent, truth) = (hide(effects=e, design="grid2", seed=8) for e in ({}, {"precurvature": None}))
    np.testing.assert_array_equal(plain.lam, bent.lam)
    assert clean.values == truth.values
    assert clean.kind == "clean"
    assert truth.kind == "effect"


def test_sizes_are_half_to_twice_the_typical_one():
    """Contract: the documented range, over all effects."""
    sizes = {}
    for seed, (name, effect) in enumerate(CATALOGUE.items()):
        inside, outside = drawn({name: None}, np.random.default_rng(seed))
        assert not outside
        assert set(inside) == {entry.name for entry in effect}
        assert all(EFFECT_QUANTITIES[key].check(value) == value for key, value in inside.items())
        sizes[name] = inside[effect.size.name] / effect.size.typical
    low, high = min(map(abs, sizes.values())), max(map(abs, sizes.values()))
    assert 0.5 <= low < 0.6
    assert 1.9 < high <= 2.0
    assert stats.kstest(np.abs(list(sizes.values())), stats.uniform(0.5, 1.5).cdf).pvalue > 1e-4
    assert min(sizes.values()) < 0.0
    assert all(sizes[name] > 0.0 for name in ("creep", "clamp_rotation_compliance", "force_gain"))


def test_the_material_is_as_believed_or_scattered_like_its_tests():
    """Published: the scatter of the paper's Table 1."""
    assert hide(design="grid2", seed=1, spread=False)[1].values == {"EA": 7500.0, "GA": 2420.0, "EI": 3.0}
    values = hide(design="grid2", seed=1)[1].values
    assert 0.0 < abs(values["EA"] / 7500.0 - 1.0) < 0.05
    assert 0.0 < abs(values["EI"] / 3.0 - 1.0) < 0.017


@pytest.mark.parametrize("name", OUTSIDE)
def test_effects_outside_the_catalogue_can_be_hidden(name):
    """Contract: a hidden effect shows above the noise of the camera."""
    data, truth = hide(effects={name: None}, design="grid4", seed=2, noise="none", spread=False)
    assert truth.kind == "outside"
    assert 0.5 <= truth.outside[name] / OUTSIDE[name].typical <= 2.0
    assert np.abs((data.pose - equilibria(Mechanism(), data).pose) / SIGMA).max() > 1.0


def test_what_the_conditions_say_is_in_the_data():
    """By hand: rows, replicates and instruments of one set of conditions."""
    taken = conditions("force+tails+undeclared+frame")
    assert (taken.sensors.force_sigma, taken.sensors.tail_dof, taken.frame, taken.geometry) == (0.2, 3.0, True, False)
    data, truth = hide(design="grid4", seed=1, noise="force+tails+undeclared+frame")
    assert data.n == 16 + 10 * 4
    assert sorted(np.unique(data.pose_id, return_counts=True)[1].tolist()) == [1] * 6 + [5] * 10
    assert not np.isfinite(data.sigma_x).any()
    assert set(truth.tolerance) == {
        "camera_x_offset",
        "camera_z_offset",
        "camera_rotation",
        "marker_angle_offset",
    }
    assert truth.kind == "clean"


def test_every_noise_can_be_combined():
    """Contract: all noises at once give finite readings."""
    data, _ = hide(design="grid2", noise="+".join(name for name in NOISES if name not in ("none", "undeclared")))
    assert np.isfinite(data.pose).all()


def test_designs():
    """By hand: counts and extremes of every design."""
    rows = {name: design(name, seed=1) for name in DESIGNS}
    counts = {"T": 81, "T1": 45, "S": 9, "C": 7, "M": 9, "W": 25, "G": 14, "B": 50}
    assert {name: loads.n for name, loads in rows.items()} == counts
    assert (rows["T1"].lam_l >= rows["T1"].lam_r).all()
    assert (np.ptp(rows["S"].fz), rows["C"].fx.min(), np.ptp(rows["M"].tau)) == (132.0, -300.0, 12.0)
    assert (rows["W"].extra_mass == 2.0).all()
    there, back = rows["B"].lam[:25], rows["B"].lam[25:]
    np.testing.assert_array_equal(there, back[::-1])
    assert np.abs(np.diff(there, axis=0)).sum(axis=1).max() == 40.0  # one step of the grid at a time
    for loads in rows.values():
        assert (loads.dwell >= 5.0).all()
        assert (loads.dwell <= 120.0).all()
        assert (np.diff(loads.t) > loads.dwell[1:]).all()
    both = design("T+S", sessions=3, seed=2)
    assert both.session.tolist() == ["1"] * 27 + ["2"] * 27 + ["3"] * 27 + ["4"] * 9
    assert equilibria(Mechanism(), in_all := design("C+M+W+G+S")).stable.all()
    assert in_all.n == 64


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        ({"design": "Q"}, "design = 'Q': allowed are T, T1, S, C, M, W, G, B, grid2 to grid100, joined with +"),
        ({"noise": "tail"}, r"noise = 'tail': allowed are white, .*\(did you mean 'tails'\?\)"),
        ({"effects": {"precurvatur": 1.0}}, r"effect 'precurvatur': no such effect \(did you mean 'precurvature'\?\)"),
        ({"effects": {"precurvature": 0.0}}, "precurvature: without a size nothing is hidden; give precurvature a num"),
        ({"effects": {"contact_stop.angle": 0.3}}, "contact_stop: without a size .* give contact_stop.stiffness a num"),
        ({"effects": {"contact_stop.angle": None}}, "contact_stop.angle: its value must be given"),
        ({"effects": {"precurvature": 1e9}}, "effects.precurvature = 1000000000.0: allowed is"),
    ],
)
def test_what_cannot_be_hidden(ask, message):
    """Contract: the text of the error."""
    with pytest.raises(InputError, match=f"^{message}"):
        hide(**ask)


def test_effects_that_a_user_adds_are_not_drawn():
    """Contract: the catalogue as shipped."""
    assert set(laws.BUILT_IN) == set(CATALOGUE)


def test_a_truth_survives_its_file(tmp_path):
    """Round trip, and the text of errors."""
    truth = Truth({"precurvature": 0.2}, {"slack": 9.0}, {}, {"EA": 7500.0}, "T+S", "force", 3)
    assert Truth.from_json(truth.to_json(tmp_path / "truth.json")) == truth
    assert repr(truth) == (
        "<Truth: precurvature = 0.2, slack (in no catalogue) = 9 hidden in design T+S, noise force, seed 3>"
    )
    for text, message in (
        ("{", "cannot be read as a truth"),
        ("[]", "no truth; allowed is one object"),
        (None, "cannot"),
    ):
        path = tmp_path / "bad.json"
        path.unlink(missing_ok=True)
        if text is not None:
            path.write_text(text)
        with pytest.raises(InputError, match=message):
            Truth.from_json(path)
    (tmp_path / "bad.json").write_text(json.dumps({**json.loads((tmp_path / "truth.json").read_text()), "seed": "x"}))
    with pytest.raises(InputError, match=r"seed = 'x': not what a truth has there$"):
        Truth.from_json(tmp_path / "bad.json")


def test_by_command_the_data_do_not_say_what_is_hidden(tmp_path, capsys):
    """Contract: no hidden name or size in the data file."""
    words = ["hide", "--effect", "random", "--effect", "side_force=2", "--design", "grid2", "--noise", "force"]
    assert (
        main([*words, "--seed", "6", "--out", str(tmp_path / "o"), "--truth", str(tmp_path / "t.json"), "--json"]) == 0
    )
    message = json.loads(capsys.readouterr().out)
    assert message == {"data": str(tmp_path / "o/sealed.csv"), "truth": str(tmp_path / "t.json"), "rows": 4}
    truth = Truth.from_json(message["truth"])
    assert truth.effects["side_force"] == 2.0
    assert len(truth.names) == 2
    text = (tmp_path / "o/sealed.csv").read_text()
    assert not [name for name in (*CATALOGUE, *OUTSIDE) if name in text]
    data, _ = hide(effects={"random": None, "side_force": 2.0}, design="grid2", noise="force", seed=6)
    np.testing.assert_array_equal(read_measurements(message["data"]).pose, data.pose)


def test_by_command_a_name_twice(capsys):
    """Contract: the text of the error."""
    assert main(["hide", "--effect", "creep", "--effect", "creep=0.1"]) == 2
    assert capsys.readouterr().err == "ecm-fast: --effect: a name is given twice; say each once\n"
