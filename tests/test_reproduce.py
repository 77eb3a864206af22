"""The reproduction: its verdicts, the files it leaves, and a page that asks nothing of the network."""

import csv
import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from ecm_fast.errors import InputError

pytest.importorskip("matplotlib")
pytest.importorskip("jinja2")

from ecm_fast.report import Section, Table, write_report
from ecm_fast.reproduce import Reproduction, reproduce

PICTURES = ("shapes", "workspace_slender", "workspace_paper", "steel_cantilever", "silicone_cantilever")


@pytest.fixture(scope="module")
def done(tmp_path_factory) -> tuple[Reproduction, Path, list[str]]:
    told: list[str] = []
    folder = tmp_path_factory.mktemp("reproduction") / "made" / "here"
    return reproduce(folder, progress=told.append), folder, told


def verdicts(result: Reproduction, word: str) -> list[str]:
    return [claim.verdict for claim in result.claims if word in claim.what]


def test_all_files_are_there_and_progress_was_told(done) -> None:
    result, folder, told = done
    names = {"report.html", "results.json", *(f"{name}.csv" for name in PICTURES)}
    assert {path.name for path in folder.iterdir()} == names
    assert result.report == folder / "report.html"
    assert len(told) == 4


def test_the_results_are_strict_json_without_a_number_that_is_none(done) -> None:
    result, folder, _ = done

    def refuse(name: str) -> float:
        raise AssertionError(name)

    content = json.loads((folder / "results.json").read_text(encoding="utf-8"), parse_constant=refuse)
    assert content["claims"] == result.to_json()["claims"]
    assert content["numbers"] == result.to_json()["numbers"]
    assert content["numbers"]["steel_cantilever"]["rms"]["x_m"] is None
    assert result.to_json()["report"] == str(folder / "report.html")
    for claim in result.claims:
        assert claim.verdict in ("holds", "cannot be checked") or claim.verdict.startswith("differs by ")


def test_the_workspace_is_reached_in_every_case(done) -> None:
    result, folder, _ = done
    numbers = result.to_json()["numbers"]["workspace"]
    assert verdicts(result, "random pairs") == ["holds"] * 2
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
    numbers = done[0].to_json()["numbers"]["steel_cantilever"]
    assert verdicts(done[0], "Steel") == ["holds"]
    assert numbers["rows"] == 7
    assert 0.006 < numbers["share_of_length"] < 0.007  # the elastica without stretch and shear leaves 2.6 mm


def test_the_silicone_beams_sag_is_met_and_its_rotation_is_not(done) -> None:
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


def test_the_reference_solutions_are_met(done) -> None:
    numbers = done[0].to_json()["numbers"]["reference_solutions"]
    assert (
        verdicts(done[0], "The default, one element of order 5") == verdicts(done[0], "20 linear elements") == ["holds"]
    )
    assert sum(row["rows"] for row in numbers["default, one element of order 5"]) == 22
    assert max(row["theta_rad"] for row in numbers["default, one element of order 5"]) < 2e-7
    assert max(row["theta_rad"] for row in numbers["one element of order 6"]) < 1e-8
    # linear elements leave an error of second order: about 1/400 of the rotation, whose largest is 0.97
    assert 1e-4 < max(row["theta_rad"] for row in numbers["paper, 20 linear elements"]) < 1e-3


def test_the_page_is_whole_and_asks_for_nothing(done) -> None:
    page = done[0].report.read_text(encoding="utf-8")
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
    assert f'<meta http-equiv="Content-Security-Policy" content="{policy}">' in page
    text = re.sub(r'"data:image/png;base64,[^"]*"', "", page)  # the thousand dots, drawn as an image inside the page
    assert not re.search(r"https?:|//|<script|@import|<link", text)
    assert not re.search(r"\bnan\b|\binf\b", text, flags=re.IGNORECASE)
    assert "None" not in text
    assert page.count("<svg ") == len(PICTURES)
    assert sorted(re.findall(r'href="([a-z_]+)\.csv"', page)) == sorted(PICTURES)
    named = re.findall(r'\bid="([^"]+)"', page)
    assert len(named) == len(set(named))
    for claim in done[0].claims:
        assert claim.verdict in page


def test_text_is_escaped_and_what_is_unknown_is_a_dash(tmp_path) -> None:
    table = Table("<b>", ("a", "b"), (("x < y", float("nan")), ("holds", 0.123456)))
    page = write_report(tmp_path / "page.html", "a & b", [Section("", tables=(table,))]).read_text(encoding="utf-8")
    assert "<title>a &amp; b</title>" in page
    assert "&lt;b&gt;" in page
    assert "<td>x &lt; y</td>" in page
    assert '<td class="number">–</td>' in page  # noqa: RUF001  the dash of the table
    assert '<td class="holds">holds</td><td class="number">0.1235</td>' in page


@pytest.mark.parametrize("module", ["matplotlib", "jinja2"])
def test_without_an_optional_package_the_error_names_what_to_install(monkeypatch, tmp_path, module) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(InputError) as caught:
        reproduce(tmp_path / "out")
    assert str(caught.value) == f"a report needs {module}: pip install 'ecm-fast[report]'"
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_made_is_named(tmp_path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match=re.escape(f"{tmp_path / 'file' / 'out'}: cannot be made")):
        reproduce(tmp_path / "file" / "out")
