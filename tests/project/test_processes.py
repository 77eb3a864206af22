"""Many processes and one cache of compiled kernels: begun at once, on an empty folder, on one that is read only."""

import ast
import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="looks at compiled kernels"),
]

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
    """Return what a process prints, less the line about compiling, which a busy machine may ask for."""
    out, err = running.communicate(timeout=280)
    assert running.returncode == 0, err
    return out, "".join(line for line in err.splitlines(keepends=True) if "compiling kernels, once" not in line)


def files(cache: Path) -> dict[str, int]:
    return {str(path): path.stat().st_mtime_ns for path in cache.rglob("*.nb*")}


def test_ten_processes_begun_at_once_answer_the_same(tmp_path):
    """Contract: one answer, and an eleventh process that compiles nothing."""
    running = [start(MODEL, tmp_path) for _ in range(10)]
    answers = [answer(process)[0] for process in running]
    assert answers == [answers[0]] * 10
    # the eleventh finds everything compiled
    before = files(tmp_path)
    assert any("prepare" in name for name in before)
    assert answer(start(MODEL, tmp_path)) == (answers[0], "")
    assert files(tmp_path) == before


EVERY_WAY = """
import numpy as np
from ecm_fast import FiniteElementModel, PolynomialModel
from ecm_fast.studies.warmup import compilations

model, lam = FiniteElementModel(order=3), np.array([[40.0, 10.0], [80.0, 40.0]])
answers = [model.stepper()(40.0, 10.0), model.stepper(derivatives=True)(40.0, 10.0), model.solve_batch(lam).pose]
answers += [model.sensitivities(["EA"], lam).jacobian]
points = np.random.default_rng(0).normal(size=(30, 3))
polynomial = PolynomialModel.fit(points, points**2, 2)
answers += [polynomial.stepper()(0.1, 0.2, 0.3), polynomial.wrench(points)]
compiled, loaded = compilations()
print(compiled, loaded, b"".join(np.array(answer).tobytes() for answer in answers).hex())
"""


def test_a_second_process_compiles_nothing(tmp_path):
    """The package's own count: control steps, batches, sensitivities and polynomials, of kernels written in memory."""
    compiled, _, answers = answer(start(EVERY_WAY, tmp_path))[0].split()
    assert int(compiled) > 50
    before = files(tmp_path)
    again, taken, same = answer(start(EVERY_WAY, tmp_path))[0].split()
    assert int(again) == 0
    assert int(taken) > 0
    first, second = (np.frombuffer(bytes.fromhex(text)) for text in (answers, same))
    np.testing.assert_allclose(second, first, rtol=1e-13, atol=1e-15)  # sums of arrays depend on where they lie
    assert files(tmp_path) == before


def test_the_cache_knows_every_source_that_a_kernel_imports():
    """Python's own list of modules, after every kernel is imported, is the truth of what kernels are made of."""
    program = """
import importlib, pkgutil, sys
import ecm_fast.kernels
from ecm_fast.kernels._cache import sources

for module in pkgutil.walk_packages(ecm_fast.kernels.__path__, "ecm_fast.kernels."):
    importlib.import_module(module.name)
files = {module.__file__ for name, module in sys.modules.items() if name.startswith("ecm_fast")}
print(len(files), sorted(files - {str(path) for path in sources()}))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT, check=True)
    number, missing = done.stdout.split(maxsplit=1)
    assert int(number) > 40
    # what holds no arithmetic: the package's lazy names, messages of errors
    allowed = [f"{ROOT}/ecm_fast/{name}.py" for name in ("__init__", "errors")]
    assert set(ast.literal_eval(missing)) <= set(allowed)


@pytest.mark.parametrize(
    ("file", "moves"),
    [
        ("kernels/trig.py", True),
        ("kernels/condensed/physics.py", True),
        ("kernels/general/elements/lagrange.py", True),
        ("mechanism/mesh/families/__init__.py", True),
        ("mechanism/catalogue/__init__.py", True),
        ("cli/__init__.py", False),
    ],
)
def test_an_edit_in_any_folder_of_the_kernels_moves_the_cache(tmp_path, file, moves):
    """A copy of the package in which one file is edited: the folder's name changes, or old kernels would come back."""
    copy, folders = tmp_path / "copy", []
    shutil.copytree(ROOT / "ecm_fast", copy / "ecm_fast", ignore=shutil.ignore_patterns("__pycache__"))
    for _ in range(2):
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(copy)}
        program = "from ecm_fast.kernels import _cache; print(_cache.__file__, _cache.CACHE_FOLDER)"
        command = [sys.executable, "-c", program]
        done = subprocess.run(command, capture_output=True, text=True, env=environment, check=True, cwd=tmp_path)
        source, folder = done.stdout.split()
        assert source.startswith(str(copy))
        folders.append(folder)
        with (copy / "ecm_fast" / file).open("a", encoding="utf-8") as edited:
            edited.write("# edited\n")
    assert (folders[0] != folders[1]) == moves


