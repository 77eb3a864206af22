"""Models, steppers and results that are copied, pickled, sent to other processes, and used by several threads."""

import copy
import os
import pickle
import re
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ecm_fast as ecm
from ecm_fast.mechanism.parameters import size
from ecm_fast.mechanism.vector import pack, unpack

pytestmark = pytest.mark.slow

NECK = ecm.Mechanism.preset("slender").replace(pulley_z=0.0645, **{"tendons.pulley_radius": 0.0055})
MODELS: dict[str, dict[str, Any]] = {
    "condensed": {"order": 4},
    "chain": {"elements": 4, "order": 1},
    "general": {"elements": 1, "order": 2},
    "path": {"order": 4},
}
HOW: dict[str, Any] = {"wrench": (-20.0, 5.0, 0.4), "tolerance": 1e-11}
LOADS = np.random.default_rng(2).uniform(0.0, 160.0, (12, 2)).tolist()
WAYS = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda thing: pickle.loads(pickle.dumps(thing)),
}
every_model = pytest.mark.parametrize("name", MODELS)


def model_of(name: str) -> ecm.FiniteElementModel:
    neck = NECK.replace(tendon_coulomb_friction=3.0, mullins_softening=0.05) if name == "path" else NECK
    return ecm.FiniteElementModel(neck, **MODELS[name])


def in_a_process(program: str, *words: str, **settings: str) -> subprocess.CompletedProcess[str]:
    """Run a program in a fresh interpreter; PYTHONMALLOC and MALLOC_PERTURB_ fill memory that is given back."""
    filled = {"MALLOC_PERTURB_": "165", "PYTHONMALLOC": "malloc"}
    return subprocess.run(
        [sys.executable, "-c", program, *words], capture_output=True, text=True, timeout=280,
        env={**os.environ, **filled, **settings},
    )  # fmt: skip


# Copies


@every_model
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("lam_max", [0.0, 160.0])
def test_a_copy_goes_on_from_where_the_original_stands(name: str, way: str, lam_max: float) -> None:
    """The original, bit for bit; and neither hears of the other afterwards."""
    step = model_of(name).stepper(derivatives=True, lam_max=lam_max, **HOW)
    for lam in LOADS[:4]:
        step(*lam)
    other, jacobian = WAYS[way](step), step.jacobian.copy()
    assert np.array_equal(other.jacobian, jacobian)
    other(150.0, 3.0)
    assert np.array_equal(step.jacobian, jacobian)
    other = WAYS[way](step)
    for lam in LOADS[4:]:
        assert step(*lam) == other(*lam)
        assert np.array_equal(step.jacobian, other.jacobian)
        assert np.array_equal(step.compliance, other.compliance)


@every_model
def test_reset_forgets_every_call(name: str) -> None:
    """A stepper that was just made, bit for bit."""
    model = model_of(name)
    step = model.stepper(**HOW)
    for lam in [*LOADS, (900.0, 800.0), (np.nan, 0.0)]:
        step(*lam)
    step.reset()
    fresh = model.stepper(**HOW)
    assert [step(*lam) for lam in LOADS] == [fresh(*lam) for lam in LOADS]


@every_model
def test_models_and_results_are_pickled(name: str) -> None:
    """Contract: what comes back solves to the same bits, and takes part in everything."""
    model = model_of(name)
    for way in WAYS.values():
        other = way(model)
        assert other.mechanism == model.mechanism
        assert other.discretization == model.discretization
        assert np.array_equal(other.solve(LOADS[0], path="ignore").pose, model.solve(LOADS[0], path="ignore").pose)
        assert other.stepper(**HOW)(*LOADS[1]) == model.stepper(**HOW)(*LOADS[1])
    assert len(pickle.dumps(model)) < 3000  # no tables, no work space
    data = ecm.Measurements.from_columns({"lam_l_N": np.arange(3.0), "lam_r_N": np.arange(3.0)})
    results = [
        model.solve(LOADS[0], path="ignore"),
        model.solve_batch(LOADS, path="ignore"),
        model.sensitivities(["EI"], LOADS, path="ignore"),
        ecm.predict(model.mechanism, data, order=4),
    ]
    for result in results:
        other = pickle.loads(pickle.dumps(result))
        assert np.array_equal(other.pose, result.pose)
        assert repr(other) == repr(result)


