"""Attacks on the files and processes of the package, counted: damaged inputs, signals, kills.

    python3 tools/run.py python bench/robustness/attack.py files 100000
    python3 tools/run.py python bench/robustness/attack.py signals 200
    python3 tools/run.py python bench/robustness/attack.py kills 20

A damaged file must be read, or refused by one line of `InputError`; what a signal leaves must be whole; a sweep that
was killed must end with the bytes of one that was not.
"""

import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from io import BytesIO
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

import ecm_fast as ecm
from ecm_fast.data import readers
from ecm_fast.data.unpack import READERS, answer
from ecm_fast.errors import InputError

COMMAND = [sys.executable, "-m", "ecm_fast"]


def damaged(whole: bytes, rng: random.Random) -> bytes:
    """Return a file with a few bytes changed, lost, doubled or zeroed, or its end cut off."""
    content = bytearray(whole)
    for _ in range(rng.choice((1, 1, 2, 4, 8))):
        at, kind = rng.randrange(len(content) + 1), rng.randrange(5)
        if kind == 0:
            content[at : at + 1] = bytes([rng.randrange(256)])
        elif kind == 1:
            del content[at : at + rng.randrange(1, 9)]
        elif kind == 2:
            content[at:at] = content[at : at + rng.randrange(1, 30)]
        elif kind == 3:
            content[at : at + 8] = bytes(len(content[at : at + 8]))
        else:
            content[at:] = content[at:] if rng.randrange(4) else b""
    return bytes(content)


def targets(folder: Path) -> dict[str, tuple[bytes, Callable[[Path], object]]]:
    """Return whole files by ending, and what reads each."""
    import pyarrow as pa
    from pyarrow import parquet
    from scipy.io import savemat

    columns: dict[str, Any] = {"lam_l_N": [1.0, 20.0, 40.0], "x_mm": [108.0, 107.5, np.nan], "session": ["a", "b", "b"]}
    data = ecm.Measurements.from_columns(columns)
    mat, table = BytesIO(), BytesIO()
    savemat(mat, {**columns, "session": np.array(columns["session"], dtype=object)})
    parquet.write_table(pa.table({**columns, "x_mm": [108.0, 107.5, None]}), table)
    data.to_csv(folder / "a.csv")
    ecm.Mechanism().replace(precurvature=0.2).to_toml(folder / "a.toml")
    rng = np.random.default_rng(0)
    poses = rng.uniform(-1.0, 1.0, (60, 3))
    ecm.PolynomialModel.fit(poses, poses**2, degree=2).to_json(folder / "a.json")
    spec = b"[sweep]\nseed = 1\nsample = 'grid'\n[inputs]\nlam_l = { from = 0.0, to = 9.0, steps = 5 }\nEI = 2.0\n"
    result = {
        "inputs": {"mechanism": None, "data": ["a.csv"], "priors": {"EA": [7500.0, 75.0]}, "noise": {}},
        "models": [{"names": ["precurvature"], "in_set": True, "refused": "", "behind": 0.0}],
        "noise": {"sigma": [1e-4, None, 1e-3], "force": 0.1},
    }
    return {
        "csv": ((folder / "a.csv").read_bytes(), ecm.read_measurements),
        "toml": ((folder / "a.toml").read_bytes(), ecm.Mechanism.from_toml),
        "poly.json": ((folder / "a.json").read_bytes(), ecm.PolynomialModel.from_json),
        "spec.toml": (spec, ecm.read_spec),
        "next.json": (json.dumps(result).encode(), next_result),
        "mat": (mat.getvalue(), ecm.read_measurements),
        "parquet": (table.getvalue(), ecm.read_measurements),
    }


def next_result(path: Path) -> None:
    """Read the result of a diagnosis as the command ``next`` does."""
    from ecm_fast.cli.next_loads import _read

    _read(str(path))


