"""Sweeps: which cases they solve, what they keep, and that neither stops nor workers change a byte of it."""

import csv
import hashlib
import itertools
import json
import math
import os
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats
from scipy.stats import qmc

import ecm_fast as ecm
from ecm_fast.errors import InputError
from ecm_fast.files import write_whole
from ecm_fast.studies.sweeps import read_spec, sweep
from ecm_fast.studies.sweeps.sampling import cases
from ecm_fast.studies.sweeps.scheduler import TRIES, run
from ecm_fast.studies.sweeps.statistics import Channel

pytestmark = pytest.mark.slow

parquet = pytest.importorskip("pyarrow.parquet")

LAM = {"lam_l": [0.0, 160.0], "lam_r": [0.0, 160.0]}
SMALL = {"sweep": {"cases": 3000, "chunk": 512, "seed": 5}, "inputs": {**LAM, "EI": {"mean": 3.0, "std": 0.1}}}
# tendon forces far beyond those of the paper, at which part of the cases buckle or snap
STRONG = {"sweep": {"cases": 800, "chunk": 64}, "inputs": {"lam_l": [0.0, 1200.0], "lam_r": [0.0, 1200.0]}}


def changed(spec: dict[str, Any], **settings: Any) -> dict[str, Any]:
    return {**spec, "sweep": {**spec["sweep"], **settings}}


def swept_by_another_process(spec: Any, folder: Path) -> Path:
    """Sweep in a new process, which finds its kernels compiled.

    What a process has just compiled may differ from what the next one loads in the last digit: the linker may take
    another copy of a function that both share.
    """
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(sweep, spec, folder).result().folder


def columns_of(folder: Path) -> dict[str, np.ndarray]:
    tables = [parquet.read_table(path) for path in sorted(folder.glob("*.parquet"))]
    return {name: np.concatenate([t[name].to_numpy() for t in tables]) for name in tables[0].column_names}


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def inputs_of(spec: dict[str, Any]) -> np.ndarray:
    plan = read_spec(spec)
    return np.concatenate([np.stack(cases(plan, number), axis=1) for number in range(plan.chunks)])


# which cases


def test_a_grid_is_every_combination_the_last_input_fastest() -> None:
    """itertools.product by hand."""
    spec = {
        "sweep": {"sample": "grid", "chunk": 64},
        "inputs": {
            "EI": {"values": [3.0, 2.0, 2.5]},
            "fx": 1.0,
            "lam_l": {"from": 0.0, "to": 60.0, "steps": 7},
            "lam_r": {"from": 1.0, "to": 2.0, "steps": 5},
        },
    }
    known = list(itertools.product([3.0, 2.0, 2.5], np.linspace(0.0, 60.0, 7), np.linspace(1.0, 2.0, 5)))
    assert inputs_of(spec) == pytest.approx(np.array(known), abs=1e-14)


@pytest.mark.parametrize("seed", [0, 7])
def test_sobol_points_are_scipys(seed: int) -> None:
    """SciPy's Sobol sequence with the same seed."""
    spec = {"sweep": {"sample": "sobol", "cases": 5000, "chunk": 256, "seed": seed}, "inputs": {**LAM, "fx": [0, 1]}}
    sampler = qmc.Sobol(3, bits=30, seed=np.random.default_rng(seed))
    known = np.concatenate([sampler.random(4096), sampler.random(4096)[:904]]) + 2.0**-31
    assert inputs_of(spec) == pytest.approx(known * [160.0, 160.0, 1.0], rel=1e-14)


def test_random_inputs_have_the_distributions_asked_for() -> None:
    """Kolmogorov-Smirnov and chi-squared tests."""
    inputs = {
        "lam_l": [20.0, 60.0],
        "EI": {"mean": 3.0, "std": 0.5},
        "soft_spot.size": {"mean": 0.9, "std": 0.2},
        "lam_r": {"values": [1.0, 2.0, 4.0]},
    }
    lam, bending, soft, chosen = inputs_of({"sweep": {"cases": 20000, "chunk": 4096}, "inputs": inputs}).T
    assert stats.kstest(lam, "uniform", (20.0, 40.0)).pvalue > 1e-3
    assert stats.kstest(bending, "norm", (3.0, 0.5)).pvalue > 1e-3
    assert soft.max() <= 0.99  # the bound of the parameter cuts the normal distribution off
    assert stats.kstest(soft, stats.truncnorm(-10.9 / 0.2, 0.09 / 0.2, 0.9, 0.2).cdf).pvalue > 1e-3
    assert stats.chisquare(np.unique(chosen, return_counts=True)[1]).pvalue > 1e-3
    assert abs(np.corrcoef([lam, bending, soft, chosen]) - np.eye(4)).max() < 0.04


