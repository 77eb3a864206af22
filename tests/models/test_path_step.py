"""Poses that depend on the order of loads: the control step against `predict`, and who refuses them."""

import copy
import functools
import pickle
import re
from typing import Any

import numpy as np
import pytest
from allocations import assert_no_memory

import ecm_fast as ecm
from ecm_fast.__main__ import main
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.mechanism.vector import pack
from ecm_fast.models.polynomial.training import training_poses, training_rows

NECK = ecm.Mechanism.preset("slender").replace(pulley_z=0.0645, **{"tendons.pulley_radius": 0.0055})
EFFECTS: dict[str, dict[str, float]] = {
    effect.name: {effect.size.name: 2.0 * effect.size.typical}
    for effect in CATALOGUE.values()
    if effect.enters == "path"
}
OF_THE_NECK = [name for name in EFFECTS if not name.startswith("camera")]
TOGETHER = {key: value for name in OF_THE_NECK for key, value in EFFECTS[name].items()}
MESHES: dict[str, dict[str, int]] = {
    **{f"order {order}": {"elements": 1, "order": order} for order in (3, 4, 5, 6)},
    "chain": {"elements": 4, "order": 3},
    "general": {"elements": 1, "order": 2},
}


def rows(n: int = 40) -> ecm.Measurements:
    """Return loads that turn back several times, with time stamps and times held, in two sessions."""
    rng, s = np.random.default_rng(4), np.linspace(0.0, 1.0, n)
    return ecm.Measurements.from_columns(
        {
            "lam_l_N": 80.0 + 75.0 * np.sin(11.0 * s),
            "lam_r_N": 80.0 + 75.0 * np.cos(7.0 * s),
            "t_s": 50.0 + np.cumsum(rng.uniform(1.0, 90.0, n)),
            "dwell_s": rng.uniform(0.0, 60.0, n),
            "session": ["morning"] * (n // 2) + ["evening"] * (n - n // 2),
        }
    )


def stepped(step: ecm.Stepper, data: ecm.Measurements) -> np.ndarray:
    """Return poses of the rows by a control step that begins anew with each session."""
    poses = []
    for i in range(data.n):
        if i == 0 or data.session[i] != data.session[i - 1]:
            step.reset()
        *pose, status = step(data.lam_l[i], data.lam_r[i], data.t[i], data.dwell[i])
        assert status == ecm.Status.CONVERGED
        poses.append(pose)
    return np.array(poses)


@pytest.mark.parametrize("name", OF_THE_NECK)
def test_each_effect_is_carried_as_predict_carries_it(name: str) -> None:
    """`predict`, row by row, which reads the whole record: two ways through one record; and the effect is felt."""
    data, neck = rows(), NECK.replace(**EFFECTS[name])
    known = ecm.predict(neck, data, order=4).pose
    assert np.abs(stepped(ecm.FiniteElementModel(neck, order=4).stepper(), data) - known).max() < 1e-12
    assert np.abs(known - ecm.predict(NECK, data, order=4).pose).max() > 1e-6


@pytest.mark.parametrize("mesh", MESHES)
def test_all_effects_together_on_every_path_of_solving(mesh: str) -> None:
    """`predict` on the same mesh."""
    data, neck = rows(), NECK.replace(**TOGETHER)
    known = ecm.predict(neck, data, **MESHES[mesh]).pose
    model = ecm.FiniteElementModel(neck, **MESHES[mesh])
    for how in ({}, {"derivatives": True}, {"lam_max": 160.0}):
        assert np.abs(stepped(model.stepper(**how), data) - known).max() < 1e-12


def test_constant_friction_shifts_the_force() -> None:
    """By hand: a tendon that is pulled in holds 3 N less than its cell reads, one that is let out 3 N more."""
    step = ecm.FiniteElementModel(NECK.replace(tendon_coulomb_friction=3.0)).stepper()
    plain = ecm.FiniteElementModel(NECK)
    for lam, held in (((40.0, 40.0), (37.0, 37.0)), ((60.0, 40.0), (57.0, 43.0)), ((50.0, 40.0), (53.0, 37.0))):
        np.testing.assert_allclose(step(*lam)[:3], plain.solve(held).pose, rtol=0.0, atol=1e-12)


def test_derivatives_are_those_with_the_path_held() -> None:
    """Differences of the mechanism that `PathState.hold` leaves, which has no effect of the path."""
    data, neck = rows(), NECK.replace(**TOGETHER)
    step = ecm.FiniteElementModel(neck).stepper(derivatives=True)
    poses, lam = stepped(step, data), data.lam[-1]
    held = ecm.FiniteElementModel(step.state.hold(neck))
    np.testing.assert_allclose(held.solve(lam).pose, poses[-1], rtol=0.0, atol=1e-12)
    left, right = 1e-3 * np.eye(2)
    ends = held.solve_batch([lam + left, lam - left, lam + right, lam - right], tolerance=1e-13).pose
    differences = np.column_stack([ends[0] - ends[1], ends[2] - ends[3]]) / 2e-3
    np.testing.assert_allclose(step.jacobian, differences, rtol=1e-5, atol=1e-9)


def test_the_state_goes_with_copies_and_is_set_by_reset() -> None:
    """The original: whoever takes over the state goes on as it does, bit for bit."""
    data, model = rows(), ecm.FiniteElementModel(NECK.replace(**TOGETHER))
    step = model.stepper()
    stepped(step, data)
    state, fresh = step.state, model.stepper()
    fresh.reset(state)
    others = [copy.copy(step), copy.deepcopy(step), pickle.loads(pickle.dumps(step)), fresh]
    for lam in ((30.0, 70.0), (35.0, 60.0), (35.0, 65.0)):
        answer = step(*lam, 5000.0, 2.0)
        assert [other(*lam, 5000.0, 2.0) for other in others] == [answer] * 4
    assert all(other.state == step.state != state for other in others)
    step.reset()
    assert step(30.0, 70.0) == model.stepper()(30.0, 70.0)


def test_what_is_no_force_or_time_changes_nothing() -> None:
    """The state and the next answer, with and without the calls between."""
    model = ecm.FiniteElementModel(NECK.replace(**TOGETHER))
    step, clean = model.stepper(derivatives=True), model.stepper()
    assert step(60.0, 20.0, 10.0, 1.0) == clean(60.0, 20.0, 10.0, 1.0)
    before, nan, inf = step.state, np.nan, np.inf
    for bad in ((nan, 1.0), (-1.0, 2.0), (inf, 0.0), (1.0, 2.0, inf), (1.0, 2.0, 11.0, -1.0), (1.0, 2.0, 11.0, inf)):
        *pose, status = step(*bad)
        assert status == ecm.Status.INVALID_INPUT
        assert np.isnan(pose).all()
        assert np.isnan(step.jacobian).all()
    assert step.state == before
    assert step(70.0, 20.0, t=20.0, dwell=0.0) == clean(70.0, 20.0, t=20.0, dwell=0.0)


def test_a_load_without_equilibrium_passes_nothing_on() -> None:
    """`predict`, whose record has the same impossible row."""
    lam = np.array([[40.0, 40.0], [60.0, 30.0], [900.0, 800.0], [50.0, 30.0], [55.0, 20.0]])
    data = ecm.Measurements.from_columns({"lam_l_N": lam[:, 0], "lam_r_N": lam[:, 1]})
    neck = NECK.replace(**TOGETHER)
    known, step = ecm.predict(neck, data), ecm.FiniteElementModel(neck).stepper()
    answers = np.array([step(*row) for row in lam.tolist()])
    assert not np.isfinite(known.pose[2]).any()
    np.testing.assert_allclose(answers[:, :3], known.pose, rtol=0.0, atol=1e-12)


def test_a_step_along_a_path_asks_for_no_memory() -> None:
    """Numba's own count and Python's: thousands of steps leave nothing behind."""
    step = ecm.FiniteElementModel(NECK.replace(**TOGETHER), order=4).stepper(derivatives=True)
    loads = [(80.0 + 70.0 * np.sin(0.01 * i), 80.0 + 70.0 * np.cos(0.02 * i), 1.0, 1.0) for i in range(5000)]
    step(40.0, 10.0, 0.0, 1.0)
    assert_no_memory(step, loads)


# Who knows no order


def solvers(neck: ecm.Mechanism) -> dict[str, Any]:
    model = ecm.FiniteElementModel(neck, order=4)
    rows_of = functools.partial(model.solve_batch, parameters=pack(neck)[None])
    data = ecm.predict(NECK, rows(4)).data
    return {
        "solve": lambda **path: model.solve((40.0, 10.0), **path).pose,
        "solve_batch": lambda **path: model.solve_batch([[40.0, 10.0]], **path).pose,
        "solve_batch of parameters": lambda **path: rows_of([[40.0, 10.0]], **path).pose,
        "sensitivities": lambda **path: model.sensitivities(["EI"], [[40.0, 10.0]], **path).dpose_dpar,
        "inverse": lambda **path: model.inverse(theta=0.05, co_contraction=40.0, **path),
        "training_poses": lambda **path: training_poses(model, 3, 0, **path).poses,
        "training_rows": lambda **path: training_rows(model, data, **path).poses,
    }


@pytest.mark.parametrize("way", [way for way in solvers(NECK) if way != "training_rows"])
def test_what_knows_no_order_refuses_effects_of_the_path(way: str) -> None:
    """By name, with the cure; told to ignore them it is the neck that has none."""
    plain = solvers(NECK)[way]()
    for name, sizes in EFFECTS.items():
        solve = solvers(NECK.replace(**sizes))[way]
        with pytest.raises(ecm.InputError, match=rf"^{name} depends on the loads before, .*path=\"ignore\"$"):
            solve()
        np.testing.assert_allclose(solve(path="ignore"), plain, rtol=0.0, atol=1e-12)
    with pytest.raises(ecm.InputError, match=re.escape("path = 'yes': allowed is")):
        solvers(NECK)[way](path="yes")


def test_training_on_rows_refuses_friction_of_the_tendons() -> None:
    """The wrench of tendons is that of their true forces, which friction makes a matter of order."""
    with pytest.raises(ecm.InputError, match=r"^tendon_coulomb_friction depends on the loads before"):
        solvers(NECK.replace(tendon_coulomb_friction=3.0))["training_rows"]()


def test_a_solve_at_the_state_of_a_stepper_is_its_answer() -> None:
    """The step itself, and `inverse`, put back through the step's mechanism."""
    data, neck = rows(), NECK.replace(**TOGETHER)
    model = ecm.FiniteElementModel(neck)
    step = model.stepper()
    pose, lam, state = stepped(step, data)[-1], data.lam[-1], step.state
    np.testing.assert_allclose(model.solve(lam, path=state).pose, pose, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(model.solve_batch([lam], path=state, tolerance=1e-13).pose[0], pose, rtol=0, atol=1e-12)
    np.testing.assert_allclose(model.stepper(path=state, tolerance=1e-13)(*lam)[:3], pose, rtol=0, atol=1e-12)
    found = model.inverse(theta=pose[2], co_contraction=float(np.mean(lam)), path=state)
    np.testing.assert_allclose(found, lam, atol=1e-5)
    with pytest.raises(ecm.InputError, match="one state does not fit many mechanisms"):
        model.solve_batch([lam], parameters=pack(neck)[None], path=state)


def test_a_stepper_told_to_ignore_the_path_has_no_state() -> None:
    """The neck without the effect, bit for bit."""
    model = ecm.FiniteElementModel(NECK.replace(creep=0.1), order=4)
    step = model.stepper(path="ignore")
    assert step(40.0, 10.0) == ecm.FiniteElementModel(NECK, order=4).stepper()(40.0, 10.0)
    for ask in (lambda: step.state, lambda: step.reset(model.stepper().state)):
        with pytest.raises(ecm.InputError, match="this stepper carries no path"):
            ask()


def test_sweeps_and_commands_refuse_and_ignore(tmp_path: Any, monkeypatch: Any, capsys: Any) -> None:
    """The documented interface: exit code 2 with the name of the effect, or the choice to leave it out."""
    monkeypatch.chdir(tmp_path)
    NECK.replace(tendon_coulomb_friction=3.0).to_toml("neck.toml")
    solve = ["solve", "--tendons", "40", "10", "--mechanism", "neck.toml"]
    assert main(solve) == 2
    assert "tendon_coulomb_friction depends on the loads before, whose order solve does not" in capsys.readouterr().err
    assert main([*solve, "--path", "ignore"]) == 0
    spec = {"sweep": {"cases": 64, "mechanism": "neck.toml"}, "inputs": {"lam_l": [0.0, 160.0]}}
    with pytest.raises(ecm.InputError, match="tendon_coulomb_friction depends"):
        ecm.read_spec(spec)
    with pytest.raises(ecm.InputError, match="creep depends"):
        ecm.read_spec({"sweep": {"cases": 64}, "inputs": {"creep": [0.0, 0.1]}})
    spec["sweep"]["path"] = "ignore"
    assert ecm.sweep(spec, tmp_path / "out", threads=1).statuses["converged"] == 64


def test_a_law_of_rows_of_the_users_own_is_refused() -> None:
    """The documented interface: such a law needs all rows at once."""
    ecm.effect("own_drift", unit="m", typical=1e-3, enters="rows", mirror="path")(
        lambda a, rows: {"camera_z_offset": a * rows.hours}
    )
    try:
        model = ecm.FiniteElementModel(NECK.replace(own_drift=1e-3), order=4)
        with pytest.raises(ecm.InputError, match="own_drift: a law of rows of your own"):
            model.stepper()
        with pytest.raises(ecm.InputError, match="own_drift depends"):
            model.solve()
        assert model.stepper(path="ignore")(40.0, 10.0)[3] == ecm.Status.CONVERGED
    finally:
        ecm.remove_effect("own_drift")