def test_polynomial_models_and_training_sets_are_pickled() -> None:
    """The original, bit for bit."""
    known = ecm.training_poses(ecm.FiniteElementModel(NECK, order=4), 100, 0)
    poly = ecm.PolynomialModel.fit(known.poses, known.wrenches)
    other = pickle.loads(pickle.dumps(poly))
    assert np.array_equal(other.wrench(known.poses), poly.wrench(known.poses))
    assert np.array_equal(pickle.loads(pickle.dumps(known)).poses, known.poses)


LIFE = """
import copy, gc, pickle, sys
import numpy as np
import ecm_fast as ecm

neck = ecm.Mechanism.preset("slender")
models = [
    ecm.FiniteElementModel(neck, order=4),
    ecm.FiniteElementModel(neck, 4, 1),
    ecm.FiniteElementModel(neck.replace(tendon_coulomb_friction=3.0), order=4),
]
rng = np.random.default_rng(0)
for i in range(60):
    model = models[i % 3]
    steps = [model.stepper(derivatives=True)]
    expected = [steps[0](*lam) for lam in rng.uniform(0.0, 160.0, (3, 2)).tolist()][-1]
    for way in (copy.copy, copy.deepcopy, lambda step: pickle.loads(pickle.dumps(step))):
        steps.append(way(steps[int(rng.integers(len(steps)))]))
    jacobians = [step.jacobian for step in steps]
    lam = rng.uniform(0.0, 160.0, 2).tolist()
    answers = [step(*lam) for step in steps]
    assert answers == answers[:1] * 4, answers
    kept = steps.pop(int(rng.integers(4)))
    del steps, model
    gc.collect()
    junk = [np.full(size, np.nan) for size in range(1, 2000, 7)]  # into the room that would be free
    again = kept(*lam)
    assert np.abs(np.subtract(again[:3], answers[0][:3])).max() < 1e-9, (again, answers[0])
    assert all(np.isfinite(jacobian).all() for jacobian in jacobians)
print("alive")
"""


def test_a_life_of_copies_touches_no_freed_memory() -> None:
    """Freed memory is filled with noise by the allocator: a read of it would be seen in an answer, or as a crash."""
    done = in_a_process(LIFE)
    assert done.stdout.strip() == "alive", done.stderr[-2000:]


SPAWNED = """
import multiprocessing
import ecm_fast as ecm

def answer(step, lam):
    return step(*lam)

def solved(model, lam):
    return model.solve(lam).pose.tolist()

if __name__ == "__main__":
    model = ecm.FiniteElementModel(order=4)
    step = model.stepper()
    step(60.0, 20.0)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(answer, (step, (61.0, 20.0))) == step(61.0, 20.0)
        assert pool.apply(solved, (model, (61.0, 20.0))) == model.solve((61.0, 20.0)).pose.tolist()
    print("alive")
"""


def test_a_spawned_worker_takes_models_and_steppers(tmp_path: Path) -> None:
    """This process, bit for bit."""
    (tmp_path / "spawned.py").write_text(SPAWNED, encoding="utf-8")
    done = subprocess.run([sys.executable, "spawned.py"], capture_output=True, text=True, timeout=280, cwd=tmp_path)
    assert done.stdout.strip() == "alive", done.stderr[-2000:]


# Effects of the user's own, which are in one process alone

LAW = """
import ecm_fast as ecm

@ecm.effect("{name}", unit="N m", typical=0.2, enters="head")
def law(a, x, z, theta):
    return 0.0, 0.0, -a * theta
"""
LOAD = """
import pickle, sys
import numpy as np
import ecm_fast as ecm
try:
    if sys.argv[1].endswith("npy"):
        par = np.load(sys.argv[1])
        print(*ecm.FiniteElementModel().solve_batch([[40.0, 10.0]], parameters=par[None]).pose[0].tolist())
    else:
        with open(sys.argv[1], "rb") as file:
            print(*pickle.load(file)(40.0, 10.0)[:3])
except ecm.InputError as error:
    print("refused:", error)
"""


