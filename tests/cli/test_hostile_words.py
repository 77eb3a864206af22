"""Words, settings and files that no command can use: exit code 2 and one line, never 1, "unexpected"."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ecm_fast as ecm
from ecm_fast.cli import main
from ecm_fast.errors import InputError
from ecm_fast.identification.noise import ReadingNoise
from ecm_fast.identification.rows import State

pytestmark = pytest.mark.slow

Ended = tuple[int, str, str]
Run = Callable[..., Ended]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Return a function that runs a command in a folder with measurements of a model's own poses."""
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(0)
    lam = rng.uniform(0.0, 120.0, (16, 2))
    pose = ecm.FiniteElementModel(ecm.Mechanism()).solve_batch(lam).pose + rng.normal(0.0, 1e-4, (16, 3))
    rows = [",".join(map(repr, [*loads, *place])) for loads, place in zip(lam.tolist(), pose.tolist(), strict=True)]
    for name, sigma in (("run", "1e-4"), ("tiny", "1e-12"), ("least", "1e-300"), ("huge", "1e200")):
        head = "lam_l_N,lam_r_N,x_m,z_m,theta_rad,sigma_x_m,sigma_z_m,sigma_theta_rad"
        Path(f"{name}.csv").write_text("\n".join([head, *(f"{row},{sigma},{sigma},{sigma}" for row in rows)]))
    Path("far.csv").write_text("lam_l_N,x_mm\n1,107\n2,1e300\n")

    def _run(*words: str) -> Ended:
        return main([str(word) for word in words]), *capsys.readouterr()

    return _run


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("predict far.csv", "far.csv: line 3, column x_mm: '1e300' (allowed is a size of at most 1e+06 mm)"),
        ("predict huge.csv", "48 bad cells: line 2, column sigma_x_m: '1e200'"),
        ("predict run.csv --noise lam_N 1e300", "noise of lam_N = 1e+300: allowed is a number > 0, at most 1e+06 N"),
        ("identify run.csv --fit EI --prior EI 3 1e-300", "standard deviation 1e-300 of the prior for EI: allowed is"),
        ("diagnose run.csv --prior EI 3 1e-300", "standard deviation 1e-300 of the prior for beam.EI: allowed is"),
        ("diagnose run.csv --uncertain head.mass=1e-300", "standard deviation 1e-300 of the prior for head.mass: all"),
        (
            "identify run.csv --fit EI --force-sigma 1e8",
            "force_sigma = 100000000.0: allowed is a finite number",
        ),
        ("diagnose run.csv --force-sigma 1e300", "allowed is a"),
        ("view --port 99999 --no-browser", "--port 99999: allowed is a whole number up to 65535"),
    ],
)
def test_numbers_that_cannot_be_meant_are_refused(run: Run, words: str, message: str) -> None:
    """Interface: exit code 2 and one line that names the value and what is allowed."""
    code, out, err = run(*words.split())
    assert (code, out) == (2, ""), err
    assert message in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    "words",
    ["run.csv --force-sigma 1e6", "tiny.csv", "tiny.csv --force-sigma 1", "least.csv", "run.csv --prior EI 3 1e-9"],
)
def test_weights_of_any_size_give_a_fit(run: Run, words: str) -> None:
    """The poses are those of EI = 3 with 0.1 mm of noise; whatever is declared, the fit must not end in a matrix."""
    code, out, err = run("identify", *words.split(), "--fit", "EI", "--json")
    assert code in (0, 3), err
    found = json.loads(out)["parameters"]["EI"]
    assert (found["std"] is None) == ("1e6" in words)  # under a noise of 1e6 N nothing is seen
    if "--force-sigma" not in words:
        assert found["value"] == pytest.approx(3.0, rel=0.05)


@pytest.mark.parametrize("force", [1e-3, 1.0, 1e4, 1e8])
def test_whitened_covariances_are_the_identity_at_any_scale(force: float) -> None:
    """By definition W C W^T = I, with C written out here; where forces drown the camera nothing counts too much."""
    rng = np.random.default_rng(1)
    by_force = rng.normal(size=(50, 3, 2)) * [[1e-5], [1e-4], [1e-3]]
    sigma = np.full((50, 3), [1e-4, 1e-4, 1e-3])
    zeros = np.zeros((50, 3))
    state = State(np.zeros(0), zeros, np.zeros((50, 3, 0)), by_force, np.zeros(50, dtype=np.int64))
    noise = ReadingNoise(sigma, np.full(50, force), np.full((50, 3), "declared"))
    w = noise.whitening(sigma, state, np.ones((50, 3), dtype=bool))
    assert np.isfinite(w).all()
    seen = np.concatenate([w @ by_force * force, w * sigma[:, None, :]], axis=2)
    size = (seen @ seen.transpose(0, 2, 1))[:, range(3), range(3)]
    assert size.max() <= 1.001
    if force <= 1e4:
        assert size == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [("NUMBA_DISABLE_JIT", "1", "compiled alone"), ("NUMBA_NUM_THREADS", "0", "1 or more")],
)
def test_settings_of_the_compiler_that_cannot_be(
    run: Run, monkeypatch: pytest.MonkeyPatch, name: str, value: str, message: str
) -> None:
    """Numba's manual: one turns compilation off, the other is a number of threads."""
    monkeypatch.setenv(name, value)
    code, _, err = run("solve", "--tendons", "1", "2")
    assert code == 2
    assert err.startswith(f"ecm-fast: {name}={value} in the environment: ")
    assert message in err


