"""Memory that calls leave behind, by Numba's own count and by Python's."""

import tracemalloc
from collections.abc import Callable, Iterable

from numba.core.runtime import _nrt_python, rtsys


def assert_no_memory(step: Callable[..., object], calls: Iterable[tuple[float, ...]]) -> None:
    """Check that calls of a step ask for no memory but that of one answer."""
    _nrt_python.memsys_enable_stats()
    before = rtsys.get_allocation_stats()
    tracemalloc.start()
    try:
        first = tracemalloc.get_traced_memory()[0]
        for numbers in calls:
            step(*numbers)
        last, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
        after = rtsys.get_allocation_stats()
        _nrt_python.memsys_disable_stats()
    assert after == before
    # a tuple of three floats and the loop's own two names: less than one row of numbers a thousand
    assert last - first < 1000
    assert peak - first < 2000