def test_what_has_an_effect_of_ones_own_goes_to_other_processes(tmp_path: Path) -> None:
    """This process, where the effect is added; else one sentence, whether none is added there or another one."""
    ecm.effect("own_spring", unit="N m", typical=0.2, enters="head")(lambda a, x, z, theta: (0.0, 0.0, -a * theta))
    try:
        neck = ecm.Mechanism.preset("slender").replace(own_spring=0.4)
        model = ecm.FiniteElementModel(neck)
        np.save(tmp_path / "par.npy", pack(neck))
        (tmp_path / "step.pickle").write_bytes(pickle.dumps(model.stepper()))
        expected = model.solve((40.0, 10.0)).pose
    finally:
        ecm.remove_effect("own_spring")
    for name in ("par.npy", "step.pickle"):
        path = str(tmp_path / name)
        there = in_a_process(LAW.format(name="own_spring") + LOAD, path)
        np.testing.assert_allclose([float(word) for word in there.stdout.split()], expected, rtol=0.0, atol=1e-9)
        for before in ("", LAW.format(name="other_spring")):
            done = in_a_process(before + LOAD, path)
            assert done.stdout.startswith("refused: "), (done.stdout, done.stderr[-2000:])
            assert len(done.stdout.splitlines()) == 1


def test_numbers_that_stand_for_no_law_crash_nothing() -> None:
    """A vector behind the checks' back: no law is called, and there is no equilibrium, rather than a wrong one."""
    ecm.effect("own_spring", unit="N m", typical=0.2, enters="head")(lambda a, x, z, theta: (0.0, 0.0, -a * theta))
    try:
        par = pack(NECK.replace(own_spring=0.4))
        assert par.size == size()
        for place, number in ((-2, 1e300), (-2, -3.0), (-2, np.nan), (-2, par[-2] + 1.0), (-1, np.pi)):
            wrong = par.copy()
            wrong[place] = number
            model = ecm.FiniteElementModel(NECK, order=4)
            with pytest.raises(ecm.InputError, match="add the same ones in the same order first"):
                model.solve_batch([[40.0, 10.0]], parameters=wrong[None])
            with pytest.raises(ecm.InputError, match="add the same ones"):
                unpack(wrong)
            if place == -2:
                model._par = wrong
                model._single.fast = None
                assert model.solve_batch([[40.0, 10.0]]).status[0] == ecm.Status.NOT_CONVERGED
    finally:
        ecm.remove_effect("own_spring")


def test_older_models_keep_the_laws_they_were_made_with() -> None:
    """The neck before: another law under the same name, and places that move, are for models made afterwards."""
    ecm.effect("own_first", unit="N m", typical=0.2, enters="head")(lambda a, x, z, theta: (0.0, 0.0, -a * theta))
    ecm.effect("own_spring", unit="N m", typical=0.2, enters="head")(lambda a, x, z, theta: (0.0, 0.0, -a * theta))
    try:
        model = ecm.FiniteElementModel(NECK.replace(own_spring=0.4))
        before = model.solve((20.0, 120.0)).pose
    finally:
        ecm.remove_effect("own_first")
        ecm.remove_effect("own_spring")
    ecm.effect("own_spring", unit="N m", typical=0.2, enters="head")(
        lambda a, x, z, theta: (0.0, 0.0, -2.0 * a * theta)
    )
    try:
        assert np.array_equal(model.solve((20.0, 120.0)).pose, before)
        stiffer = ecm.FiniteElementModel(NECK.replace(own_spring=0.4)).solve((20.0, 120.0))
        twin = ecm.FiniteElementModel(NECK.replace(rotational_spring=0.8)).solve((20.0, 120.0))
        np.testing.assert_allclose(stiffer.pose, twin.pose, rtol=0.0, atol=1e-12)
    finally:
        ecm.remove_effect("own_spring")


