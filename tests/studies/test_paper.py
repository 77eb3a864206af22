"""The reproduction: its verdicts, the files it leaves, and a page that asks nothing of the network."""

import csv
import html
import json
import math
import re
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import ecm_fast as ecm
from ecm_fast.errors import InputError
from ecm_fast.studies import paper as package

pytest.importorskip("matplotlib")
pytest.importorskip("jinja2")

from ecm_fast.models.polynomial.training import tip_wrenches
from ecm_fast.pages.page import Section, Table, write_report
from ecm_fast.studies.paper import SECTIONS, Reproduction, reproduce
from ecm_fast.studies.paper.claims import verdict
from ecm_fast.studies.paper.fig5_polynomial import wrenches
from ecm_fast.studies.paper.fig6_comparison import comparison
from ecm_fast.studies.paper.fig7_section import times
from ecm_fast.studies.paper.outlook_conservative import coefficient_count, kinds
from ecm_fast.studies.paper.outlook_measured import inverse_errors, trained
from ecm_fast.studies.paper.outlook_pose_alone import buckling, holding, pose_alone
from ecm_fast.studies.paper.table1_fit import fitted
from ecm_fast.studies.paper.table1_stiffness import hooke_ratio

pytestmark = pytest.mark.slow

SMALL = {
    "wrenches": partial(wrenches, draws=2, n=200, tests=60),
    "kinds": partial(kinds, draws=1, n=150, tests=40),
    "trained": partial(trained, n=150, rows=60),
    "pose_alone": partial(pose_alone, n=30, pushes=31),
    "comparison": partial(comparison, n=150),
    "times": partial(times, n=5, batch=8, rounds=1),
}
SIMULATED = (
    "table1_stress",
    "table1_shear_slender",
    "table1_shear_paper",
    "trained",
    *(f"comparison_{preset}_{neck}" for preset in ("slender", "paper") for neck in ("as_the_model", "precurved")),
)
PICTURES = (
    *SIMULATED,
    "shapes",
    *(
        f"{name}_{preset}"
        for name in ("workspace", "wrenches", "pose_alone", "times")
        for preset in ("slender", "paper")
    ),
    "kinds",
    "pose_alone_buckling",
    "steel_cantilever",
    "silicone_cantilever",
)
FILES = ("report.html", "results.json", "claims.csv")


@pytest.fixture(scope="module")
def done(tmp_path_factory) -> tuple[Reproduction, Path, list[str]]:
    messages: list[str] = []
    folder = tmp_path_factory.mktemp("reproduction") / "made" / "here"
    parts = {name: (what, SMALL.get(name, redo)) for name, (what, redo) in package._PARTS.items()}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(package, "_PARTS", parts)
        return reproduce(folder, progress=messages.append), folder, messages


def verdicts(result: Reproduction, word: str) -> list[str]:
    return [claim.verdict for claim in result.claims if word in claim.what]


def test_all_files_are_there_and_progress_was_told(done) -> None:
    """Contract: the documented files, one line of progress a section."""
    result, folder, messages = done
    names = {*FILES, *(f"{name}.csv" for name in PICTURES)}
    assert {path.name for path in folder.iterdir()} == names
    assert result.report == folder / "report.html"
    assert messages == [what for what, _ in package._PARTS.values()]


def test_the_results_are_strict_json(done) -> None:
    """Contract: JSON without NaN, equal to the result."""
    result, folder, _ = done

    def refuse(name: str) -> float:
        raise AssertionError(name)

    content = json.loads((folder / "results.json").read_text(encoding="utf-8"), parse_constant=refuse)
    assert content["claims"] == result.to_json()["claims"]
    assert content["numbers"] == result.to_json()["numbers"]
    assert content["numbers"]["steel_cantilever"]["rms"]["x_m"] is None
    assert result.to_json()["report"] == str(folder / "report.html")
    for claim in result.claims:
        assert re.fullmatch("holds|differs by .+|cannot be checked(: .+)?", claim.verdict)


