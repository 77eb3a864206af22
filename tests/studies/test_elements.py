"""The study of elements: a published-style table found by another program, another method as truth, fixed numbers."""

import html
import json
import math
from pathlib import Path

import numpy as np
import pytest

import ecm_fast as ecm
from ecm_fast import Candidate, InputError, LoadSet, Mechanism, NotConverged
from ecm_fast.__main__ import main
from ecm_fast.data.measurements import Measurements
from ecm_fast.studies.elements.answer import answer
from ecm_fast.studies.elements.candidates import candidates, ending_at_jumps, graded, stiffness_jumps
from ecm_fast.studies.elements.errors import Converged, converged, errors, short
from ecm_fast.studies.elements.study import ElementStudy, Measured, choose_discretization, needed, pareto, recommended
from ecm_fast.testbed import equilibria

pytestmark = pytest.mark.slow

# the table: largest |tip error| / L over 60 pairs of tendon forces, by a program that shares no line with this one
TABLE_NECK = Mechanism().replace(length=0.15, EI=3.0, GA=2420.0, EA=7500.0, pulley_x=-0.02, pulley_z=0.06)
LINEAR = {1: 3.9e-2, 2: 1.1e-2, 5: 1.9e-3, 10: 4.8e-4, 20: 1.2e-4, 40: 3.0e-5, 80: 7.6e-6, 160: 1.9e-6, 320: 4.7e-7}
LOCKING = {10: 5.4e-3, 40: 3.5e-4, 160: 2.2e-5, 320: 5.4e-6}
QUADRATIC = {1: 1.3e-3, 2: 9.3e-5, 3: 1.9e-5, 4: 6.0e-6, 6: 1.2e-6, 10: 1.5e-7}
ARCS = {1: 1.0e-2, 2: 3.2e-3, 4: 8.5e-4, 8: 2.2e-4, 12: 9.6e-5}
ONE = {3: 2.2e-5, 4: 2.1e-7, 5: 3.3e-9, 6: 8e-11}

SOFT = {"soft_spot.size": 0.2}
HIGH = (("lagrange", 3), ("lagrange", 4), ("strain", 3))
FEW = [Candidate.even(n, p) for n, p in ((20, 1), (1, 3), (1, 4), (1, 5))]


@pytest.fixture(scope="module")
def table():
    """Study the table's problem once."""
    lam = np.random.default_rng(0).uniform(0.0, 160.0, (60, 2))
    arcs = [Candidate.even(n, 1, family="se2") for n in ARCS]
    study = ecm.study_elements(TABLE_NECK, lam, compared=[*candidates(TABLE_NECK), *arcs])
    assert study.known.error < 1e-12
    return study


def positions(study, order, gauss, family="lagrange"):
    kind = Candidate.even(1, order, gauss, family).kind
    rows = [row for row in study.rows if (row.candidate.kind, row.candidate.mesh) == (kind, "even")]
    return {row.candidate.elements: row.position for row in rows}


@pytest.mark.parametrize(
    ("kind", "known", "factor"),
    [((1, 1), LINEAR, 1.2), ((1, 2), LOCKING, 1.2), ((2, 2), QUADRATIC, 1.3)],
    ids=["linear", "linear, 2 points", "quadratic"],
)
def test_the_known_table(table, kind, known, factor):
    """The published table; it does not say which 60 pairs were drawn and what the head weighed.

    Three draws differ by 8 %, and a head of 1 kg leaves 1.25 times the error of none: hence a factor of 1.2, and 1.3
    where errors go with a higher power of what bends the neck.
    """
    found = positions(table, *kind)
    for elements, error in known.items():
        assert error / factor < found[elements] < error * factor


def test_one_element_of_high_order(table):
    """The same table; three draws differ by 1.3 at order 5, and the head's mass adds to that: hence a factor of 3."""
    for order, error in ONE.items():
        factor = 1.5 if order < 5 else 3.0
        assert error / factor < positions(table, order, order)[1] < error * factor


