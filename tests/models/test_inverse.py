"""The inverse problem: every answer is put back through the model."""

import numpy as np
import pytest

import ecm_fast as ecm

NECK = ecm.Mechanism.preset("slender").replace(pulley_z=0.0645, **{"tendons.pulley_radius": 0.0055})
MODEL = ecm.FiniteElementModel(NECK)
PAIRS = [("theta", "co_contraction"), ("x", "z"), ("x", "theta"), ("z", "theta"), ("x", "co_contraction")]


def wishes_at(lam, names, model=MODEL, wrench=(0.0, 0.0, 0.0)) -> dict[str, float]:
    eq = model.solve(lam, wrench)
    return {name: float(np.mean(lam)) if name == "co_contraction" else getattr(eq, name) for name in names}


@pytest.mark.parametrize("names", PAIRS)
def test_wishes_that_some_forces_meet_are_met(names):
    """Round trip: the wished pose is that of known forces, and the answer leads to it."""
    rng = np.random.default_rng(1)
    sides = [(0.0, 0.0), (160.0, 0.0), (0.0, 160.0), (160.0, 160.0), (0.0, 70.0)]
    for lam in [*rng.uniform(0.0, 160.0, (60, 2)), *sides]:
        wish = wishes_at(lam, names)
        answer = MODEL.inverse(**wish)
        assert (answer >= 0.0).all()
        assert (answer <= 160.0).all()
        for name, value in wishes_at(answer, names).items():
            assert value == pytest.approx(wish[name], abs=2e-7 if name == "co_contraction" else 1e-9)


def test_mirrored_wishes_have_mirrored_answers():
    """Mirror symmetry of a symmetric neck."""
    left, right = MODEL.inverse(theta=0.15, co_contraction=60.0), MODEL.inverse(theta=-0.15, co_contraction=60.0)
    np.testing.assert_allclose(left, right[::-1], atol=1e-6)
    assert left[1] > left[0]


@pytest.mark.parametrize("elements", [1, 10])
def test_a_dead_wrench_counts(elements):
    """Round trip: the forces that made the wish are found again."""
    model, wrench = ecm.FiniteElementModel(NECK, elements, 2), (-20.0, 5.0, 0.4)
    wish = wishes_at((90.0, 60.0), ("z", "theta"), model, wrench)
    np.testing.assert_allclose(model.inverse(**wish, wrench=wrench), (90.0, 60.0), atol=1e-4)
    with pytest.raises(ecm.OutOfReach):  # without it no forces do
        model.inverse(**wish)


def test_out_of_reach_names_the_nearest():
    """Brute force: no forces on a grid come nearer than those that the error names."""
    with pytest.raises(ecm.OutOfReach, match=r"theta = 1 rad, co_contraction = 40 N is out of reach") as caught:
        MODEL.inverse(theta=1.0, co_contraction=40.0)
    # the nearest: one tendon slack, the other at its limit, unless the mean weighs more
    words = str(caught.value)
    forces = np.array([float(word) for word in words[words.rindex("(") + 1 : words.rindex(")")].split(",")])
    reached = wishes_at(forces, ("theta", "co_contraction"))

    def miss(lam):
        own = wishes_at(lam, ("theta", "co_contraction"))
        return (own["theta"] - 1.0) ** 2 + ((own["co_contraction"] - 40.0) / 160.0) ** 2

    assert f"theta = {reached['theta']:.6g} rad" in words
    side = np.linspace(0.0, 160.0, 33)
    assert miss(forces) <= min(miss((left, right)) for left in side for right in side) + 1e-9


@pytest.mark.parametrize(
    "wish", [{"x": 0.2, "z": 0.0}, {"theta": 0.3, "co_contraction": 5.0}, {"z": 0.0, "theta": 0.2}]
)
def test_impossible_wishes_are_refused(wish):
    """Contract: the error offers the nearest."""
    with pytest.raises(ecm.OutOfReach, match="nearest"):
        MODEL.inverse(**wish)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({}, "0 wishes given: allowed are two of x, z, theta, co_contraction"),
        ({"theta": 0.1}, "1 wishes given"),
        ({"theta": 0.1, "x": 0.1, "z": 0.0}, "3 wishes given"),
        ({"theta": float("nan"), "x": 0.1}, "theta = nan: allowed is a finite number"),
        ({"theta": 0.1, "co_contraction": float("inf")}, "co_contraction = inf"),
        ({"theta": 0.1, "x": 0.1, "lam_max": 0.0}, "lam_max = 0.0"),
    ],
)
def test_wishes_that_cannot_be_meant(arguments, text):
    """Contract: the text of the error."""
    with pytest.raises(ecm.InputError, match=text):
        MODEL.inverse(**arguments)
    assert MODEL.inverse(theta=0.1, co_contraction=40.0).shape == (2,)


@pytest.mark.parametrize(("accuracy", "order"), [(1e-3, 3), (2e-4, 3), (1e-4, 4), (1e-6, 5), (1e-8, 6)])
def test_the_accuracy_asked_for_chooses_the_order_and_is_kept(accuracy, order):
    """Finer mesh: four elements of order 6, over the paper's box and the tendon range."""
    rng = np.random.default_rng(3)
    box = rng.uniform([-330.0, -80.0, -11.0], [20.0, 80.0, 11.0], (2000, 3))
    lam = np.concatenate([np.zeros((2000, 2)), rng.uniform(0.0, 160.0, (2000, 2))])
    wrench = np.concatenate([box, np.zeros((2000, 3))])
    for preset in ("slender", "paper"):
        neck = ecm.Mechanism.preset(preset)
        model = ecm.FiniteElementModel(neck, accuracy=accuracy)
        assert model.discretization.order == order
        exact = ecm.FiniteElementModel(neck, 4, 6).solve_batch(lam, wrench, tolerance=1e-13)
        scale = [neck.beam.length, neck.beam.length, 1.0]
        error = np.abs(model.solve_batch(lam, wrench, tolerance=1e-10).pose - exact.pose) / scale
        assert error.max() < accuracy


def test_more_accuracy_than_one_element_has_is_refused():
    """Contract: the text of the error."""
    with pytest.raises(ecm.InputError, match="accuracy = 1e-09"):
        ecm.FiniteElementModel(NECK, accuracy=1e-9)
