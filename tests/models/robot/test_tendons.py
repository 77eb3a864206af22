"""Lengths of tendons, tendons given by length, and markers: against shooting (`tests/tables`) and closed forms."""

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from robot_rows import arc, closed_arc, pose_of, robot, sizes, tendon_numbers

import ecm_fast as ecm
from ecm_fast.mechanism.body import Tendon
from ecm_fast.mechanism.mechanism import Mechanism

# the tables are good to 1e-11; a tentacle of a third of the radius at its tip needs the most elements
FINE = {"elements": 32, "order": 6}


def loads_of(row):
    """Return tension by name, and the wrench."""
    tensions = {f"t{i}": row[f"t{i}_tension"] for i in tendon_numbers(row)}
    return tensions, (row["fx"], row["fz"], row["tau"])


@pytest.mark.slow
def test_lengths_and_markers_under_given_forces(table):
    """Shooting: lengths and marker poses of every stable row within 1e-9 of the body's length, and 1e-9 rad."""
    for row in table("guided_planar"):
        eq = ecm.FiniteElementModel(robot(row), **FINE).solve(*loads_of(row))
        if not eq.stable:
            assert row["stable"] == "no"
            continue
        wanted = [row[f"length_{i}"] for i in tendon_numbers(row)]
        assert eq.lengths == pytest.approx(wanted, abs=1e-9 * row["L"])
        for name, pose in eq.markers.items():
            assert (np.abs(pose - pose_of(row, name)) <= 1e-9 * sizes(row)).all(), (row["id"], name)


@pytest.mark.slow
def test_tendons_given_by_length(table):
    """Shooting: pose and forces of every row within 1e-8, slack and compliant tendons too; by default within 1e-6."""
    for row in table("guided_planar_lengths"):
        given = {f"t{i}": row[f"t{i}_given"] for i in tendon_numbers(row)}
        tensions = np.array([row[f"tension_{i}"] for i in tendon_numbers(row)])
        wrench = (row["fx"], row["fz"], row["tau"])
        eq = ecm.FiniteElementModel(robot(row), **FINE).solve(wrench=wrench, lengths=given).raise_if_failed()
        assert (np.abs(eq.pose - pose_of(row, "tip")) <= 1e-8 * sizes(row)).all(), row["id"]
        assert eq.forces == pytest.approx(tensions, abs=1e-8 * tensions.max())
        assert (eq.forces[tensions == 0.0] == 0.0).all()
        for name, pose in eq.markers.items():
            assert (np.abs(pose - pose_of(row, name)) <= 1e-8 * sizes(row)).all()
        usual = ecm.FiniteElementModel(robot(row)).solve(wrench=wrench, lengths=given)
        off = (np.abs(usual.pose - pose_of(row, "tip")) / sizes(row)).max()
        assert off <= 1e-6
        assert off <= usual.error + 1e-10


@pytest.mark.parametrize("force", [0.5, 10.0, 26.18])
def test_one_parallel_tendon_makes_an_arc(force):
    """Closed form, by force and by length, to 180 degrees; a compliant tendon is longer by its compliance."""
    pose, length = closed_arc(force)
    eq = ecm.FiniteElementModel(arc(), **FINE).solve({"t": force}).raise_if_failed()
    assert eq.pose == pytest.approx(pose, abs=1e-11)
    assert eq.lengths == pytest.approx([length], abs=1e-12)
    # dl/dlam = -L (1/EA + o^2/EI)
    assert eq.dlength_dlam == pytest.approx(np.array([[-0.24 * (1.0 / 2000.0 + 1e-4 / 0.02)]]), rel=1e-9)
    soft = ecm.FiniteElementModel(arc(compliance=1e-4), **FINE)
    again = soft.solve(lengths={"t": length - 1e-4 * force}).raise_if_failed()
    assert again.forces == pytest.approx([force], rel=1e-9)
    assert again.pose == pytest.approx(pose, abs=1e-11)


def test_a_length_of_its_own_at_rest_is_slack():
    """Closed form: at its length at rest and beyond a tendon does not pull, and nothing moves with its length."""
    for longer in (1e-6, 0.01):
        eq = ecm.FiniteElementModel(arc()).solve(lengths=[0.24 + longer])
        assert eq.stable
        assert eq.forces.tolist() == [0.0]
        assert eq.pose == pytest.approx([0.24, 0.0, 0.0], abs=1e-14)
        assert eq.dpose_dlength.tolist() == [[0.0], [0.0], [0.0]]


def test_the_pose_by_length_is_that_by_force_over_stroke():
    """Chain rule and closed form: dpose/dl = (dpose/dlam)/(dl/dlam)."""
    eq = ecm.FiniteElementModel(arc(), **FINE).solve(lengths=[closed_arc(10.0)[1]])
    h = 1e-4
    by_force = (closed_arc(10.0 + h)[0] - closed_arc(10.0 - h)[0]) / (2.0 * h)
    assert eq.dpose_dlength[:, 0] == pytest.approx(by_force / (-0.24 * (1.0 / 2000.0 + 1e-4 / 0.02)), rel=1e-7)


