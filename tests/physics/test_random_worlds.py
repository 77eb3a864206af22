"""Random mechanisms and loads: every way of solving against meshes of twice as many elements."""

import numpy as np
import pytest

from bench.robustness.random_worlds import compare, world
from ecm_fast import FiniteElementModel, Mechanism, Status
from ecm_fast.kernels.prepare import is_top_heavy, prepare
from ecm_fast.mechanism.mesh.discretization import Discretization
from ecm_fast.mechanism.vector import pack
from ecm_fast.models.refinement import work_arrays

COUNT = 60
MESH = Discretization.from_elements(1, 5)


@pytest.fixture(scope="module")
def tally():
    """Return the comparison of a few worlds; `bench/robustness/random_worlds.py` takes as many as one likes."""
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


@pytest.mark.parametrize("number", [2950, 5010, 7738])
def test_stiffness_that_jumps_or_bends_is_in_the_estimate(number):
    """Convergence: a bimodulus and two soft spots, whose one element halving hardly changes, were off by 1e-6 to 1e-5.

    Elements that end where the stiffness jumps say so.
    """
    tally = compare(101, [number])
    assert tally.solved == 1
    assert not [*tally.silent, *tally.batch, *tally.step]
    assert tally.coarse_off[0] < tally.coarse_estimates[0]


@pytest.mark.parametrize("number", [349, 593, 1007, 1053])
def test_a_tendon_at_its_pulley_ends_the_branch_on_either_side(number):
    """Symmetry: the mirrored mechanism under the mirrored loads; within its pulley the left tendon has no length."""
    each = world(101, number)
    mirrored = each.mechanism.replace(**{"head.b": -each.mechanism.head.b})
    for elements in (2, 4, 16):
        left = FiniteElementModel(each.mechanism, elements, 6).solve(each.lam, each.wrench)
        right = FiniteElementModel(mirrored, elements, 6).solve(each.lam[::-1], each.wrench * [1.0, -1.0, -1.0])
        assert left.status is right.status is Status.TENDON_ZERO_LENGTH


@pytest.mark.parametrize("number", [956, 1320, 1669])
def test_a_fold_of_the_neck_is_no_fault_of_its_section(number):
    """Closed form: shear gives way where N > GA gamma_x; here GA is 17 to 1000 times EA, and no N is as large.

    Where N passes zero on a strongly bent neck, the shear force turns a section more than N holds it: bending does.
    """
    each = world(101, number)
    assert each.mechanism.beam.GA > 15.0 * each.mechanism.beam.EA
    for elements in (2, 8, 16):
        eq = FiniteElementModel(each.mechanism, elements, 6).solve(each.lam, each.wrench)
        assert eq.status is Status.NOT_CONVERGED


@pytest.mark.parametrize("number", [3787, 5563])
def test_no_equilibrium_beyond_a_snap_is_called_the_necks(number):
    """Growing loads: a neck that fell over under its own weight is pulled up, and jumps to the other side on the way.

    Where the branch ends at part of the load, nothing at the full load lies on it, on any mesh; straight at the full
    load the neck is stable, so Newton's method walks from there into an equilibrium beyond the jump.
    """
    each = world(79, number)
    for elements, order in [(1, 5), (1, 6), (2, 5), (8, 6)]:
        model = FiniteElementModel(each.mechanism, elements, order)
        for share in (0.5, 0.6, 0.8, 1.0):
            assert model.solve(share * each.lam, share * each.wrench).status is Status.NOT_CONVERGED


def test_a_section_that_softens_is_not_held_by_its_mesh():
    """Legendre's condition: where M falls with kappa no equilibrium is stable; one long element hid that."""
    each = world(81, 780)
    assert FiniteElementModel(each.mechanism).solve(each.lam, each.wrench).status is Status.SECTION_UNSTABLE


@pytest.mark.parametrize(("weights", "carried"), [("head", np.pi**2 / 4.0), ("beam", 7.837)])
def test_a_top_heavy_neck_starts_at_its_own_weight(weights, carried):
    """Closed form: a column carries pi^2/4 EI/L^2 on top (Euler), or 7.837 EI/L^2 of its own weight (Greenhill)."""
    neck = Mechanism().replace(**{"head.h": 0.0, "beam.EA": 1e9, "beam.GA": 1e9, "gravity.g": 10.0})
    unit, length = neck.beam.EI / neck.beam.length**2 / 10.0, neck.beam.length
    for share, heavy in [(0.0, False), (0.75, False), (1.0, True)]:
        mass = share * carried * unit
        head, beam = (mass, 0.0) if weights == "head" else (0.0, mass / length)
        system = work_arrays(MESH)[:3]
        prepare(pack(neck.replace(**{"head.mass": head, "beam.mass_per_length": beam})), MESH.mesh, MESH.nodes, *system)
        assert is_top_heavy(system[0], system[1], system[2][2]) == heavy


def test_an_estimate_near_a_critical_load():
    """Truth: 16 elements. A soft column whose own weight nearly tips it: one step on finer elements tells a seventh."""
    each = world(90, 28129)
    loads = tuple(each.lam.tolist()), tuple(each.wrench.tolist())
    length = each.mechanism.beam.length
    fine, coarse = (FiniteElementModel(each.mechanism, n, 6).solve(*loads) for n in (16, 1))
    off = np.abs((coarse.pose - fine.pose) / [length, length, 1.0]).max()
    assert off < coarse.error < 30.0 * off
