"""Random mechanisms and loads: every way of solving against meshes of twice as many elements."""

import pytest

from bench.random_worlds import compare

COUNT = 60


@pytest.fixture(scope="module")
def tally():
    """Return the comparison of a few worlds; `bench/random_worlds.py` takes as many as one likes."""
    return compare(7, range(COUNT))


def test_no_silent_disagreement_with_a_finer_mesh(tally):
    """Convergence: where `solve` promises 1e-6, twice as many elements say the same pose and the same verdict."""
    assert tally.solved > COUNT // 2
    assert not tally.silent
    assert not tally.verdicts


def test_batches_and_control_steps_agree_with_solve(tally):
    """Consistency: a batch refines as `solve` does; a control step tells by its `error` where it cannot follow."""
    assert not tally.batch
    assert not tally.step


def test_estimates_bound_the_error(tally):
    """Convergence: one element of order 5 against the fine mesh. In thousands of worlds it is 99 % and 90 %."""
    covered, tight = tally.quality(coarse=True)
    assert covered > 0.95
    assert tight > 0.9