def test_a_solution_by_length_survives_a_pickle():
    """Contract: what was solved comes back with its forces and lengths."""
    eq = ecm.FiniteElementModel(arc()).solve(lengths=[0.22])
    again = pickle.loads(pickle.dumps(eq))
    assert (again.x, again.forces.tolist(), again.lengths.tolist()) == (eq.x, eq.forces.tolist(), eq.lengths.tolist())


def chord(name: str, z: float, **changes) -> Tendon:
    return Tendon(name=name, route="chord", plate_z=z, pulley_z=z, **changes)


def test_more_inextensible_chords_than_the_pose_has_freedom():
    """Contract: four lengths for three coordinates are refused by name, and solved with a compliance."""
    four = tuple(chord(name, z) for name, z in zip("abcd", (0.07, 0.03, -0.03, -0.07), strict=True))
    neck = Mechanism(named_tendons=four)
    with pytest.raises(ecm.InputError, match="a, b, c, d, more than the 3 freedoms of the pose; give one a compliance"):
        ecm.FiniteElementModel(neck).solve(lengths=[0.1, 0.1, 0.1, 0.1])
    soft = replace(neck, named_tendons=tuple(replace(tendon, compliance=1e-6) for tendon in four))
    eq = ecm.FiniteElementModel(soft).solve(lengths=[0.105, 0.1065, 0.108, 0.1085]).raise_if_failed()
    assert (eq.forces >= 0.0).all()
    taut = eq.forces > 0.0
    given = np.array([0.105, 0.1065, 0.108, 0.1085])
    assert eq.lengths[taut] == pytest.approx(given[taut] + 1e-6 * eq.forces[taut], abs=1e-12)
    assert (eq.lengths[~taut] <= given[~taut]).all()


def test_named_chords_are_the_pair():
    """Symmetry of description: a pair written as two named chords gives the same pose, jacobian and compliance."""
    pair = Mechanism().replace(pulley_radius=0.005)
    named = replace(pair, named_tendons=(chord("l", 0.07, pulley_radius=0.005), chord("r", -0.07, pulley_radius=0.005)))
    one, other = (ecm.FiniteElementModel(neck).solve((40.0, 10.0), (5.0, -3.0, 0.1)) for neck in (pair, named))
    assert other.pose == pytest.approx(one.pose, abs=1e-13)
    assert other.jacobian == pytest.approx(one.jacobian, rel=1e-9)
    assert other.compliance == pytest.approx(one.compliance, rel=1e-9)
    assert other.lengths == pytest.approx(one.lengths, abs=1e-13)
    # a third chord that pulls is a wrench at its attachment
    third = replace(named, named_tendons=(*named.named_tendons, chord("m", 0.02)))
    model = ecm.FiniteElementModel(third)
    eq = model.solve({"l": 40.0, "r": 10.0, "m": 25.0}, (5.0, -3.0, 0.1))
    lever = np.array([math.sin(eq.theta), math.cos(eq.theta)]) * 0.02
    line = np.array([0.0, 0.02]) - [eq.x, eq.z] - lever
    pull = 25.0 * line / np.hypot(*line)
    couple = lever[1] * pull[0] - lever[0] * pull[1]
    wrench = np.add([5.0, -3.0, 0.1], [*pull, couple])
    # its direction follows the head, so the pose is that of the wrench, the stiffness is not
    assert ecm.FiniteElementModel(named).solve((40.0, 10.0), wrench).pose == pytest.approx(eq.pose, abs=1e-9)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"lam": {"x": 1.0}}, "no tendon is called 'x'; allowed are t"),
        ({"lengths": {"t": -1.0}}, "length of t = -1.0 m: allowed is a number above 0"),
        (
            {"lam": {"t": 1.0}, "lengths": {"t": 0.2}},
            "tendon t is given by force and by length",
        ),
        ({"lam": (1.0, 2.0)}, r"tendon forces have shape \(1, 2\): allowed is 1 a case: t"),
        ({"lengths": [0.2, 0.2]}, r"lengths have shape \(2,\): allowed is \(1,\): t"),
    ],
    ids=["name", "negative", "twice", "forces", "lengths"],
)
def test_tendons_that_cannot_be_meant(arguments, message):
    """Contract: the text of the error, written by hand."""
    with pytest.raises(ecm.InputError, match=message):
        ecm.FiniteElementModel(arc()).solve(**arguments)


def test_the_pair_is_not_given_by_length():
    """Contract: the pair's free lengths have an unknown constant, so lengths are refused for it."""
    with pytest.raises(ecm.InputError, match="the pair of"):
        ecm.FiniteElementModel().solve(lengths=[0.1, 0.1])
