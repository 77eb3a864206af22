"""Measuring and warming: the arithmetic on a clock made for it, Fig. 7's files, and what a warm-up leaves to compile.

No test here judges a time that was measured.
"""

import csv
import json
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from ecm_fast import Mechanism, Warmup, warmup
from ecm_fast.cli import main
from ecm_fast.errors import InputError
from ecm_fast.pages.plots import shown_time
from ecm_fast.studies.timing import EMPTY, Timing, each_in_turn, in_turn, machine

pytestmark = pytest.mark.slow


class Clock:
    """A clock that only goes on when something works; reading it is free."""

    def __init__(self):
        self.now = 0.0
        self.log = []

    def __call__(self):
        return self.now

    def work(self, name, *times):
        """Return a function that takes each of `times` in turn [s], and the last ever after."""
        left = list(times)

        def way(*args):
            self.log.append(name)
            self.now += left.pop(0) if len(left) > 1 else left[0]

        return way


def test_the_shortest_and_the_middle_repetition_count():
    """By hand: a clock that is made to tick."""
    clock = Clock()
    slow = clock.work("slow", 99.0, 5.0, 3.0, 1.0, 2.0)  # the first call warms up, the second finds how many calls
    found = in_turn({"slow": slow}, seconds=6.0, shortest=1.0, clock=clock)["slow"]
    assert (found.best, found.median, found.repetitions, found.calls) == (1.0, 2.0, 3, 1)


def test_calls_double_until_a_repetition_is_long_enough():
    """By hand: a clock that is made to tick."""
    clock = Clock()
    found = in_turn({"quick": clock.work("quick", 0.25)}, seconds=0.0, shortest=1.5, clock=clock)
    assert found["quick"] == Timing(0.25, 0.25, 3, 8)
    assert found[EMPTY].best == 0.0
    assert found["quick"].per_case == 0.25


def test_ways_are_taken_in_turn():
    """By hand: the order of calls."""
    clock = Clock()
    ways = {name: clock.work(name, 1.0) for name in "ab"}
    in_turn(ways, seconds=4.0, shortest=1.0, clock=clock)
    assert "".join(clock.log) == "aabb" + "ab" * 4


def test_cases_are_counted_and_divided_by():
    """By hand: a clock that is made to tick."""
    clock = Clock()
    ways = {"many": clock.work("many", 8.0), "one": clock.work("one", 1.0)}
    found = in_turn(ways, cases={"many": 16}, seconds=1.0, shortest=0.5, clock=clock)
    assert found["many"].per_case == 0.5
    assert found["many"] / found["one"] == 0.5
    assert repr(found["many"]) == "<Timing: 500 ms a case, best of 3 repetitions of 1 calls, each of 16 cases>"


def test_the_control_is_measured_beside():
    """Contract: an empty call is timed in the same run."""
    found = in_turn({"one": lambda: sum(range(100))}, seconds=0.0, shortest=1e-5)
    assert set(found) == {"one", EMPTY}
    assert found[EMPTY].best > 0.0


def test_each_call_has_its_own_shortest_time():
    """By hand: a clock that is made to tick."""
    clock = Clock()
    way = clock.work("way", 9.0, 4.0, 2.0, 3.0, 5.0, 1.0, 7.0)
    once = clock.work("once", 9.0, 6.0)
    found = each_in_turn(
        {"way": (way, [(1,), (2,), (3,)]), "once": (once, [(1,), (2,)])}, rounds={"way": 2, "once": 1}, clock=clock
    )
    assert found == {"way": [4.0, 1.0, 3.0], "once": [6.0, 6.0]}


def test_times_are_shown_in_the_unit_that_suits():
    """By hand: the texts."""
    shown = [shown_time(seconds) for seconds in (2.5e-10, 1.2345e-7, 9.996e-7, 4.5e-5, 0.0278, 3.0)]
    assert shown == ["0.25 ns", "123 ns", "1 us", "45 us", "27.8 ms", "3 s"]


def test_the_machine_names_what_times_depend_on():
    """Contract: the keys, and NumPy's own version."""
    found = machine()
    assert set(found) == {"processor", "cores", "system", "load", "python", "numba", "llvmlite", "numpy", "scipy"}
    assert found["numpy"] == np.__version__


FRESH = """
import json, sys
import numpy as np
import ecm_fast as ecm
from ecm_fast.studies.warmup import compilations
done = ecm.warmup()
before, again = compilations(), ecm.warmup()
neck = ecm.Mechanism.preset("slender").replace(pulley_z=0.0645, **{"tendons.pulley_radius": 0.0055})
lam = np.random.default_rng(1).uniform(0.0, 160.0, (5000, 2))
for model in (ecm.FiniteElementModel(neck, 1, 4), ecm.FiniteElementModel(neck), ecm.FiniteElementModel(neck, 20, 1)):
    model.solve((40.0, 10.0), (1.0, 2.0, 0.1)).shape(20)
    model.solve_batch(lam[:9].tolist(), np.zeros((9, 3)), threads=2)
    model.solve_batch(lam, tolerance=1e-6)
    model.solve_batch(lam[:9], parameters=np.tile(ecm.pack(neck), (9, 1)))
    model.sensitivities(["EI", "pulley_radius"], lam[:9])
    for options in ({}, {"derivatives": True}, {"lam_max": 160.0}):
        step = model.stepper(**options)
        for loads in ((40.0, 10.0), (41, 11), (500.0, 480.0), (float("nan"), 1.0)):
            step(*loads)
known = ecm.training_poses(model, 100, 0)
for conservative in (False, True):
    poly = ecm.PolynomialModel.fit(known.poses, known.wrenches, conservative=conservative)
    poly.wrench(known.poses[0]), poly.stiffness(known.poses), poly.stepper()(0.1, 0.01, -0.2)
spec = {"sweep": {"cases": 3000, "keep": "statistics"}, "inputs": {"lam_l": [0.0, 160.0], "EI": [2.9, 3.1]}}
ecm.sweep(spec, sys.argv[1])
print(json.dumps([done.compiled, done.from_cache, again.compiled, again.from_cache, before == compilations()]))
"""