def test_how_many_elements_it_takes(table):
    """The same table: 7, 22, 220 linear elements for 1e-3, 1e-4, 1e-6; with two points 24, 75, 750; 320 were tried."""
    linear, locking = (list(positions(table, 1, gauss).items()) for gauss in (1, 2))
    for tolerance, count in ((1e-3, 7), (1e-4, 22), (1e-6, 220)):
        assert needed(linear, tolerance) == pytest.approx(count, rel=0.05, abs=1)
    for tolerance, count in ((1e-3, 24), (1e-4, 75)):
        assert needed(locking, tolerance) == pytest.approx(count, rel=0.05, abs=1)
    assert needed(locking, 1e-6) is None


def test_orders_of_convergence(table):
    """Theory: with p Gauss points the tip converges like h^(2p), with p + 1 of them the linear element like h^2."""
    lagrange = [((1, 1), 320, 2), ((1, 2), 320, 2), ((2, 2), 10, 4), ((3, 3), 4, 6)]
    others = [((1, 1, "se2"), 160, 2), ((2, 3, "strain"), 10, 4), ((3, 4, "strain"), 4, 6)]
    for kind, many, expected in [*lagrange, *others]:
        found = positions(table, *kind)
        fewer = {320: 160, 160: 80, 10: 6, 4: 3}[many]
        assert math.log(found[fewer] / found[many]) / math.log(many / fewer) == pytest.approx(expected, abs=0.2)


def test_arcs_have_a_better_constant_than_straight_elements(table):
    """The same table: second order too, and 3.5 times better.

    How its arcs were integrated is not known. Ours are to rounding and leave less, but not less than half.
    """
    linear, arcs = positions(table, 1, 1), positions(table, 1, 1, "se2")
    for elements in (10, 40, 160):
        assert 3.5 < linear[elements] / arcs[elements] < 2.0 * 3.5
    for elements, error in ARCS.items():
        assert error / 2.0 < arcs[elements] < error


def test_locking_gets_worse_with_slenderness():
    """Shear locking: full integration adds GA h^2/12 to EI, the more the longer the element; one point adds nothing."""
    share = {}
    for length in (0.109, 0.218):
        neck = Mechanism().replace(length=length, g=0.0)
        known = converged(neck, LoadSet.from_loads([[0.0, 0.0, 0.0, 1.0, 0.0]]))
        for gauss in (1, 2):
            off = Candidate.even(4, 1, gauss).model(neck).solve(wrench=(0.0, 1.0, 0.0)).z / known.pose[0, 1] - 1.0
            share[length, gauss] = off
            added = 2420.0 * (length / 4) ** 2 / 12.0 / 3.0
            if gauss == 2:
                assert off == pytest.approx(1.0 / (1.0 + added) - 1.0, rel=0.1)
    for length in (0.109, 0.218):
        assert abs(share[length, 1]) < 0.02 < 0.04 < -share[length, 2]
    assert share[0.218, 2] / share[0.109, 2] > 2.5


# --- the choice


@pytest.mark.parametrize(
    ("effects", "tolerance", "family"),
    [
        ({"stiffness_taper": 0.2}, 1e-7, "lagrange"),
        (SOFT, 1e-3, "lagrange"),
        (SOFT, 1e-6, "strain"),
        ({"stiffness_taper": -0.1, **SOFT}, 1e-8, None),
    ],
    ids=["taper", "spot-1e-3", "spot-1e-6", "both"],
)
def test_the_choice_keeps_its_tolerance_on_fresh_loads(effects, tolerance, family):
    """Another method: the differential equations integrated, on 1000 loads that no choice has seen."""
    neck = Mechanism().replace(**effects)
    choice = choose_discretization(neck, "tendons", tolerance, family=family)
    assert choice.measured.candidate.family == (family or "lagrange")
    assert choice.error <= tolerance
    assert choice.fresh_error <= tolerance
    lam = np.random.default_rng(77).uniform(0.0, 160.0, (1000, 2))
    truth = equilibria(neck, Measurements.from_columns({"lam_l_N": lam[:, 0], "lam_r_N": lam[:, 1]})).raise_if_failed()
    off = np.abs(choice.model.solve_batch(lam).pose - truth.pose) / [neck.beam.length, neck.beam.length, 1.0]
    assert off.max() <= tolerance
    assert all(row.error <= tolerance and row.time >= choice.measured.time for row in choice.runner_ups)
    assert repr(choice).startswith(f"Choice({choice.measured.candidate.name}: ")