def test_the_workspace_is_reached_in_every_case(done) -> None:
    """Published: the paper's Fig. 4; what it does not give is said."""
    result, folder, _ = done
    numbers = result.to_json()["numbers"]["workspace"]
    assert verdicts(result, "random pairs") == ["holds"] * 2
    assert verdicts(result, "training poses cover") == verdicts(result, "box of wrenches holds") == ["holds"] * 2
    assert [claim.theirs for claim in result.claims if "extent" in claim.what] == ["not given"] * 2
    for preset, length in (("slender", 0.109), ("paper", 0.040)):
        assert numbers[preset]["stable"] == 1000
        assert 0.9 * length < numbers[preset]["x_m"][0] < numbers[preset]["x_m"][1] < length
        with (folder / f"workspace_{preset}.csv").open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        assert len(rows) == 1000
        assert min(float(row["z_m"]) for row in rows) == numbers[preset]["z_m"][0]
    # corners of the range by shooting, (160, 0) and (0, 160) N: no random case goes beyond them
    assert 0.9 * 0.0231 < numbers["slender"]["z_m"][1] < 0.0231
    assert 0.9 * 0.4361 < numbers["slender"]["theta_rad"][1] < 0.4361


def test_the_steel_strip_is_met_to_0_7_percent(done) -> None:
    """Published: measured deflections of Belendez et al. 2003."""
    numbers = done[0].to_json()["numbers"]["steel_cantilever"]
    assert verdicts(done[0], "Steel") == ["holds"]
    assert numbers["rows"] == 7
    assert 0.006 < numbers["share_of_length"] < 0.007  # the elastica without stretch and shear leaves 2.6 mm


def test_the_silicone_beams_sag_is_met_and_its_rotation_is_not(done) -> None:
    """Published: measured sags; the modulus by small-deflection theory by hand."""
    numbers = done[0].to_json()["numbers"]["silicone_cantilever"]
    # by hand: small deflections of the clamped beam, w L^4 / 8 EI + w L^2 / 2 GA, to a few per mill of the length
    weight = 1070 * 9e-4 * 9.81
    by_hand = (weight * 0.1**4 / (8 * 6.75e-8) + weight * 0.1**2 / (2 * 2.5e-4)) / 6.3e-3
    assert numbers["modulus_Pa"] == pytest.approx(by_hand, rel=0.01)
    measured, predicted = np.array([row["sag_m"] for row in numbers["rows"]]).T
    np.testing.assert_allclose(1e3 * measured, [6.3, 16.5, 24.6])
    assert predicted[0] == pytest.approx(6.3e-3, abs=1e-8)
    np.testing.assert_allclose(predicted, measured, rtol=0.10)
    assert [verdict.split()[0] for verdict in verdicts(done[0], "Silicone")] == ["holds", "differs"] * 2
    assert all(v.endswith("one modulus does not explain it") for v in verdicts(done[0], "rotation"))


def test_six_readings_bear_no_conclusion(done) -> None:
    """Counting: three loads cannot both fit four numbers and prove them, so whatever is named is not claimed."""
    numbers = done[0].to_json()["numbers"]["silicone_missing"]
    assert verdicts(done[0], "What the beam model misses") == ["cannot be checked: no row is left to prove it on"]
    assert "too few rows to set any aside as proof" in numbers["sentence"]
    assert "sigma apart now" in numbers["next"]


def test_the_reference_solutions_are_met(done) -> None:
    """Shooting: the reference solutions, and their number of rows."""
    numbers = done[0].to_json()["numbers"]["reference_solutions"]
    assert (
        verdicts(done[0], "The default, one element of order 5")
        == verdicts(done[0], "20 linear elements have no share")
        == ["holds"]
    )
    assert sum(row["rows"] for row in numbers["default, one element of order 5"]) == 22
    assert max(row["theta_rad"] for row in numbers["default, one element of order 5"]) < 2e-7
    assert max(row["theta_rad"] for row in numbers["one element of order 6"]) < 1e-8
    # linear elements leave an error of second order: about 1/400 of the rotation, whose largest is 0.97
    assert 1e-4 < max(row["theta_rad"] for row in numbers["paper, 20 linear elements"]) < 1e-3


