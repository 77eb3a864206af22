"""Many processes and one cache of compiled kernels: begun at once, on an empty folder, on one that is read only."""

import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="looks at compiled kernels")

SMALL = (
    "import ecm_fast.kernels.trig as t; print(*(repr(f(x)) for f in (t.sincos, t.sincos_near) for x in (0.3, -1.5)))"
)
MODEL = (
    "from ecm_fast import FiniteElementModel, Mechanism as M; print(FiniteElementModel(M(), 2, 1).tip.tobytes().hex())"
)


def start(program: str, cache: Path) -> subprocess.Popen:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    )


def answer(running: subprocess.Popen) -> tuple[str, str]:
    out, err = running.communicate(timeout=280)
    assert running.returncode == 0, err
    return out, err


def files(cache: Path) -> dict[str, int]:
    return {str(path): path.stat().st_mtime_ns for path in cache.rglob("*.nb*")}


def test_ten_processes_begun_at_once_answer_the_same(tmp_path):
    """Contract: one answer, and an eleventh process that compiles nothing."""
    running = [start(MODEL, tmp_path) for _ in range(10)]
    answers = [answer(process) for process in running]
    assert answers == [answers[0]] * 10
    # the eleventh finds everything compiled
    before = files(tmp_path)
    assert any("prepare" in name for name in before)
    assert answer(start(MODEL, tmp_path)) == answers[0]
    assert files(tmp_path) == before


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="needs permissions that bind this user")
def test_a_read_only_cache_is_said_once_and_costs_no_answer(tmp_path):
    """Contract: the answer of a process with a cache, and one warning."""
    expected, _ = answer(start(SMALL, tmp_path / "own"))
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o500)
    out, err = answer(start(SMALL, closed))
    assert out == expected
    assert err.count("no folder for compiled kernels can be written") == 1
    assert list(closed.iterdir()) == []


def test_a_cache_that_cannot_be_a_folder_costs_no_answer(tmp_path):
    """Contract: the answer of a process with a cache, and one warning."""
    expected, _ = answer(start(SMALL, tmp_path / "own"))
    (tmp_path / "file").write_text("here is no folder")
    out, err = answer(start(SMALL, tmp_path / "file"))
    assert out == expected
    assert err.count("no folder for compiled kernels can be written") == 1