def test_a_chunk_depends_on_nothing_but_its_number() -> None:
    """Contract: the same chunk from two readings; different chunks differ."""
    plan = read_spec(SMALL)
    again = read_spec(changed(SMALL))
    for own, other in zip(cases(plan, 3), cases(again, 3), strict=True):
        assert np.array_equal(own, other)
    assert not np.intersect1d(cases(plan, 2)[0], cases(plan, 3)[0]).size


# what is kept


def test_rows_are_the_models_own_solves(tmp_path: Path) -> None:
    """Another way in: `solve` of the same case."""
    done = sweep({**SMALL, "inputs": {**SMALL["inputs"], "fz": [-3.0, 3.0], "tau": 0.1}}, tmp_path / "new" / "here")
    rows = columns_of(done.folder)
    assert list(rows) == ["lam_l_N", "lam_r_N", "beam.EI", "fz_N", "x_m", "z_m", "theta_rad", "status"]
    assert (done.cases, done.solved, len(rows["x_m"]), len(done.files)) == (3000, 3000, 3000, 6)
    assert done.statuses["converged"] == 3000
    for i in (0, 511, 512, 2999):
        neck = ecm.Mechanism().replace(EI=float(rows["beam.EI"][i]))
        eq = ecm.FiniteElementModel(neck).solve(
            (rows["lam_l_N"][i], rows["lam_r_N"][i]), (0.0, float(rows["fz_N"][i]), 0.1)
        )
        assert [rows[name][i] for name in ("x_m", "z_m", "theta_rad")] == pytest.approx(eq.pose, abs=1e-8)
    assert done.dataset().count_rows() == 3000
    schema = parquet.read_schema(done.files[5])
    assert [str(kind) for kind in schema.types] == 7 * ["double"] + ["int8"]
    assert not any(entry.nullable for entry in schema)
    assert [schema.field(i).metadata[b"unit"] for i in range(4)] == [b"N", b"N", b"N m^2", b"N"]
    assert json.loads(schema.metadata[b"ecm_fast"])["statuses"]["converged"] == 3000 - 5 * 512


def test_the_order_of_a_grid_does_not_change_its_poses(tmp_path: Path) -> None:
    """Contract: the order of the inputs changes nothing but the order of the rows."""
    side = {"from": 0.0, "to": 160.0, "steps": 25}
    widths = {"values": [0.05, 0.07]}
    slow = {"plate_half_width": widths, "lam_l": side, "lam_r": side}
    fast = {"lam_l": side, "lam_r": side, "plate_half_width": widths}
    tables = []
    for name, inputs in (("slow", slow), ("fast", fast)):
        done = sweep({"sweep": {"sample": "grid", "mechanism": ecm.Mechanism()}, "inputs": inputs}, tmp_path / name)
        rows = columns_of(done.folder)
        order = np.lexsort((rows["lam_r_N"], rows["lam_l_N"], rows["tendons.plate_half_width"]))
        tables.append(np.stack([rows[key][order] for key in sorted(rows)], axis=1))
    assert tables[0] == pytest.approx(tables[1], abs=1e-9)


def test_failed_cases_are_counted_and_listed_with_their_inputs(tmp_path: Path) -> None:
    """Counted in the rows themselves."""
    done = sweep(STRONG, tmp_path / "a")
    rows = columns_of(done.folder)
    failed = np.flatnonzero(rows["status"])
    assert 100 < failed.size < 700
    assert sum(done.statuses.values()) == 800
    assert done.statuses["converged"] == 800 - failed.size
    with (done.folder / "failures.csv").open() as file:
        listed = list(csv.DictReader(file))
    assert [int(case["case"]) for case in listed] == failed.tolist()
    for case in listed[::50]:
        row = int(case["case"])
        assert (float(case["lam_l_N"]), float(case["lam_r_N"])) == (rows["lam_l_N"][row], rows["lam_r_N"][row])
        assert ecm.Status[case["status"].upper()] == rows["status"][row]
        assert 0.0 < float(case["load_factor"]) < 1.0