@pytest.mark.timeout(900)  # on a fresh machine all of the warm-up is compiled here
def test_after_a_warm_up_nothing_is_compiled_or_loaded(tmp_path):
    """numba's own counters in a fresh process."""
    warmup()  # fills the cache where it is empty
    words = [sys.executable, "-c", FRESH, str(tmp_path)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=280, check=True)
    compiled, from_cache, *again, untouched = json.loads(done.stdout)
    assert (compiled, *again, untouched) == (0, 0, 0, True)
    assert from_cache > 10


def test_the_warm_up_says_what_it_did(capsys, tmp_path):
    """Contract: progress lines and the keys of the JSON."""
    messages = []
    done = warmup(progress=messages.append)
    assert isinstance(done, Warmup)
    assert messages[0] == f"1 of {len(messages)}: one solve"
    assert main(["warmup", "--json", "--out", str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    answer = json.loads(out)
    assert set(answer) == {"seconds", "compiled", "from_cache", "cache"}
    assert (answer["compiled"], answer["from_cache"]) == (0, 0)  # this process has everything
    assert answer["cache"] is None or Path(answer["cache"]).is_dir()
    assert err.count("\n") == len(messages) + 2  # loading the compiler, and what was written
    assert json.loads((tmp_path / "warmup.json").read_text()) == answer


@pytest.fixture(scope="module")
def result():
    pytest.importorskip("matplotlib")
    from ecm_fast.studies.paper.fig7_times import fig7

    return fig7(poses=3, batch=64, rounds=1, threads=2)


def test_fig7_times_every_way_at_every_pose(result):
    """Counting: ways times poses, and order statistics by NumPy."""
    times = np.array(list(result.times.values()))
    assert times.shape == (15, 3)
    assert np.all(times > 0.0)
    assert result.settings["mechanism"] == "preset slender"
    assert repr(result) == "<Fig7: 15 ways, 3 poses each>"
    for row, own in zip(result.rows, times, strict=True):
        assert row["shortest_s"] == own.min() <= row["median_s"] <= row["longest_s"] == own.max()
    ones = [row["way"] for row in result.rows if row["polynomials"] == 1.0]
    assert ones == ["cubic polynomial, one call", "cubic polynomial, batch"]


def test_fig7_draws_every_time(result):
    """Counting: the bars of the figure."""
    figure = result.figure()
    assert [axes.get_ylabel() for axes in figure.axes] == list(result.times)
    for axes in figure.axes:
        assert axes.get_xscale() == "log"
        assert sum(bar.get_height() for bar in axes.patches) == 3


def test_fig7_writes_its_files(result, tmp_path):
    """Round trip through JSON and CSV."""
    paths = result.write(tmp_path)
    assert [path.name for path in paths] == ["bench.json", "bench.csv", "bench.svg", "bench.png"]
    content = json.loads(paths[0].read_text())
    assert len(content["rows"]) == 15
    assert content["settings"]["seed"] == 7
    head, *lines = csv.reader(paths[1].read_text().splitlines())
    columns = {
        name: [float(cell) for cell in cells] for name, cells in zip(head, zip(*lines, strict=True), strict=True)
    }
    assert columns == {f"{name} [s]": own.tolist() for name, own in result.times.items()}
    assert ElementTree.parse(paths[2]).getroot().tag == "{http://www.w3.org/2000/svg}svg"
    assert paths[3].read_bytes().startswith(b"\x89PNG\r\n")


def test_the_command_answers_with_settings_rows_times_and_files(capsys, tmp_path):
    """Contract: the keys of the JSON."""
    pytest.importorskip("matplotlib")
    words = ["bench", "--poses", "2", "--batch", "64", "--rounds", "1", "--seed", "3", "--out", str(tmp_path), "--json"]
    assert main(words) == 0
    out, err = capsys.readouterr()
    answer = json.loads(out)
    assert set(answer) == {"settings", "rows", "times", "files"}
    assert set(answer["rows"][0]) == {"way", "shortest_s", "median_s", "longest_s", "polynomials"}
    assert {"poses", "seed", "batch", "threads", "tolerance", "rounds", "mechanism"} <= set(answer["settings"])
    assert {"processor", "cores", "python", "numba", "ecm-fast"} <= set(answer["settings"])
    assert (answer["settings"]["poses"], answer["settings"]["seed"]) == (2, 3)
    assert all(Path(path).exists() for path in answer["files"])
    assert [len(own) for own in answer["times"].values()] == [2] * 15
    assert err.count("wrote") == 4


@pytest.mark.parametrize("name", ["poses", "batch", "threads", "rounds"])
def test_fig7_refuses_what_it_cannot_count(name):
    """Contract: the text of the error."""
    pytest.importorskip("matplotlib")
    from ecm_fast.studies.paper.fig7_times import fig7

    with pytest.raises(InputError, match=rf"^{name} = 0: allowed is a whole number >= 1$"):
        fig7(**{name: 0})


def test_fig7_refuses_a_neck_that_the_forces_break():
    """Contract: the text of the error."""
    pytest.importorskip("matplotlib")
    from ecm_fast.studies.paper.fig7_times import fig7

    with pytest.raises(InputError, match="no stable pose of this neck"):
        fig7(Mechanism().replace(EI=0.02), poses=50)