def test_one_element_does_not_suffice_where_the_stiffness_jumps():
    """Theory: a jump inside an element spoils its order; elements that end there have it back, h^(2p)."""
    neck = Mechanism().replace(**SOFT)
    aligned = [candidate for candidate in candidates(neck) if candidate.mesh == "ending at jumps"]
    even = [Candidate.even(n, p, None, family) for n in (1, 3, 10) for family, p in HIGH]
    rows = ecm.study_elements(neck, compared=[*even, *aligned]).rows
    error = {(row.candidate.kind, row.candidate.elements, row.candidate.mesh): row.error for row in rows}
    for family, order in HIGH:
        kind = Candidate.even(1, order, None, family).kind
        spanned = [error[kind, n, "even"] for n in (1, 3, 10)]
        assert error[kind, 3, "ending at jumps"] < 0.2 * min(spanned)
    smooth = ecm.study_elements(Mechanism(), compared=[Candidate.even(1, 4)]).rows[0]
    assert smooth.error < 1e-2 * error["quartic", 1, "even"]
    # arcs have theirs, the second
    arcs = {n: found for (kind, n, mesh), found in error.items() if (kind, mesh) == ("SE(2)", "ending at jumps")}
    fewer, more = sorted(arcs)[-2:]
    assert math.log(arcs[fewer] / arcs[more]) / math.log(more / fewer) == pytest.approx(2.0, abs=0.2)


def test_no_candidate_keeps_the_tolerance():
    """Contract: the text of the error, with the best candidate."""
    with pytest.raises(InputError) as caught:
        choose_discretization(tolerance=1e-8, compared=FEW[:2])
    assert str(caught.value).startswith(
        "tolerance = 1e-08: no candidate keeps it; the best, one cubic element, leaves "
    )
    assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match=r"^family = 'se3': allowed is one of 'lagrange', 'se2', 'strain'"):
        choose_discretization(family="se3")
    with pytest.raises(NotConverged, match=r"too coarse for tolerance = 1e-15$"):
        choose_discretization(tolerance=1e-15, compared=FEW)


def test_given_loads_are_halved():
    """Contract: the choice is made on half of the given loads, checked on the rest."""
    lam = np.random.default_rng(2).uniform(0.0, 50.0, (41, 2))
    choice = choose_discretization(loads=lam, tolerance=1e-4, compared=FEW)
    assert choice.measured.candidate.order in (3, 4, 5)
    worst = np.array(choice.measured.worst)
    assert (np.abs(lam - worst[:2]).max(axis=1) == 0.0).any()
    assert worst[2:].tolist() == [0.0, 0.0, 0.0]
    with pytest.raises(InputError, match=r"^loads: 1 cases: allowed are 2 or more"):
        choose_discretization(loads=lam[:1], tolerance=1e-4)


# --- the logic, on fixed numbers


def measured(name, time, error):
    candidate = Candidate.even(1, {"a": 1, "b": 2, "c": 3, "d": 4, "e": 5}[name])
    return Measured(candidate, 3, error, error, error, (0.0,) * 5, 0, time)


ROWS = [measured("a", 4e-7, 1e-2), measured("b", 2e-7, 3e-3), measured("c", 6e-7, 2e-7), measured("d", 9e-7, 5e-7),
        measured("e", 1e-7, math.inf)]  # fmt: skip