@pytest.mark.parametrize("spec", [SMALL, STRONG], ids=["all stable", "many failures"])
def test_statistics_are_those_of_the_rows(spec: dict[str, Any], tmp_path: Path) -> None:
    """NumPy and SciPy on the kept rows."""
    rows = columns_of(sweep(spec, tmp_path / "rows").folder)
    done = sweep(
        changed(spec, keep="statistics") | {"statistics": {"bins": 50, "z_m": [-0.01, 0.02]}}, tmp_path / "own"
    )
    found = json.loads((done.folder / "statistics.json").read_text())
    stable = rows["status"] == 0
    assert found["statuses"] == {status.name.lower(): int((rows["status"] == status).sum()) for status in ecm.Status}
    assert (found["channels"]["z_m"]["low"], found["channels"]["z_m"]["high"]) == (-0.01, 0.02)
    for name, channel in found["channels"].items():
        values = rows[name][stable]
        moments = [values.mean(), values.std(ddof=1), stats.skew(values), stats.kurtosis(values)]
        assert list(channel["moments"].values()) == pytest.approx(moments, rel=1e-9)
        edges = np.linspace(channel["low"], channel["high"], 51)
        known = np.histogram(values, np.concatenate([[-np.inf], edges, [np.inf]]))[0]
        assert np.abs(np.array(channel["counts"]) - known).sum() <= 2  # a value may lie on an edge to rounding
        for word, place in (("least", np.argmin(values)), ("most", np.argmax(values))):
            row = int(np.flatnonzero(stable)[place])
            assert (channel[word]["value"], channel[word]["case"]) == (values[place], row)
            assert channel[word]["lam_l_N"] == rows["lam_l_N"][row]
    assert not list(done.folder.glob("*.parquet"))


def test_moments_of_parts_are_those_of_the_whole() -> None:
    """NumPy and SciPy on the whole sample."""
    values = np.random.default_rng(0).gamma(2.0, size=1000) + 1e3
    whole = Channel(0.0, 1.0, np.zeros(3, dtype=np.int64))
    for part in np.split(values, [1, 1, 40, 700]):
        away = part - part.mean() if part.size else part
        sums = (part.size, part.mean() if part.size else 0.0, *(float((away**power).sum()) for power in (2, 3, 4)))
        whole.add(Channel(0.0, 1.0, np.zeros(3, dtype=np.int64), sums))
    known = [values.mean(), values.std(ddof=1), stats.skew(values), stats.kurtosis(values)]
    assert list(whole.moments.values()) == pytest.approx(known, rel=1e-9)


def test_no_case_that_is_stable_has_no_histogram(tmp_path: Path) -> None:
    """Contract: the text of the error, or empty statistics."""
    hopeless = {"sweep": {"cases": 200, "keep": "statistics"}, "inputs": {"lam_l": [9e3, 9.1e3], "lam_r": 9e3}}
    with pytest.raises(InputError, match=r"^no case tried is stable: lower the loads, or give statistics\.x_m"):
        sweep(hopeless, tmp_path / "a")
    ranges = {"x_m": [0.0, 1.0], "z_m": [0.0, 1.0], "theta_rad": [0.0, 1.0]}
    sweep({**hopeless, "statistics": ranges}, tmp_path / "b")
    channel = json.loads((tmp_path / "b" / "statistics.json").read_text())["channels"]["x_m"]
    assert (channel["least"], set(channel["moments"].values()), sum(channel["counts"])) == (None, {None}, 0)


# stopping and going on


class StoppedError(Exception):
    pass


