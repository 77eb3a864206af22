"""The control step of robots: against shooting (`tests/tables`) and closed forms."""

import copy
import math
import pickle

import numpy as np
import pytest
from robot_rows import arc, closed_arc, pose_of, robot, sizes, tendon_numbers

import ecm_fast as ecm

FINE = {"elements": 32, "order": 6}
CALLS = 8
"""A far bend from rest takes more Newton steps than a call may; the next call goes on."""


def settled(step, given):
    """Return the answer of the first call that reaches the loads."""
    for _ in range(CALLS):
        answer = step(*given)
        if answer[3] == 0:
            break
    return answer


@pytest.mark.slow
@pytest.mark.parametrize("table_name", ["guided_planar", "guided_planar_lengths"])
def test_steps_are_the_poses_of_shooting(table, table_name):
    """Shooting: from rest to the loads of a row within 1e-8, by force and by length, slack tendons too."""
    for row in table(table_name):
        if row["stable"] == "no":
            continue
        numbers, by_length = tendon_numbers(row), table_name.endswith("lengths")
        model = ecm.FiniteElementModel(robot(row), **FINE)
        wrench = (row["fx"], row["fz"], row["tau"])
        step = model.tendon_stepper(wrench, lengths=[f"t{i}" for i in numbers] if by_length else ())
        x, z, theta, status = settled(step, [row[f"t{i}_given" if by_length else f"t{i}_tension"] for i in numbers])
        assert status == 0, row["id"]
        assert (np.abs(np.array([x, z, theta]) - pose_of(row, "tip")) <= 1e-8 * sizes(row)).all(), row["id"]
        if by_length:
            assert step.forces == pytest.approx([row[f"tension_{i}"] for i in numbers], rel=1e-7, abs=1e-7)


def test_small_steps_follow_the_closed_arc():
    """Closed form: pose, length and both Jacobians of a weightless arc under one parallel tendon."""
    model = ecm.FiniteElementModel(arc(), elements=4, order=6)
    by_force, by_length = model.stepper(), model.tendon_stepper(lengths=["t"])
    h = 1e-4
    for force in np.linspace(1.0, 20.0, 20):
        pose, length = closed_arc(force)
        assert by_force(force) == pytest.approx([*pose, 0], abs=1e-9)
        assert by_force.lengths == pytest.approx([length], abs=1e-11)
        assert by_length(length) == pytest.approx([*pose, 0], abs=1e-9)
        assert by_length.forces == pytest.approx([force], rel=1e-8)
        (higher, longer), (lower, shorter) = closed_arc(force + h), closed_arc(force - h)
        assert by_force.jacobian[:, 0] == pytest.approx((higher - lower) / (2.0 * h), rel=1e-5, abs=1e-9)
        assert by_length.jacobian[:, 0] == pytest.approx((higher - lower) / (longer - shorter), rel=1e-5, abs=1e-6)


def test_what_cannot_be_has_a_status_and_changes_nothing():
    """Contract: nan and INVALID_INPUT for numbers that cannot be meant; the next call is as if nothing had been."""
    model = ecm.FiniteElementModel(arc())
    for step, good in ((model.stepper(), 10.0), (model.tendon_stepper(lengths=["t"]), 0.21)):
        before = settled(step, [good])
        for bad in (math.nan, math.inf, -1.0):
            *pose, status = step(bad)
            assert np.isnan(pose).all()
            assert status == ecm.Status.INVALID_INPUT
            assert np.isnan(step.forces).all()
        assert step(good) == pytest.approx([*before[:3], 0], abs=1e-12)
    with pytest.raises(ecm.InputError, match="2 numbers: allowed is one for each tendon: t"):
        step(1.0, 2.0)
    with pytest.raises(ecm.InputError, match=r"no tendon is called 's'.*allowed are t"):
        model.tendon_stepper(lengths=["s"])
    with pytest.raises(ecm.InputError, match=r"the pair of \[tendons\] has a stepper"):
        ecm.FiniteElementModel().tendon_stepper()


def test_copies_go_on_from_the_same_state():
    """Contract: copies and pickles answer as the original does, and share nothing with it."""
    step = ecm.FiniteElementModel(arc()).tendon_stepper(lengths=["t"])
    settled(step, [0.21])
    twins = [copy.copy(step), copy.deepcopy(step), pickle.loads(pickle.dumps(step))]
    expected = step(0.20)
    assert [twin(0.20) for twin in twins] == 3 * [expected]
    step.reset()
    assert twins[0](0.20)[3] == 0
    assert settled(step, [0.20]) == pytest.approx([*expected[:3], 0], abs=1e-12)
