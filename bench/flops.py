"""Operation counts of a kernel, and the peak rate of the processor.

The operations of a lane are counted in the machine code of a kernel: packed additions, multiplications, divisions and
square roots count one, fused ones two; comparisons, maxima, blends and moves count nothing. Every packed instruction
stands in a loop over the lanes, which runs once per vector.
"""

import re
import warnings
from collections.abc import Callable
from typing import Any

import numba
import numpy as np

from ecm_fast.kernels._jit import wide
from ecm_fast.kernels.condensed.step import gauss_points, sweep

CHAINS, STEPS, LANES = 12, 64, 1024
"""Sums of products that do not wait for one another, how long each is, and how many lanes take them."""
_OPERATION = re.compile(r"^\s+v(add|sub|mul|div|sqrt|f[n]?m(?:add|sub)\d+)pd\s.*%([xyz])mm", re.MULTILINE)


def flops_of_sweep() -> int:
    """Return how many floating-point operations `sweep` of order 4 does in one lane."""
    options = {name: sweep.targetoptions[name] for name in ("error_model", "fastmath")}
    signature = numba.types.void(numba.typeof(gauss_points(4)), numba.float64[::1], numba.float64[::1])
    fresh: Any = numba.njit(**options)(sweep.py_func)  # what comes from the cache has no machine code to read
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fresh.compile(signature.args)
        text = fresh.inspect_asm(fresh.signatures[0])
    return sum(2 if operation.startswith("f") else 1 for operation, _ in _OPERATION.findall(text))


def probe() -> tuple[Callable[[], object], int]:
    """Return a call that does nothing but multiply and add in registers, and how many operations it does."""
    names = [f"a{i}" for i in range(CHAINS)]
    lines = ["def multiply_add(x):", "    wide()", f"    for j in range({LANES}):", "        s = x[j]"]
    lines += [f"        {name} = s + {i}.0" for i, name in enumerate(names)]
    lines += [f"        {name} = {name} * s + 0.5" for _ in range(STEPS) for name in names]
    lines += [f"        x[{LANES} + j] = {' + '.join(names)}"]
    scope: dict[str, Any] = {"wide": wide}
    exec("\n".join(lines), scope)
    kernel, x = numba.njit(error_model="numpy", fastmath={"contract"})(scope["multiply_add"]), np.full(2 * LANES, 0.5)
    return lambda: kernel(x), LANES * (2 * CHAINS * STEPS + 2 * CHAINS - 1)