@pytest.mark.parametrize("keep", ["rows", "statistics"])
def test_a_sweep_that_stops_goes_on_and_ends_with_the_same_files(
    keep: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Contract: the bytes of an uninterrupted run."""
    monkeypatch.setattr("ecm_fast.studies.sweeps.resume._CHECKPOINT", 0.0)
    spec = changed(STRONG, keep=keep)
    sweep(spec, tmp_path / "whole", threads=1)

    def stop(done: int, total: int) -> None:
        if done not in (0, total) and done > before[0]:
            before[0] = done
            raise StoppedError

    before, stops = [0], 0
    while True:
        try:
            done = sweep(spec, tmp_path / "parts", threads=2, progress=stop)
            break
        except StoppedError:
            stops += 1
            (tmp_path / "parts" / ".rows-0000001.parquet.x7").write_bytes(b"half")
    assert stops >= 3
    assert done.solved < 800
    assert contents(tmp_path / "parts") == contents(tmp_path / "whole")
    assert sweep(spec, tmp_path / "parts").solved == 0


def test_a_file_that_was_cut_off_is_written_again(tmp_path: Path) -> None:
    """Contract: the bytes of an uninterrupted run."""
    whole = contents(sweep(SMALL, tmp_path).folder)
    for number, content in enumerate((b"", whole["rows-0000001.parquet"][:3000], b"\0" * 5000)):
        (tmp_path / f"rows-{number:07d}.parquet").write_bytes(content)
    assert sweep(SMALL, tmp_path).solved == 3 * 512
    assert contents(tmp_path) == whole


@pytest.mark.parametrize("damage", ["a byte", "a hole", "the checksums"])
def test_a_damaged_file_is_found_and_written_again(damage: str, tmp_path: Path) -> None:
    """Truth: the bytes of the sweep that nobody disturbed."""
    whole = contents(sweep(SMALL, tmp_path).folder)
    size = len(whole["rows-0000001.parquet"])
    places = (6, size // 3, size // 2, size - 300, size - 20)  # rows and what the file says about itself
    for place in places if damage != "the checksums" else (100,):
        name = "rows.sha256" if damage == "the checksums" else "rows-0000001.parquet"
        content = bytearray(whole[name])
        if damage == "a hole":
            content[place : place + 16] = bytes(16)
        else:
            content[place] ^= 1
        if bytes(content) == whole[name]:
            continue
        (tmp_path / name).write_bytes(content)
        assert sweep(SMALL, tmp_path).solved == 512
        assert contents(tmp_path) == whole


def test_the_checksums_are_those_that_sha256sum_reads(tmp_path: Path) -> None:
    """The tool of the coreutils, where there is one."""
    done = sweep(SMALL, tmp_path)
    lines = (tmp_path / "rows.sha256").read_text().splitlines()
    assert lines == [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}" for path in done.files]
    if tool := shutil.which("sha256sum"):
        subprocess.run([tool, "--check", "--quiet", "rows.sha256"], cwd=tmp_path, check=True)


@pytest.mark.parametrize("keep", ["rows", "statistics"])
def test_results_of_another_sweep_do_not_come_back(keep: str, tmp_path: Path) -> None:
    """Truth: the same sweep in a folder of its own; here another and longer one left its files without sweep.json."""
    sweep(changed(SMALL, keep=keep, cases=4000), tmp_path / "own")
    (tmp_path / "own" / "sweep.json").unlink()
    other = changed(SMALL, keep=keep, seed=6)
    done = sweep(other, tmp_path / "own")
    assert done.solved == 3000
    assert contents(done.folder) == contents(sweep(other, tmp_path / "fresh").folder)


def test_a_damaged_checkpoint_is_not_gone_on_from(tmp_path: Path) -> None:
    """One digit of a sum changed: JSON alone does not notice."""
    whole = contents(sweep(changed(SMALL, keep="statistics"), tmp_path).folder)
    text = whole["statistics.json"].decode()
    place = text.index('"sums": [') + 9
    (tmp_path / "statistics.json").write_text(f"{text[:place]}7{text[place + 1 :]}")
    assert sweep(changed(SMALL, keep="statistics"), tmp_path).solved == 3000
    assert contents(tmp_path) == whole


OWN = """
import numpy as np
import ecm_fast as ecm

FACTOR = 0.5


@ecm.effect("cable_pull", unit="N m", typical=0.5, enters="head", law="tau - a/2 sin(theta)", mirror="even")
def cable_pull(a, x, z, theta):
    return 0.0, 0.0, -FACTOR * a * np.sin(theta)
"""


@pytest.mark.parametrize("keep", ["rows", "statistics"])
@pytest.mark.parametrize("form", ["varied", "fixed", "built", "unused"])
def test_a_sweep_with_an_effect_of_the_users_own(
    form: str, keep: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Truth: the model's single solves of the same mechanism with the effect."""
    from ecm_fast.cli import main

    (tmp_path / "own.py").write_text(OWN)
    (tmp_path / "neck.toml").write_text("[effects]\ncable_pull = 0.4\n" if form == "built" else "")
    given = {"varied": "cable_pull = [0.0, 1.0]\n", "fixed": "cable_pull = 0.3\n"}.get(form, "")
    settings = f"[sweep]\ncases = 200\nchunk = 64\nkeep = '{keep}'\nmechanism = 'neck.toml'\n"
    (tmp_path / "spec.toml").write_text(f"{settings}[inputs]\nlam_l = [0, 90]\n{given}")
    words = ["sweep", str(tmp_path / "spec.toml"), "--plugin", str(tmp_path / "own.py"), "--out", str(tmp_path / "out")]
    try:
        assert main([*words, "--json"]) == 0, capsys.readouterr().err
        assert json.loads(capsys.readouterr().out)["statuses"]["converged"] == 200
        if keep == "rows":
            rows = columns_of(tmp_path / "out")
            size = rows.get("effects.cable_pull", np.full(200, {"fixed": 0.3, "built": 0.4}.get(form, 0.0)))
            for i in (0, 70, 199):
                neck = ecm.Mechanism().replace(cable_pull=float(size[i]))
                eq = ecm.FiniteElementModel(neck).solve((rows["lam_l_N"][i], 0.0))
                assert rows["theta_rad"][i] == pytest.approx(eq.theta, abs=1e-8)
    finally:
        ecm.remove_effect("cable_pull")


def test_processes_know_the_effects_of_a_file(tmp_path: Path) -> None:
    """A spawned process has not run the file; its text goes with the sweep. Truth: the rows of this process."""
    (tmp_path / "own.py").write_text(OWN)
    spec = changed({**SMALL, "inputs": {**LAM, "cable_pull": [0.0, 1.0]}}, cases=1000)
    ecm.load_effects(tmp_path / "own.py")
    try:
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            theirs = columns_of(sweep(spec, tmp_path / "theirs", executor=pool).folder)
        mine = columns_of(sweep(spec, tmp_path / "mine").folder)
    finally:
        ecm.remove_effect("cable_pull")
    for name, values in mine.items():
        assert theirs[name] == pytest.approx(values, abs=1e-12)


def test_a_killed_process_leaves_what_the_next_one_needs(tmp_path: Path) -> None:
    """Contract: the bytes of an uninterrupted run, after SIGKILL."""
    spec = tmp_path / "spec.toml"
    spec.write_text("[sweep]\ncases = 200000\nchunk = 4096\n[inputs]\nlam_l = [0, 160]\nfx = [-30, 0]\n")
    swept_by_another_process(spec, tmp_path / "compiled")
    whole = contents(swept_by_another_process(spec, tmp_path / "whole"))
    words = [sys.executable, "-m", "ecm_fast", "sweep", str(spec), "--threads", "1", "--out"]
    process = subprocess.Popen([*words, str(tmp_path / "parts")], stderr=subprocess.PIPE, stdout=subprocess.PIPE)
    while not list((tmp_path / "parts").glob("rows-000000[5-9].parquet")) and process.poll() is None:
        time.sleep(0.001)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    assert not (tmp_path / "parts" / "summary.json").exists()
    there = len(list((tmp_path / "parts").glob("rows-*.parquet")))
    assert 0 < there < 49
    assert contents(swept_by_another_process(spec, tmp_path / "parts")) == whole


HOLD = """
import os, sys, time
from ecm_fast.studies.sweeps import sweep

def hold(done, cases):
    child = os.fork() if hasattr(os, "fork") else -1
    if child:
        print(child, flush=True)
    time.sleep(100)
    os._exit(0)

sweep(sys.argv[1], sys.argv[2], progress=hold)
"""


def test_a_folder_is_locked_until_its_process_is_killed(tmp_path: Path) -> None:
    """Contract: refused while the process lives, free when it is dead."""
    spec = tmp_path / "spec.toml"
    spec.write_text("[sweep]\ncases = 100\n[inputs]\nlam_l = [0, 160]\n")
    words = [sys.executable, "-c", HOLD, str(spec), str(tmp_path / "out")]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        child = int(process.stdout.readline())
        try:
            with pytest.raises(InputError, match=r"out: another run is writing it; wait for its end, or give another"):
                sweep(spec, tmp_path / "out")
            process.kill()
            process.wait()
            assert sweep(spec, tmp_path / "out").solved == 100  # though a process that it forked is still there
        finally:
            process.kill()
            if child > 0:
                os.kill(child, signal.SIGKILL)


def test_two_runs_in_one_process_do_not_write_one_folder(tmp_path: Path) -> None:
    """Contract: the text of the error."""

    def again(done: int, cases: int) -> None:
        with pytest.raises(InputError, match=r"another run is writing it"):
            sweep(SMALL, tmp_path / "a" / ".." / "a")
        counts.append(done)

    counts: list[int] = []
    sweep(SMALL, tmp_path / "a", progress=again)
    assert len(counts) == 7
    assert sweep(SMALL, tmp_path / "a").solved == 0


def test_threads_that_write_at_once_leave_permissions_alone(tmp_path: Path) -> None:
    """The operating system's umask, before and after."""
    before, interval = os.umask(0o027), sys.getswitchinterval()
    sys.setswitchinterval(1e-6)  # threads take turns as often as they can
    try:
        with ThreadPoolExecutor(8) as pool:
            list(pool.map(lambda number: write_whole(tmp_path / f"{number}", ""), range(800)))
        assert os.umask(0o027) == 0o027
        assert {path.stat().st_mode & 0o777 for path in tmp_path.iterdir()} == {0o640}
    finally:
        os.umask(before)
        sys.setswitchinterval(interval)


def test_another_sweep_in_the_folder_is_left_alone(tmp_path: Path) -> None:
    """Contract: the text of the error, and unchanged bytes."""
    sweep(SMALL, tmp_path)
    before = contents(tmp_path)
    with pytest.raises(InputError, match=r"holds another sweep \(its sweep\.json says which\); give another folder$"):
        sweep(changed(SMALL, seed=6), tmp_path)
    assert contents(tmp_path) == before


# who solves


class Unreliable(ThreadPoolExecutor):
    """Fails now and then, as workers do; `breaks` after so many units as a pool does that has lost one."""

    def __init__(self, breaks: float = math.inf) -> None:
        super().__init__(2)
        self.left, self.number = breaks, 0

    def submit(self, function: Any, /, *args: Any, **options: Any) -> Future[Any]:
        self.left, self.number = self.left - 1, self.number + 1
        if self.left < 0:
            raise BrokenExecutor("a worker was lost")
        return super().submit(self._lose if self.number % 3 == 0 else function, *args, **options)

    @staticmethod
    def _lose(*_: object) -> None:
        raise ConnectionError("gone")


def test_lost_workers_lose_nothing(tmp_path: Path) -> None:
    """Contract: the bytes of an undisturbed run."""
    whole = contents(sweep(SMALL, tmp_path / "whole").folder)
    pools: list[Executor] = []

    def make() -> Executor:
        pools.append(Unreliable(breaks=4))
        return pools[-1]

    assert contents(sweep(SMALL, tmp_path / "a", executor=make).folder) == whole
    assert len(pools) >= 2  # how many more depends on which thread was first
    with Unreliable() as pool:
        assert contents(sweep(SMALL, tmp_path / "b", executor=pool).folder) == whole


def test_a_pool_that_only_breaks_ends_the_run() -> None:
    """Contract: a bounded number of tries, then the error."""
    taken: list[int] = []
    with pytest.raises(BrokenExecutor):
        run(lambda: Unreliable(breaks=0), abs, range(3), lambda *_: None, 2)
    calls: list[int] = []
    with pytest.raises(ValueError, match="wrong"), ThreadPoolExecutor(1) as pool:
        run(pool, lambda n: calls.append(n) or int("wrong"), [8], lambda n, _: taken.append(n), 2)
    assert (len(calls), taken) == (TRIES, [])


def test_processes_write_the_same_bytes(tmp_path: Path) -> None:
    """Contract: the bytes of a run in threads."""
    swept_by_another_process(SMALL, tmp_path / "compiled")
    whole = contents(swept_by_another_process(SMALL, tmp_path / "whole"))
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        assert contents(sweep(SMALL, tmp_path / "own", executor=pool).folder) == whole


def test_a_cluster_writes_the_same_bytes_after_a_kill(tmp_path: Path) -> None:
    """Contract: the bytes of a run on one machine."""
    distributed = pytest.importorskip("distributed", reason="no cluster here: distributed is not installed")
    spec = changed(SMALL, cases=30000)
    swept_by_another_process(SMALL, tmp_path / "compiled")
    whole = contents(swept_by_another_process(spec, tmp_path / "whole"))
    options = {"n_workers": 2, "threads_per_worker": 1, "host": "127.0.0.1", "dashboard_address": None}
    with distributed.LocalCluster(processes=True, **options) as machines, distributed.Client(machines) as client:
        pids = list(client.run(os.getpid).values())

        def kill(done: int, total: int) -> None:
            if pids and done > total // 4:
                os.kill(pids.pop(), signal.SIGKILL)
                del pids[:]

        done = sweep(spec, tmp_path / "own", executor=machines.scheduler_address, progress=kill)
    assert not pids
    assert contents(done.folder) == whole


def test_a_cluster_that_is_not_there(tmp_path: Path) -> None:
    """Contract: the text of the error."""
    with pytest.raises(
        InputError, match=r"^(a cluster needs the package distributed: pip|cluster 'nowhere:1': no sche)"
    ):
        sweep(SMALL, tmp_path, executor="nowhere:1")


# what cannot be


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "inputs: nothing varies; allowed is at least one input with more than one value"),
        ("[inputs]\nlam_l = [0, 1]", "sweep.cases is missing: a sample that is 'random' needs the number of cases"),
        ("[sweep]\ncases = 0\n[inputs]\nlam_l = [0, 1]", "sweep.cases = 0: allowed is a whole number from 1 to"),
        ("[sweep]\ncases = 2_000_000_000\nsample = 'sobol'\n[inputs]\nlam_l = [0, 1]", "sweep.cases = 2000000000: al"),
        ("[sweep]\nsample = 'sobel'", "sweep.sample = 'sobel': allowed is 'grid' or 'random' or 'sobol' (did you mea"),
        ("[sweep]\nchunk = 1000\n[inputs]\nlam_l = [0, 1]", "sweep.chunk = 1000: allowed is a power of two"),
        ("[sweep]\nseeds = 1", "unknown key sweep.seeds (did you mean 'seed'?); allowed are sample, cases"),
        ("[input]", "unknown key input (did you mean 'inputs'?); allowed are sweep, inputs, statistics"),
        ("inputs = 3", "inputs = 3: allowed is a table, written [inputs]"),
        ("[inputs]\nlam_x = 1", "inputs.lam_x: no parameter is called 'lam_x'"),
        ("[inputs]\nEII = 1", "inputs.EII: no parameter is called 'EII' (did you mean 'EI'?); loads are lam_l, lam"),
        ("[inputs]\nEI = 'soft'", "inputs.EI = 'soft': allowed is a number, [from, to], or a table with"),
        ("[inputs]\nEI = [3, 1]", "inputs.EI = [3, 1]: allowed is a range that ends above its beginning"),
        ("[inputs]\nEI = [1, 2, 3]", "inputs.EI = "),
        ("[inputs]\nlam_l = [-1, 5]", "inputs.lam_l.from = -1: allowed is a finite number from 0"),
        ("[inputs]\nlam_l = [0, nan]", "inputs.lam_l.to = nan: allowed is a finite number from 0"),
        ("[inputs]\nsoft_spot.size = 5", "inputs.soft_spot"),
        ("[inputs]\nEI = {values = []}", "inputs.EI.values = []: allowed is a list of numbers"),
        ("[inputs]\nEI = {values = [1, true]}", "inputs.EI.values[1] = True: allowed is a finite number from 1e-12"),
        ("[inputs]\nEI = {mean = 3, std = 0}", "inputs.EI.std = 0: allowed is a positive number"),
        ("[inputs]\nEI = {mean = 3}", "inputs.EI = {'mean': 3}: allowed in a sample that is 'random' is"),
        ("[inputs]\nEI = [1, 2]\n'beam.EI' = 3", "inputs: beam.EI is given twice, by its short name and in full"),
        ("[inputs]\naxial_law = 1", "inputs.axial_law = 1: the law is no number; say it in the mechanism file"),
        (
            "[sweep]\nsample = 'grid'\n[inputs]\nEI = [1, 2]",
            "inputs.EI = {'from': 1, 'to': 2}: allowed in a sample",
        ),
        ("[sweep]\nsample = 'grid'\ncases = 3\n[inputs]\nEI = {values = [1, 2]}", "sweep.cases = 3: allowed is none"),
        ("[sweep]\nmechanism = 'gone.toml'\ncases = 1\n[inputs]\nEI = [1, 2]", "gone.toml: cannot be read (No such fi"),
        ("[sweep]\nmechanism = 3\ncases = 1\n[inputs]\nEI = [1, 2]", "sweep.mechanism = 3: allowed is the name of a m"),
        (
            "[statistics]\nz_m = 3\n[sweep]\ncases = 1\n[inputs]\nEI = [1, 2]",
            "statistics.z_m = 3: allowed is [from,",
        ),
        ("[inputs", "not a TOML file ("),
    ],
)
def test_a_spec_that_cannot_be_is_refused_in_one_line(text: str, complaint: str, tmp_path: Path) -> None:
    """Contract: one line that names the file and the cure."""
    path = tmp_path / "spec.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        sweep(path, tmp_path / "out")
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert complaint in message
    assert "\n" not in message
    assert not (tmp_path / "out").exists()