def test_the_fastest_that_keeps_the_tolerance_is_recommended():
    """By hand: four rows of a study."""
    assert recommended(ROWS, 1e-2) is ROWS[1]
    assert recommended(ROWS, 3e-3) is ROWS[1]
    assert recommended(ROWS, 1e-6) is ROWS[2]
    assert recommended(ROWS, 1e-7) is None
    assert ROWS[2].sentence == "one cubic element: 2e-7, 0.6 us"
    assert measured("c", 2.14e-4, 2e-7).sentence == "one cubic element: 2e-7, 210 us"
    known = Converged(LoadSet.from_loads([[0.0, 0.0]]), np.zeros((1, 3)), 1e-9, 8, 0)
    study = ElementStudy(Mechanism(), tuple(ROWS), known, 1e-6)
    assert study.sentence == "one cubic element: 2e-7, 0.6 us"
    assert repr(study) == "ElementStudy(5 candidates; for 1e-06: one cubic element: 2e-7, 0.6 us)"


def test_the_front_is_what_none_beats():
    """By hand: the Pareto front of four rows."""
    assert pareto(ROWS) == (ROWS[1], ROWS[2])
    assert pareto(ROWS, 1e-2) == (ROWS[1],)  # nothing is told apart below the resolution
    assert pareto([]) == ()


def test_how_many_are_needed_between_those_known():
    """A power law by hand: 1/n^2 from 10 to 20 elements passes half-way in logarithms at 10 sqrt(2)."""
    known = [(20, 1e-4), (10, 4e-4), (1, math.inf)]
    assert needed(known, 4e-4) == 10
    assert needed(known, 2e-4) == 15
    assert needed(known, 1.01e-4) == 20
    assert needed(known, 9e-5) is None
    assert needed([(1, 1e-9)], 1e-3) == 1


def test_names_and_numbers_in_words():
    """By hand: the texts."""
    assert Candidate.even(1, 4).name == "one quartic element"
    assert Candidate.even(20, 1, 2).name == "20 linear elements, 2 Gauss points"
    assert Candidate((1.0, 2.0), 3, 3, "graded to the clamp").name == "two cubic elements graded to the clamp"
    assert Candidate.even(8, 1, family="se2").name == "8 SE(2) elements"
    assert Candidate.even(2, 3, family="strain").name == "two quadratic-strain elements"
    assert Candidate.even(1, 1, 3, "strain").name == "one constant-strain element, 3 Gauss points"
    assert [short(error) for error in (2.1e-7, 0.36, math.inf)] == ["2e-7", "4e-1", "inf"]


def test_the_answer_in_words():
    """Fixed numbers: ratios and powers by hand, and no sentence about what was not compared."""
    assert answer(study_of({})) == ()
    words = answer(study_of({(20, 1): 4e-4, (40, 1): 1e-4, (1, 3): 2e-5, (1, 4): 1e-7}))
    assert words == (
        "To keep errors of the tip below 1e-3, 1e-4 and 1e-6 it takes 20, 40 and more than 40 linear; 1, 1 and more "
        "than 1 cubic; 1, 1 and 1 quartic elements of equal length.",
        "The number can be reduced to one: one cubic element (9 unknowns, 1 us) is more exact than 20 linear elements "
        "(60 unknowns, 1 us): 2e-5 against 4e-4. Of higher order, one leaves: quartic 1e-7.",
    )
    words = answer(study_of({(20, 1): 4e-4, (40, 1): 1e-4, (1, 3): 2e-3, (20, 1, 2): 6e-3}))
    assert words[1].endswith("the best single element, cubic, leaves 2e-3, 20 linear elements leave 4e-4.")
    assert words[2].endswith("20 leave 6e-3, 15 times what they leave with one.")
    assert len(words) == 3
    arcs = {(20, 1, None, "se2"): 1e-4, (40, 1, None, "se2"): 2.5e-5, (1, 3, None, "strain"): 1e-5}
    words = answer(study_of({(20, 1): 4e-4, (40, 1): 1e-4, (1, 3): 2e-5, (10, 2): 5e-8} | arcs))
    assert "leave 0.25 times the error of as many linear ones, 1e-4 for 20;" in words[2]
    assert "the errors fall with the powers 2.00 and 2.00 of the element length" in words[2]
    assert "as many unknowns, 0.5 (quadratic-strain) times the error." in words[2]
    assert "A higher order gains more: 10 quadratic elements, with as many unknowns as 20 SE(2) elements" in words[2]