def test_the_page_is_whole_and_asks_for_nothing(done) -> None:
    """Contract: no request, no script, every figure with its numbers."""
    page = done[0].report.read_text(encoding="utf-8")
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
    assert f'<meta http-equiv="Content-Security-Policy" content="{policy}">' in page
    text = re.sub(r'"data:image/png;base64,[^"]*"', "", page)  # the thousand dots, drawn as an image inside the page
    assert not re.search(r"https?:|//|<script|@import|<link", text)
    assert not re.search(r"\bnan\b|\binf\b", text, flags=re.IGNORECASE)
    assert "None" not in text
    assert page.count("<svg ") == len(PICTURES)
    assert sorted(re.findall(r'href="([a-z_0-9]+)\.csv"', page)) == sorted(PICTURES)
    named = re.findall(r'\bid="([^"]+)"', page)
    assert len(named) == len(set(named))
    for claim in done[0].claims:
        assert html.escape(claim.verdict, quote=False).replace("'", "&#39;") in page


def test_text_is_escaped_and_what_is_unknown_is_a_dash(tmp_path) -> None:
    """By hand: the HTML."""
    table = Table("<b>", ("a", "b"), (("x < y", float("nan")), ("holds", 0.123456)))
    page = write_report(tmp_path / "page.html", "a & b", [Section("", tables=(table,))]).read_text(encoding="utf-8")
    assert "<title>a &amp; b</title>" in page
    assert "&lt;b&gt;" in page
    assert "<td>x &lt; y</td>" in page
    assert '<td class="number">–</td>' in page  # noqa: RUF001  the dash of the table
    assert '<td class="holds">holds</td><td class="number">0.1235</td>' in page


@pytest.mark.parametrize("module", ["matplotlib", "jinja2"])
def test_without_an_optional_package_the_error_names_it(monkeypatch, tmp_path, module) -> None:
    """Contract: the text of the error, and no folder made."""
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(InputError) as caught:
        reproduce(tmp_path / "out")
    assert str(caught.value) == f"a report needs {module}: pip install 'ecm-fast[report]'"
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_made_is_named(tmp_path) -> None:
    """Contract: the text of the error."""
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match=re.escape(f"{tmp_path / 'file' / 'out'}: cannot be made")):
        reproduce(tmp_path / "file" / "out")


def test_a_picture_of_simulated_data_says_so_in_the_picture(done) -> None:
    """Contract: simulated figures, and only these, say so."""
    page = done[0].report.read_text(encoding="utf-8")
    figures = re.findall(r"<svg .*?</svg>.*?href=.([a-z_0-9]+)\.csv", page, flags=re.DOTALL)
    drawings = re.findall(r"<svg .*?</svg>", page, flags=re.DOTALL)
    assert {name for name, drawing in zip(figures, drawings, strict=True) if "SIMULATED" in drawing} == set(SIMULATED)


def test_every_number_is_finite_but_what_was_not_measured(done) -> None:
    """Contract: null stands for what was not measured, and for nothing else."""
    unknown: list[str] = []

    def walk(value: Any, place: str) -> None:
        if isinstance(value, dict):
            for name, entry in value.items():
                walk(entry, f"{place}/{name}")
        elif isinstance(value, list):
            for entry in value:
                walk(entry, place)
        elif value is None:
            unknown.append(place)
        elif not isinstance(value, str):
            assert math.isfinite(value)

    walk(done[0].to_json()["numbers"], "")
    assert set(unknown) == {
        "/steel_cantilever/rms/x_m",
        "/steel_cantilever/rms/theta_rad",
        "/silicone_cantilever/rms/x_m",
    }