def test_arguments_that_cannot_be(tmp_path: Path) -> None:
    """Contract: the text of the error."""
    with pytest.raises(InputError, match=r"^threads = 0: allowed is a whole number from 1 up$"):
        sweep(SMALL, tmp_path / "a", threads=0)
    with ThreadPoolExecutor(1) as pool, pytest.raises(InputError, match=r"with an executor leave it out$"):
        sweep(SMALL, tmp_path / "a", threads=2, executor=pool)
    file = write_whole(tmp_path / "file", "")
    with pytest.raises(InputError, match=r"file: cannot be made \(File exists\)$"):
        sweep(SMALL, file)


def test_a_text_says_everything_about_a_sweep() -> None:
    """Round trip; and any changed number changes the digest."""
    plan = read_spec({**STRONG, "statistics": {"x_m": [0.0, 1.0]}})
    assert ecm.SweepSpec.from_text(plan.text) == plan
    for name, value in (("seed", 1), ("cases", 799), ("tolerance", 1e-8), ("mechanism", ecm.Mechanism.preset("paper"))):
        assert read_spec(changed(STRONG, **{name: value})).digest != read_spec(STRONG).digest


def test_the_command_tells_of_its_progress(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Contract: progress on stderr, one JSON object on stdout."""
    from ecm_fast.cli import main
    from ecm_fast.cli import sweep as command

    spec = tmp_path / "spec.toml"
    spec.write_text("[sweep]\ncases = 2000\nchunk = 64\n[inputs]\nlam_l = [0, 160]\nfx = [-30, 0]\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(command, "_ON_LINES", 0.0)
        assert main(["sweep", str(spec), "--out", str(tmp_path / "out"), "--json"]) == 0
    ended = capsys.readouterr()
    answer = json.loads(ended.out)
    assert (answer["cases"], answer["solved"], answer["files"]) == (2000, 2000, 32)
    assert answer["statuses"]["converged"] == 2000
    lines = ended.err.splitlines()
    assert lines[0].startswith("ecm-fast:   0%|")
    assert " 0/2000 [00:" in lines[0]
    assert "cases/s]" in lines[-3]
    assert " 2000/2000 [" in lines[-2]