def study_of(errors_by_candidate):
    rows = []
    for args, error in errors_by_candidate.items():
        candidate = Candidate.even(*args)
        rows.append(Measured(candidate, 3 * args[0] * args[1], error, error, error, (0.0,) * 5, 0, 1e-6))
    known = Converged(LoadSet.from_loads([[0.0, 0.0]]), np.zeros((1, 3)), 1e-13, 8, 0)
    return ElementStudy(Mechanism(), tuple(rows), known, 1e-6)


# --- meshes and loads


def test_meshes():
    """By hand: where the stiffness jumps, and elements that end there."""
    neck = Mechanism().replace(**SOFT, **{"soft_spot.place": 0.5, "soft_spot.width": 0.0218})
    np.testing.assert_allclose(stiffness_jumps(neck), (0.4, 0.6), rtol=1e-14)
    np.testing.assert_allclose(ending_at_jumps(neck, 10), [0.1] * 10, rtol=1e-13)
    np.testing.assert_allclose(ending_at_jumps(neck, 1), [0.4, 0.2, 0.4], rtol=1e-13)
    assert stiffness_jumps(Mechanism()) == ()
    assert ending_at_jumps(Mechanism(), 2) == (0.5, 0.5)
    # one end beyond the tip, one before the clamp, the default's middle and width
    assert len(stiffness_jumps(neck.replace(**{"soft_spot.place": 1.0}))) == 1
    assert len(stiffness_jumps(neck.replace(**{"soft_spot.place": 0.0}))) == 1
    middle, width = np.array([[0.5, 0.5], [-1.0, 1.0]]) @ stiffness_jumps(Mechanism().replace(**SOFT))
    np.testing.assert_allclose([middle, width * 0.109], [1.0 / 3.0, 0.015], rtol=1e-14)
    np.testing.assert_allclose(graded(3, 0.0, 2.0), np.array([1, 2, 4]) / 7.0, rtol=1e-14)
    np.testing.assert_allclose(graded(3, 1.0, 2.0), np.array([4, 2, 1]) / 7.0, rtol=1e-14)
    np.testing.assert_allclose(graded(4, 0.5, 3.0), np.array([3, 1, 1, 3]) / 8.0, rtol=1e-14)
    with pytest.raises(InputError, match="allowed are 2 or more and 0 to 1"):
        graded(1, 0.0)
    for family, known in ((None, {"lagrange", "se2", "strain"}), ("se2", {"se2"})):
        found = candidates(neck, family)
        assert {candidate.mesh for candidate in found} == {"even", "graded to the soft spot", "ending at jumps"}
        assert {candidate.family for candidate in found} == known


def test_load_sets():
    """By hand: corners of the box and rows of measurements."""
    tendons, box = (LoadSet.drawn(name, 50, 1) for name in ("tendons", "box"))
    assert {tuple(row) for row in tendons.lam[:4]} == {(0.0, 0.0), (160.0, 0.0), (0.0, 160.0), (160.0, 160.0)}
    assert tendons.lam.shape == (50, 2)
    assert not tendons.wrench.any()
    assert not box.lam.any()
    assert len({tuple(row) for row in np.abs(box.wrench[:8])}) == 2  # fx 330 or 20, fz 80, tau 11
    data = Measurements.from_columns({"lam_l_N": [1.0, 2.0], "fz_N": [3.0, 4.0], "extra_mass_kg": [0.0, 1.0]})
    assert LoadSet.from_loads(data).wrench.tolist() == [[0.0, 3.0, 0.0]]
    tilted = Measurements.from_columns({"lam_l_N": [1.0], "tilt_rad": [0.1]})
    for loads, text in (
        ("boxes", "loads = 'boxes': allowed is"),
        ([[1.0] * 3], r"loads have shape \(1, 3\)"),
        ([["much", "more"]], "loads = "),
        ([[-1.0, 1.0]], "lam_l = -1.0 N in row 0: allowed is >= 0"),
        (tilted, "loads: measurements has no case without extra mass and tilt"),
    ):
        with pytest.raises(InputError, match=rf"^{text}"):
            ecm.study_elements(loads=loads)
    with pytest.raises(InputError, match=r"^tolerance = 0\.0: allowed is a positive number$"):
        ecm.study_elements(tolerance=0.0)
    with pytest.raises(InputError, match=r"^loads: none of 1 cases holds the neck in a stable pose; lower them$"):
        ecm.study_elements(loads=[[0.0, 0.0, -5000.0, 0.0, 0.0]])