# Threads


@pytest.fixture
def switching() -> Any:
    """Let threads change places as often as the interpreter can."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


@pytest.mark.usefixtures("switching")
def test_one_model_in_many_threads_solves_as_in_one() -> None:
    """The serial run, bit for bit: 3 of 6000 were wrong when threads shared work space."""
    model = ecm.FiniteElementModel(NECK)
    loads = np.random.default_rng(8).uniform(0.0, 160.0, (2000, 2)).tolist()
    alone = [model.solve(lam).pose.tolist() for lam in loads]

    def run(shift: int) -> bool:
        order = [*range(shift, len(loads)), *range(shift)]
        return all(model.solve(loads[i]).pose.tolist() == alone[i] for i in order)

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(run, (0, 500, 1000, 1500)))


@pytest.mark.usefixtures("switching")
def test_one_model_in_many_threads_inverts_as_in_one() -> None:
    """Every answer, put back through the model, meets its wish."""
    model = ecm.FiniteElementModel(NECK, order=4)
    wishes = np.random.default_rng(8).uniform(-0.05, 0.05, 150).tolist()

    def miss(theta: float) -> float:
        return abs(model.solve(model.inverse(theta=theta, co_contraction=60.0)).theta - theta)

    with ThreadPoolExecutor(4) as pool:
        assert max(pool.map(miss, wishes)) < 1e-8


@pytest.mark.usefixtures("switching")
@pytest.mark.parametrize("name", ["condensed", "chain", "general"])
def test_one_stepper_in_two_threads_answers_each_rightly(name: str) -> None:
    """The cold solution at the default tolerance: 5 of 80 000 were wrong when calls could overlap."""
    step = model_of(name).stepper()
    loads = np.random.default_rng(9).uniform(0.0, 160.0, (20_000 if name == "condensed" else 1000, 2))
    exact = model_of(name).solve_batch(loads, tolerance=1e-13).pose
    answers: list[list[Any]] = [[], []]

    def run(into: list[Any], order: int) -> None:
        into.extend(step(*lam) for lam in loads[::order].tolist())

    threads = [threading.Thread(target=run, args=(into, order)) for into, order in zip(answers, (1, -1), strict=True)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for found, order in zip(answers, (1, -1), strict=True):
        table = np.array(found)
        assert (table[:, 3] == ecm.Status.CONVERGED).all()
        assert np.abs(table[:, :3] - exact[::order]).max() < 1e-9


@pytest.mark.usefixtures("switching")
def test_one_path_in_two_threads_is_some_order_of_its_rows() -> None:
    """By hand: whatever the order, the largest load so far is that of all calls, and each call was counted."""
    step = model_of("path").stepper()

    def run(load: float) -> None:
        for _ in range(500):
            assert step(load, load)[3] == ecm.Status.CONVERGED

    threads = [threading.Thread(target=run, args=(load,)) for load in (30.0, 70.0)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert step.state.peak == 140.0 / 320.0


# The small print


def test_derivatives_that_are_not_made_are_an_error() -> None:
    """One line with the cure, as an error of input and as a missing attribute."""
    step = ecm.FiniteElementModel(order=4).stepper()
    for name in ("jacobian", "compliance"):
        with pytest.raises(ecm.InputError, match=rf"^step\.{name} is made .*derivatives=True\)$"):
            getattr(step, name)
        assert not hasattr(step, name)


def test_help_lists_every_status_that_a_step_gives() -> None:
    """Steps themselves, under loads of any size: what they answer stands in ``help(step)``, by number and name."""
    listed = {int(number): name for number, name in re.findall(r"(?m)^ +(\d) ([A-Z_]+) ", ecm.Stepper.__doc__ or "")}
    assert all(ecm.Status(number).name == name for number, name in listed.items())
    loads = np.random.default_rng(3).uniform(-50.0, 1500.0, (300, 2)).tolist()
    given = {model_of(name).stepper()(*lam)[3] for name in MODELS for lam in loads[:: 1 if name == "condensed" else 20]}
    assert {0, 4} < given <= set(listed)
