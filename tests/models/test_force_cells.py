"""Broken force cells, made by hand in the test bed's data: what the cell would have read is known."""

from dataclasses import replace

import numpy as np
import pytest

from ecm_fast import InputError, Mechanism, diagnose, hide, identify, predict
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.models.instruments.checks.checks import faults
from ecm_fast.models.instruments.checks.force_cells import force_cell_findings
from ecm_fast.testbed import Sensors, measure, shear_test, tendon_test

NECK = Mechanism()


@pytest.fixture(scope="module", params=[0.1, 0.0], ids=["noisy", "exact"])
def sound(request):
    """Ninety random loads on a neck whose EA is 5 % off and which is a little bent: no instrument is at fault."""
    built = NECK.replace(EA=7900.0, precurvature=0.1)
    return measure(built, tendon_test(90, seed=1), Sensors(force_sigma=request.param), 1)


@pytest.fixture(scope="module")
def pulled():
    """Eighty random wrenches on a neck whose EA is 5 % off, the tendons slack: no instrument is at fault."""
    wrench = np.random.default_rng(1).uniform(-1.0, 1.0, (80, 3)) * [60.0, 30.0, 3.0]
    loads = dict(zip(("fx", "fz", "tau"), wrench.T, strict=True))
    return measure(NECK.replace(EA=7900.0), replace(shear_test(np.zeros(80)), **loads), Sensors(force_sigma=0.1), 1)


def left(data, values):
    """Return measurements with another column of the left cell."""
    return replace(data, lam_l=values)


def only(data):
    (finding,) = force_cell_findings(NECK, data)
    assert finding.certain
    return finding


def test_sound_cells_raise_no_finding(sound) -> None:
    """Known truth: no cell was touched; commanded loads of a grid repeat to the last digit."""
    assert force_cell_findings(NECK, sound) == []
    assert force_cell_findings(NECK, measure(NECK, tendon_test(grid=9, seed=1))) == []


@pytest.mark.slow
def test_a_dead_cell_is_found(sound) -> None:
    """The poses ask for forces up to those applied."""
    dead = left(sound, np.zeros(sound.n))
    finding = only(dead)
    assert finding.kind == "dead"
    assert f"{sound.lam_l.max():.2g}" in f"{float(finding.sentence.split(' to ')[1].split()[0]):.2g}"
    for command in (lambda: diagnose(NECK, dead), lambda: identify(NECK, dead, ["EA", "GA", "EI"])):
        with pytest.raises(
            InputError, match=r"lam_l_N: 0 N in all 90 rows where the poses ask for .* the cell is dead"
        ):
            command()
    assert "the cell is dead" in predict(NECK, dead).warnings[0]


def test_a_cell_that_always_shows_one_force_is_found(sound) -> None:
    """Known truth: the column was overwritten by one number."""
    assert only(left(sound, np.full(sound.n, 47.3))).kind == "stuck"


def test_a_saturated_cell_is_found_with_all_its_rows(sound) -> None:
    """Known truth: the rows that were clipped by hand, at 120 of 160 N."""
    finding = only(left(sound, np.minimum(sound.lam_l, 120.0)))
    assert finding.kind == "saturated"
    assert set(finding.rows) == set(sound.rows[sound.lam_l >= 120.0])


def test_both_cells_saturated_are_found() -> None:
    """Known truth: both columns were clipped by hand."""
    data = measure(NECK, tendon_test(grid=9, seed=1))
    clipped = replace(data, lam_l=np.minimum(data.lam_l, 120.0), lam_r=np.minimum(data.lam_r, 120.0))
    assert [finding.kind for finding in force_cell_findings(NECK, clipped)] == ["saturated", "saturated"]


def test_gaps_written_as_zeros_are_found(sound) -> None:
    """Every row whose force was far from none is named, and no other one."""
    lost = np.random.default_rng(5).random(sound.n) < 0.1
    finding = only(left(sound, np.where(lost, 0.0, sound.lam_l)))
    assert finding.kind == "dropped out"
    assert set(finding.rows) <= set(sound.rows[lost])
    assert set(finding.rows) >= set(sound.rows[lost & (sound.lam_l > 20.0)])


def test_a_cell_that_stands_still_for_a_while_is_found(sound) -> None:
    """Known truth: twelve rows were overwritten by the first one's reading."""
    values = sound.lam_l.copy()
    values[20:32] = values[20]
    finding = only(left(sound, values))
    assert finding.kind == "stuck"
    assert set(finding.rows) <= set(sound.rows[20:32])


def test_one_cell_in_kilonewtons_is_a_unit(sound) -> None:
    """Known truth: one column was divided by a thousand."""
    (finding,) = [entry for entry in faults(NECK, left(sound, 1e-3 * sound.lam_l)) if entry.certain]
    assert finding.kind == "unit"
    assert "the column holds kN; label it lam_l_kN" in finding.cure


@pytest.mark.slow
def test_slack_tendons_and_stops_are_no_broken_cells() -> None:
    """Zeros of slack tendons are true, a stop acts where the other tendon is slack, and a bent neck is no force."""
    bent = NECK.replace(precurvature=0.4)
    for loads in (shear_test(np.linspace(-60.0, 60.0, 31)), tendon_test(80, seed=1)):
        alone = measure(bent, replace(loads, lam_r=np.zeros(loads.n)), Sensors(), 1)
        assert force_cell_findings(NECK, alone) == []
    for name in ("contact_stop", "contact_stop_one_sided"):
        for noise in ("white", "force"):
            data, _ = hide(effects={name: None}, noise=noise, seed=3)
            assert force_cell_findings(NECK, data) == []


def test_sound_cells_of_the_wrench_raise_no_finding(pulled) -> None:
    """Known truth: no cell was touched; an origin that is off looks like a constant force, and is none."""
    assert force_cell_findings(NECK, pulled) == []
    for effect in ("camera_x_offset", "precurvature", "lateral_spring"):
        built = NECK.replace(**{effect: 2.0 * CATALOGUE[effect].size.typical})
        assert force_cell_findings(NECK, measure(built, shear_test(np.linspace(-60.0, 60.0, 31)), Sensors(), 3)) == []


@pytest.mark.parametrize("cell", ["fz", "tau"])
def test_broken_cells_of_the_wrench_are_found(pulled, cell) -> None:
    """Known truth: the column was overwritten by zeros, clipped on both sides, or in some rows set to zero."""
    read, lost = getattr(pulled, cell), np.random.default_rng(5).random(pulled.n) < 0.1
    limit = 0.6 * np.abs(read).max()
    assert only(replace(pulled, **{cell: np.zeros(pulled.n)})).kind == "dead"
    low, high = force_cell_findings(NECK, replace(pulled, **{cell: np.clip(read, -limit, limit)}))
    assert low.kind == high.kind == "saturated"
    assert set(low.rows) == set(pulled.rows[read <= -limit])
    assert set(high.rows) == set(pulled.rows[read >= limit])
    gaps = only(replace(pulled, **{cell: np.where(lost, 0.0, read)}))
    assert gaps.kind == "dropped out"
    assert set(gaps.rows) <= set(pulled.rows[lost])
    assert len(gaps.rows) > 0.5 * lost.sum()