def test_cases_without_an_equilibrium():
    """5 kN of compression hold no beam of these: left out where the converged solution says so, infinite where not."""
    loads = LoadSet.from_loads([[0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, -5000.0, 0.0, 0.0]])
    known = converged(Mechanism(), loads)
    assert (known.dropped, len(known.loads), known.pose.shape) == (1, 1, (1, 3))
    claimed = Converged(loads, np.zeros((2, 3)), 0.0, 8, 0)
    for found in errors(ecm.FiniteElementModel(), claimed):
        assert np.isinf(found).tolist() == [False, True]


# --- the command


def test_the_command(tmp_path: Path, capsys, monkeypatch):
    """Contract: one JSON object, files, and progress on stderr."""
    monkeypatch.chdir(tmp_path)
    Path("neck.toml").write_text("[effects.soft_spot]\nsize = 0.2\n")
    Path("loads.csv").write_text("lam_l_N,lam_r_N,fz_N\n0,120,0\n40,10,-3\n160,0,0\n80,80,1\n")
    words = ["elements", "--mechanism", "neck.toml", "--loads", "loads.csv", "--tolerance", "1e-7", "--json"]
    assert main([*words, "--out", "here"]) == 0
    out, err = capsys.readouterr()
    content = json.loads(out)
    assert "NaN" not in out
    assert all(line.startswith("ecm-fast: ") for line in err.splitlines())
    assert "] times of " in err
    assert content["cases"] == 4
    assert content["recommended"]["error"] <= 1e-7
    assert content["recommended"]["mesh"] == "ending at jumps"
    assert sum(content["recommended"]["shares"]) == pytest.approx(1.0)
    assert content["sentence"].startswith(f"{content['recommended']['name']}: ")
    assert content["recommended"]["name"] in content["front"]
    here = Path("here")
    assert json.loads((here / "elements.json").read_text()) == {k: v for k, v in content.items() if k != "report"}
    header, *rows = (here / "elements.csv").read_text().splitlines()
    assert header.startswith("name,family,order,gauss,mesh,elements,unknowns,error,median,position,")
    assert len(rows) == len(content["candidates"]) == len(candidates(Mechanism.from_toml("neck.toml")))
    page = (here / "elements.html").read_text()
    assert content["sentence"] in page
    assert all(text in html.unescape(page) for text in content["answer"])
    assert "SE(2)" in " ".join(content["answer"])
    assert page.count("<svg") == 2
    maps = (here / "element_error_maps.csv").read_text().splitlines()
    assert maps[0].startswith("lam_l_N,lam_r_N,")
    assert len(maps) == 1 + 33 * 33


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("--family", "se3"), "family = 'se3': allowed is one of 'lagrange', 'se2', 'strain'"),
        (("--tolerance", "much"), "argument --tolerance: 'much': allowed is a finite number"),
        (("--tolerance", "-1"), "tolerance = -1.0: allowed is a positive number"),
        (("--loads", "nowhere.csv"), "nowhere.csv: "),
    ],
)
def test_bad_arguments(words, text, capsys, tmp_path, monkeypatch):
    """Contract: exit code 2 and one line."""
    monkeypatch.chdir(tmp_path)
    assert main(["elements", *words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines()[-1].startswith(f"ecm-fast: {text}")
