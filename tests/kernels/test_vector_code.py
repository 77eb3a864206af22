"""Vectorization: vector arithmetic without calls, and the same digits on a plainer machine.

Kernels that come from the cache show no assembly, so each look is a process of its own without a cache.
"""

import json
import os
import platform
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
X86 = platform.machine().lower() in ("x86_64", "amd64")
ORDERS = (3, 4, 5, 6)
only_x86 = pytest.mark.skipif(not X86, reason="reads the instructions of x86-64; this is another processor")
only_compiled = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="looks at compiled kernels")
CALL = re.compile(r"\b(?:sin|cos|sincos)\b|_(?:svml|ZGV)\w*(?:sin|cos)")

LOOK = """
import json, sys
import llvmlite.binding as llvm
import numpy as np
from ecm_fast.kernels import layout as l
from ecm_fast.kernels.chain import section
from ecm_fast.kernels.condensed.formulation import constants_size, state_size
from ecm_fast.kernels.condensed.step import gauss_points, sweep

name, order = sys.argv[1], int(sys.argv[2])
if name == "sweep":
    con, state = np.ones(constants_size(order)), np.zeros(l.LANES * state_size(order))
    kernel, arguments = sweep, (gauss_points(order), con, state)
else:
    kernel = getattr(section, name)
    arguments = np.zeros(64), np.zeros(l.N_BEAM), np.zeros(l.N_ENDS + l.N_SAMPLES), 8, np.zeros(l.N_HEAD)
kernel(*arguments)
found = [llvm.get_host_cpu_features().flatten(), kernel.inspect_asm(kernel.signatures[0])]
json.dump(found, sys.stdout)
"""

ANSWERS = """
import json, sys
import numpy as np
from ecm_fast import FiniteElementModel, Mechanism

rng = np.random.default_rng(1)
lam, wrench = rng.uniform(0.0, 160.0, (64, 2)), rng.normal(size=(64, 3)) * [10.0, 5.0, 0.5]
neck = Mechanism().replace(pulley_z=0.0645, **{"tendons.pulley_radius": 0.0055})
answers = {}
for name, how in (("fast", {"order": 3}), ("chain", {"elements": 20, "order": 1})):
    batch = FiniteElementModel(neck, **how).solve_batch(lam, wrench, tolerance=1e-13)
    answers[name] = [batch.pose.tolist(), batch.status.tolist()]
"""


def output_of(program: str, cache: Path, *arguments: str, **settings: str) -> Any:
    """Return the JSON that a process prints which compiles anew, into a folder of its own."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(ROOT)} | settings
    command = [sys.executable, "-c", program, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=280)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@only_compiled
@only_x86
@pytest.mark.parametrize(
    ("name", "order"), [*(("sweep", order) for order in ORDERS), ("linear_elements", 1), ("samples", 1)]
)
def test_loops_are_vector_arithmetic_without_calls(tmp_path, name, order):
    """LLVM's assembly: the divisions of a sweep are counted by hand, so a loop that stayed scalar leaves too few."""
    features, text = output_of(LOOK, tmp_path, name, str(order))
    packed = {stem: re.findall(rf"\bv?{stem}\b.*%[xyz]mm", text) for stem in ("divpd", "mulpd", "sqrtpd")}
    assert len(packed["mulpd"]) > 20
    assert CALL.findall(text) == []
    if name == "sweep":
        assert len(packed["divpd"]) >= 3 + (order + 1) // 2  # both tendons, the tip, and a pivot for two angles
        assert len(packed["sqrtpd"]) >= 2
    if {"+avx2", "+fma"} <= set(features.split(",")):
        fused = re.findall(r"\bvfn?m(?:add|sub)\d+pd\b", text)
        assert len(fused) > 30
        # what is left scalar is the twin of each loop, for arrays that overlap
        assert len(fused) >= len(re.findall(r"\bvfn?m(?:add|sub)\d+sd\b", text))


@only_compiled
@only_x86
def test_the_search_for_calls_finds_them():
    """Check of the check: a kernel with sin and cos does contain calls."""

    def calls(t):
        return np.sin(t) + np.cos(t)

    compiled = numba.njit(calls)
    compiled(1.0)
    assert CALL.findall(compiled.inspect_asm(compiled.signatures[0]))


@only_compiled
@only_x86
def test_a_plainer_processor_gives_the_same_digits(tmp_path):
    """Without fused multiply-adds and wide vectors: 64 cases of the fast path and of a chain, to rounding."""
    here: dict = {}
    exec(ANSWERS, here)
    own = here["answers"]
    program = ANSWERS + "json.dump(answers, sys.stdout)"
    plain = output_of(program, tmp_path, NUMBA_CPU_NAME="generic", NUMBA_CPU_FEATURES="")
    for name in own:
        assert plain[name][1] == own[name][1] == [0] * 64
        np.testing.assert_allclose(plain[name][0], own[name][0], rtol=0, atol=1e-12)
        assert plain[name][0] != own[name][0]  # it was another machine code