def files(count: int) -> None:
    """Read damaged files, the binary ones in a process that stays and is made anew where one of them ends it."""
    rng, found = random.Random(0), Counter[str]()
    pools = [ProcessPoolExecutor(1, mp_context=get_context("spawn"))]

    def unpacked(content: bytes, path: Path) -> Any:
        try:
            table = pools[-1].submit(answer, path.suffix, content, path).result(timeout=60)
        except BrokenProcessPool:
            found["reader processes that ended"] += 1
            pools.append(ProcessPoolExecutor(1, mp_context=get_context("spawn")))
            raise InputError("its reader ended") from None
        if isinstance(table, str):
            raise InputError(table)
        return table

    readers._READERS.update(dict.fromkeys(READERS, unpacked))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        whole = targets(folder)
        for i in range(count):
            ending = list(whole)[i % len(whole)]
            path, (content, read) = folder / f"b.{ending}", whole[ending]
            path.write_bytes(damaged(content, rng))
            try:
                read(path)
                found[f"{ending} read"] += 1
            except InputError as error:
                found[f"{ending} refused"] += 1
                if len(str(error).splitlines()) != 1:
                    found["refused in more than a line"] += 1
            except Exception as error:
                found[f"{ending} UNEXPECTED {type(error).__name__}: {error}"[:150]] += 1
                print(ending, repr(path.read_bytes())[:600], error, flush=True)
    for pool in pools:
        pool.shutdown()
    report(found)


def signals(count: int) -> None:
    """Send signals at any moment to commands that write, and look at what they leave."""
    rng, found = random.Random(1), Counter[str]()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "run.csv").write_text("lam_l_N,x_mm\n" + "".join(f"{i},107\n" for i in range(50)))
        for i in range(count):
            words = [("effects", "--out", "."), ("init", "--force"), ("predict", "run.csv", "--out", ".")][i % 10 // 4]
            number = rng.choice((signal.SIGINT, signal.SIGTERM, signal.SIGKILL))
            process = subprocess.Popen([*COMMAND, *words], cwd=folder, stdout=-3, stderr=subprocess.PIPE, text=True)
            time.sleep(rng.uniform(0.0, 3.0 if words[0] == "predict" else 0.8))
            process.send_signal(number)
            err = process.communicate(timeout=60)[1]
            found[f"ended {process.returncode}"] += 1
            if "Traceback" in err:
                found[f"traceback after {number.name}"] += 1
                print(err, flush=True)
            for path in folder.iterdir():
                try:
                    _whole(path)
                except Exception:
                    found[f"HALF WRITTEN {path.name}"] += 1
                if path.name.startswith(".") and number == signal.SIGINT:
                    found["temporary files left by an interrupt"] += 1
                if path.name.startswith("."):
                    path.unlink()
    report(found)


def _whole(path: Path) -> None:
    if path.suffix == ".json":
        json.loads(path.read_text())
    elif path.suffix == ".toml":
        assert tomllib.loads(path.read_text())["gravity"]["g"] > 0.0
    elif path.name == "predicted.csv":
        assert path.read_text().count("\n") == 51


def kills(count: int) -> None:
    """Kill a sweep again and again, and compare its files with those of one that nobody disturbed."""
    rng = random.Random(2)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        inputs = "[inputs]\nlam_l = [0, 160]\nfx = [-9, 0]\n"
        (folder / "spec.toml").write_text(f"[sweep]\ncases = 2_000_000\nchunk = 8192\n{inputs}")
        words = [*COMMAND, "sweep", "spec.toml", "--threads", "1", "--out"]
        for _ in range(2):  # what a process has compiled may differ in the last digit from what the next one loads
            subprocess.run([*words, "whole"], cwd=folder, capture_output=True, check=True)
            known = {path.name: path.read_bytes() for path in (folder / "whole").iterdir()}
            for path in (folder / "whole").iterdir():
                path.unlink()
        done = 0
        for _ in range(count):
            process = subprocess.Popen([*words, "parts"], cwd=folder, stdout=-3, stderr=-3)
            before = time.monotonic()
            while process.poll() is None and len(list((folder / "parts").glob("rows-*"))) <= done:
                time.sleep(0.005)
                if time.monotonic() - before > 60.0:
                    break
            time.sleep(rng.uniform(0.0, 0.05))
            process.kill()
            process.wait()
            done = len(list((folder / "parts").glob("rows-*")))
        subprocess.run([*words, "parts"], cwd=folder, capture_output=True, check=True)
        same = {path.name: path.read_bytes() for path in (folder / "parts").iterdir()} == known
        print(
            f"{count} kills, {done} of {len(known) - 6} files there after the last; the same bytes at the end: {same}"
        )


def report(found: Counter[str]) -> None:
    """Print what was counted."""
    for name, number in sorted(found.items()):
        print(f"{number:8} {name}")


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    {"files": files, "signals": signals, "kills": kills}[sys.argv[1]](int(sys.argv[2]))