def test_both_presets_stand_in_every_section_after_the_paper(done) -> None:
    """Contract: both presets in every such section."""
    for name in ("table1", "workspace", "wrenches", "kinds", "trained", "pose_alone", "comparison", "times"):
        text = " ".join(f"{claim.what} {claim.ours}" for claim in done[0].parts[name])
        assert "slender" in text
        assert "paper" in text


def test_claims_are_a_table_too(done) -> None:
    """Contract: CSV and JSON hold the same claims."""
    with (done[1] / "claims.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert rows == done[0].to_json()["claims"]
    assert {row["section"] for row in rows} == set(SECTIONS)


def test_a_verdict_holds_up_to_its_bound() -> None:
    """By hand: below, above and unknown."""
    assert verdict(0.5, 0.5, "much") == "holds"
    assert verdict(0.50001, 0.5, "much") == "differs by much"
    assert verdict(math.nan, 0.5, "an unknown amount") == "differs by an unknown amount"


def test_unpublished_measurements_get_no_verdict(done) -> None:
    """Contract: claims about unpublished measurements cannot be checked."""
    for claim in done[0].parts["comparison"]:
        assert ("%" in claim.theirs) == (claim.verdict == "cannot be checked: the measurements are not public")


def test_hookes_law_on_neo_hookean_positions_is_stiffer() -> None:
    """Closed form: the ratio of two integrals, by SciPy's quad."""

    def force(short: float) -> float:
        return ((1.0 - short) ** -2 - (1.0 - short)) / 3.0

    by_hand = quad(lambda s: force(s) ** 2, 0.0, 0.2)[0] / quad(lambda s: s * force(s), 0.0, 0.2)[0]
    assert hooke_ratio(n=20001) == pytest.approx(by_hand, rel=1e-4)
    assert hooke_ratio() == pytest.approx(1.1932, abs=1e-4)


@pytest.mark.parametrize(("law", "factor"), [("neo-hookean", 1.0), ("hooke", hooke_ratio(n=21))])
def test_the_fit_meets_exact_positions_of_a_compressed_specimen(law, factor) -> None:
    """Closed form: positions of the neo-Hookean specimen, and the same ratio."""
    short = np.linspace(0.0, 0.2, 21)
    push = 7448.94 / 3.0 * ((1.0 - short) ** -2 - (1.0 - short))
    table = {"lam_l_N": 0.0 * push, "lam_r_N": 0.0 * push, "fx_N": -push, "x_m": 0.028 * (1.0 - short)}
    data = ecm.Measurements.from_columns({**table, "sigma_x_m": np.full(21, 1e-4)})
    bare = ecm.Mechanism().replace(length=0.028, mass_per_length=0.0, mass=0.0, axial_law=law)
    fit = fitted(bare, data, {"EA": 5000.0}, ("x",))
    assert fit.value[0] == pytest.approx(factor * 7448.94, rel=1e-7)


def test_the_stiffnesses_of_the_test_bed_are_found_again(done) -> None:
    """Known truth: the stiffnesses of the simulated test bed."""
    claims = done[0].parts["table1"]
    assert [claim.verdict for claim in claims if "found again" in claim.what] == ["holds"] * 6
    assert [claim.verdict.split(";")[0] for claim in claims if "on exact" in claim.ours] == [
        "differs by -0.9%",
        "holds",
    ]


def test_an_energy_has_as_many_coefficients_as_its_monomials() -> None:
    """Combinatorics."""
    for degree in (2, 3, 4, 5):
        assert coefficient_count("free", degree) == 3 * math.comb(degree + 3, 3)
        assert coefficient_count("conservative", degree) == math.comb(degree + 4, 3) - 1


def test_a_polynomial_misses_the_moment_of_a_bend_at_rest() -> None:
    """Closed form: EI times the precurvature is missing from the couple."""
    found = inverse_errors("paper", 0, 150, 60)
    # M = EI (kappa - 0.2): to hold a pose, the bent neck needs EI * 0.2 less
    tau = found["precurved", "the model's poses"]["tendons"][2]
    assert tau == pytest.approx(3.0 * 0.2, rel=0.01)
    assert found["precurved", "measured poses"]["tendons"][2] < 0.1 * tau


def test_the_wrench_that_holds_a_pose_is_that_of_the_tendons() -> None:
    """Statics: the tendons' own wrench, and the weight of the head with its lever."""
    neck = ecm.Mechanism.preset("slender")
    model, lam = ecm.FiniteElementModel(neck), np.random.default_rng(5).uniform(0.0, 160.0, (20, 2))
    poses = model.solve_batch(lam, tolerance=1e-13).pose
    pulled = tip_wrenches(model, poses, lam)
    held = holding(neck, poses, 0.5 * pulled)
    np.testing.assert_allclose(held, pulled, atol=1e-6)
    heavier = holding(neck.replace(mass=1.5), poses, held) - held
    weight = 0.5 * 9.81
    lever = -weight * 0.05 * np.sin(poses[:, 2])  # of the weight about Q, h sin(theta); the wrench takes it back
    np.testing.assert_allclose(heavier, np.column_stack([weight + 0.0 * lever, 0.0 * lever, lever]), atol=1e-7)


def test_a_held_neck_buckles_at_a_singular_compliance() -> None:
    """Closed form: 539.05 N for the free tip; a change of sign for the held one."""
    neck = ecm.Mechanism.preset("slender").replace(mass_per_length=0.0, mass=0.0)
    assert buckling(neck, held=False)[0] == pytest.approx(539.05, abs=0.01)
    load = buckling(neck, held=True)[0]
    push = np.array([[-0.998 * load, 0.0, 0.0], [-1.002 * load, 0.0, 0.0]])
    model = ecm.FiniteElementModel(neck, elements=8, order=4)
    below, above = np.linalg.det(model.sensitivities([], np.zeros((2, 2)), push).compliance)
    assert below * above < 0.0


def test_one_section_and_a_seed_can_be_chosen(tmp_path) -> None:
    """Contract: the files of one section alone."""
    messages: list[str] = []
    result = reproduce(tmp_path, only=["steel_cantilever"], seed=3, progress=messages.append)
    assert len(messages) == 1
    assert set(result.parts) == set(result.numbers) == {"steel_cantilever"}
    assert {path.name for path in tmp_path.iterdir()} == {*FILES, "steel_cantilever.csv"}


def test_a_section_that_does_not_exist_is_named(tmp_path) -> None:
    """Contract: the text of the error."""
    with pytest.raises(
        InputError, match=r"no section 'tabel1' \(did you mean 'table1'\?\); allowed are table1, workspace"
    ):
        reproduce(tmp_path / "out", only=["tabel1"])
    assert not (tmp_path / "out").exists()


def console(browser: str, page: Path, profile: Path) -> tuple[str, list[str]]:
    """Return the page as a browser understood it, and what it wrote to its console."""
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run"]
    command = [browser, *options, f"--user-data-dir={profile}", "--enable-logging=stderr", "--dump-dom", page.as_uri()]
    ended = subprocess.run(command, capture_output=True, timeout=200, check=True)
    return ended.stdout.decode(), [line for line in ended.stderr.decode().splitlines() if ":CONSOLE" in line]


def test_a_browser_opens_the_page_without_an_error_or_a_request(done, tmp_path) -> None:
    """A real browser's console, which does complain about a page that asks."""
    browser = shutil.which("chromium") or shutil.which("google-chrome") or shutil.which("chrome")
    if browser is None:
        pytest.skip("no browser here: neither chromium nor google-chrome is installed")
    # the page's policy forbids every request, and a browser says on its console what it refused
    text = done[0].report.read_text(encoding="utf-8")
    asking = tmp_path / "asking.html"
    asking.write_text(text.replace("</body>", '<img src="https://example.invalid/a.png"></body>'), encoding="utf-8")
    assert any("Content Security Policy" in line for line in console(browser, asking, tmp_path / "first")[1])
    seen, complaints = console(browser, done[0].report, tmp_path / "second")
    assert complaints == []
    assert seen.count("<svg ") == len(PICTURES)