COUNTED = f"{SMALL}; from ecm_fast.kernels._cache import KernelCache as c; print(c.compiled, c.loaded)"


def counted(cache: Path, program: str = COUNTED) -> tuple[str, int, int, str]:
    """Return what the small program prints, how many kernels it compiled and loaded, and what it warned of."""
    out, err = answer(start(program, cache))
    result, counts = out.splitlines()
    compiled, loaded = counts.split()
    return result, int(compiled), int(loaded), err


@pytest.mark.parametrize("damage", ["emptied", "cut", "one bit flipped", "random"])
def test_a_damaged_cache_is_made_anew(tmp_path, damage):
    """Every file in it, in turn at each half: the answer is that of a whole cache, and the third process finds one."""
    expected, compiled, _, _ = counted(tmp_path)
    assert compiled > 0
    kept = [Path(name) for name in files(tmp_path)]
    for path in kept:
        content = bytearray(path.read_bytes())
        if damage == "emptied":
            content = bytearray()
        elif damage == "cut":
            del content[len(content) // 2 :]
        elif damage == "random":
            content = bytearray(np.random.default_rng(0).bytes(len(content)))
        else:
            content[len(content) // 2] ^= 1
        path.write_bytes(content)
    assert counted(tmp_path) == (expected, compiled, 0, "")
    assert counted(tmp_path) == (expected, 0, 2, "")


@pytest.mark.skipif(os.name == "nt", reason="limits the size of a file as POSIX does")
def test_a_full_disk_costs_no_answer(tmp_path):
    """A limit on the size of files stands for a disk that is full: writing fails half-way. One line says so."""
    expected, compiled, _, _ = counted(tmp_path / "roomy")
    full = tmp_path / "full"
    limit = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100)); "
    result, anew, _, err = counted(full, limit + COUNTED)
    assert (result, anew) == (expected, compiled)
    assert len(err.splitlines()) == 1
    assert "compiled kernels cannot be kept" in err
    assert [path for path in full.rglob("*") if path.is_file()] == []


@pytest.mark.skipif(os.name == "nt", reason="owners and modes of POSIX")
@pytest.mark.parametrize("place", ["folder", "parent", "base"])
@pytest.mark.parametrize("fault", ["can be written by other users", "belongs to another user"])
def test_a_cache_that_others_can_fill_is_not_read(tmp_path, place, fault):
    """A pickle runs as whoever reads it: a folder into which, or in whose place, others can put one is refused."""
    base = tmp_path / "cache"
    expected, compiled, _, _ = counted(base)
    folder = {"folder": next((base / "ecm_fast").iterdir()), "parent": base / "ecm_fast", "base": base}[place]
    if fault == "can be written by other users":
        folder.chmod(0o777)
    elif os.geteuid() == 0:
        os.chown(folder, 12345, -1)
    else:
        pytest.skip("only root can give a folder away")
    result, anew, loaded, err = counted(base)
    assert (result, anew, loaded) == (expected, compiled, 0)
    assert len(err.splitlines()) == 1
    assert f"{folder} {fault}" in err


@pytest.mark.skipif(os.name == "nt", reason="owners and modes of POSIX")
def test_a_cache_in_a_folder_like_tmp_is_used(tmp_path):
    """Everybody can write there, but only its owner can move what stands in it (the sticky bit)."""
    base = tmp_path / "cache"
    base.mkdir()
    base.chmod(0o1777)
    _, compiled, _, _ = counted(base)
    assert compiled > 0
    _, *counts, err = counted(base)
    assert (counts, err) == ([0, 2], "")
    assert all(stat.S_IMODE(path.stat().st_mode) & 0o077 == 0 for path in base.rglob("*"))


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="needs permissions that bind this user")
def test_a_read_only_cache_is_said_once_and_costs_no_answer(tmp_path):
    """Contract: the answer of a process with a cache, and one warning."""
    expected, _ = answer(start(SMALL, tmp_path / "own"))
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o500)
    out, err = answer(start(SMALL, closed))
    assert out == expected
    assert err.count("no folder for compiled kernels") == 1
    assert list(closed.iterdir()) == []


def test_a_cache_that_cannot_be_a_folder_costs_no_answer(tmp_path):
    """Contract: the answer of a process with a cache, and one warning."""
    expected, _ = answer(start(SMALL, tmp_path / "own"))
    (tmp_path / "file").write_text("here is no folder")
    out, err = answer(start(SMALL, tmp_path / "file"))
    assert out == expected
    assert err.count("no folder for compiled kernels") == 1