@pytest.mark.parametrize("value", [(1.0, 2.0), "9", None, [1.0], True])
def test_an_argument_that_is_no_number_is_named(value: Any) -> None:
    """Interface: what cannot be meant is an InputError with the argument's name."""
    model = ecm.FiniteElementModel(ecm.Mechanism())
    for call in (
        lambda: model.stepper(lam_max=value),
        lambda: model.inverse(theta=0.1, co_contraction=40.0, lam_max=value),
        lambda: model.solve_batch([[1.0, 2.0]], tolerance=value),
    ):
        with pytest.raises(InputError, match=r"^(lam_max|tolerance) = .*: allowed is a number$"):
            call()


# damaged results in `next`


RESULT = {
    "inputs": {"mechanism": None, "data": ["run.csv"], "priors": {"EA": [7500.0, 75.0]}, "noise": {"lam_N": 0.1}},
    "models": [
        {"names": ["precurvature"], "in_set": True, "refused": "", "behind": 0.0},
        {"names": ["clamp_tilt"], "in_set": True, "refused": "", "behind": 1.0},
    ],
    "noise": {"sigma": [1e-4, 1e-4, 1e-3], "force": 0.1},
    "transfer": [{"rivals": [{"name": "clamp_tilt", "carries_over": True}]}],
}


def damaged(whole: Any) -> Iterator[Any]:
    """Yield copies with one part taken out or replaced by something else."""
    if isinstance(whole, (dict, list)):
        for key in whole if isinstance(whole, dict) else range(len(whole)):
            rest = deepcopy(whole)
            del rest[key]
            yield rest
            for part in damaged(whole[key]):
                other = deepcopy(whole)
                other[key] = part
                yield other
    yield from (None, True, -1, 1e400, float("nan"), 10**400, "x", "\udcff", [], [None], {}, {"names": 3})


def test_next_says_what_is_wrong_with_a_damaged_result(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each part in turn lost or replaced; the fit of rivals is left out, since it reads nothing of the file itself."""
    monkeypatch.setattr("ecm_fast.studies.diagnosis.Study.next_loads", lambda *_, **__: None)
    Path("result.json").write_text(json.dumps(RESULT))
    assert run("next", "result.json")[0] == 0
    cases = list(damaged(RESULT))
    for case in cases:
        Path("result.json").write_text(json.dumps(case))
        code, _, err = run("next", "result.json")
        assert code in (0, 2), (case, err)
        assert err.count("\n") == (code == 2)
    assert len(cases) > 300


# interrupts

LOST = """
import atexit, signal, sys, time

class Lost:  # an exception in its __del__ has nowhere to go
    def __del__(self):
        signal.raise_signal(signal.SIGINT)

class Swallowed:
    def __init__(self):
        try:
            signal.raise_signal(signal.SIGINT)
        except BaseException:
            pass

class Finder:
    @staticmethod
    def find_spec(name, *_):
        if name == "{module}":
            {where}()

sys.meta_path.insert(0, Finder)
if "{module}" == "the end":
    atexit.register({where})
sys.argv = ["ecm-fast", "solve", "--tendons", "1", "2"]
from ecm_fast.__main__ import main
if "{module}" == "the command":
    from ecm_fast import cli
    cli.COMMANDS["solve"].__dict__["run"] = lambda args: [{where}() and None, time.sleep(9)]
sys.exit(main())
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("where", ["Lost", "Swallowed"])
@pytest.mark.parametrize("module", ["ecm_fast.cli.sweep", "the command", "numpy", "numba.core", "the end"])
def test_an_interrupt_is_never_lost(tmp_path: Path, module: str, where: str) -> None:
    """POSIX: an interrupted command ends with 130, though Python drops an exception of `__del__` and prints it."""
    code = LOST.format(module=module, where=where)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, timeout=60)
    assert (done.returncode, done.stderr) == (130, "ecm-fast: interrupted\n")
    assert (done.stdout == "") == (module != "the end")


def test_little_is_loaded_before_interrupts_are_seen_to() -> None:
    """Python's own list of loaded modules, without those that the installation itself loads."""
    code = "import ecm_fast.__main__, sys; print(*{'re', 'threading', 'typing'} & set(sys.modules))"
    env = {**os.environ, "PYTHONPATH": str(Path(ecm.__path__[0]).parent)}
    done = subprocess.run([sys.executable, "-S", "-c", code], capture_output=True, text=True, check=True, env=env)
    assert done.stdout == "\n"


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("delay", [0.05, 0.1, 0.2, 0.4, 0.7])
def test_an_interrupt_while_importing_is_one_line(tmp_path: Path, delay: float) -> None:
    """POSIX: an interrupted command ends with 130, and as an ended one where its answer was out already.

    How far it has come by then differs from run to run.
    """
    code = (
        "import sys, time; from ecm_fast.__main__ import main; print(flush=True); "
        "sys.argv = ['ecm-fast', 'solve', '--tendons', '1', '2', '--json']; sys.exit(main())"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=-1, stderr=-1, text=True, cwd=tmp_path) as process:
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(delay)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    if out:
        assert json.loads(out)["converged"] is True
        assert process.returncode in (0, 130, -signal.SIGINT)
        assert err in ("", "ecm-fast: interrupted\n")
    else:
        assert (process.returncode, err) == (130, "ecm-fast: interrupted\n")
