"""Code blocks, commands, links and names of the README and of the pages beside the code."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from ecm_fast import Mechanism
from ecm_fast.__main__ import main
from ecm_fast.mechanism.sections import SECTIONS, quantities
from ecm_fast.testbed import Sensors, measure, shear_test, tendon_test

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
EQUATIONS = ROOT / "ecm_fast" / "models" / "reference" / "equations.md"
PAGES = [README, *sorted((ROOT / "ecm_fast").rglob("README.md"))]
EVERY_PAGE = [*PAGES, EQUATIONS, ROOT / "bench" / "RESULTS.md", *sorted((ROOT / ".github").glob("*.md"))]
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?")


def blocks(page: Path, kind: str) -> list[str]:
    """Return the code blocks of one language, less those marked as not run."""
    return re.findall(rf"```{kind}\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)


def commands(page: Path) -> list[str]:
    """Return the commands of a page."""
    lines = [line.split("#")[0].strip() for block in blocks(page, "sh") for line in block.splitlines()]
    return [line for line in lines if line]


def cases(kind: str) -> list[object]:
    """Return page and number of every block of a language."""
    return [
        pytest.param(page, number, id=f"{page.parent.name}-{number}")
        for page in PAGES
        for number in range(len(blocks(page, kind)))
    ]


@pytest.mark.parametrize(("page", "number"), cases("python"))
def test_python_blocks_run(page, number, capsys, tmp_path, monkeypatch):
    """Truth: the page, whose code must run as printed."""
    monkeypatch.chdir(tmp_path)
    exec(compile(blocks(page, "python")[number], str(page), "exec"), {})
    assert "nan" not in capsys.readouterr().out


def test_the_first_block_prints_what_stands_below_it(capsys):
    """Truth: the printed output in the README, to six digits."""
    exec(compile(blocks(README, "python")[0], "README.md", "exec"), {})
    printed, shown = capsys.readouterr().out, blocks(README, "text")[0]
    assert NUMBER.sub("", printed).split() == NUMBER.sub("", shown).split()
    np.testing.assert_allclose(
        [float(word) for word in NUMBER.findall(printed)], [float(word) for word in NUMBER.findall(shown)], rtol=1e-6
    )


@pytest.mark.parametrize("page", [page for page in PAGES if commands(page)], ids=lambda page: page.parent.name)
def test_commands_run_in_order(page, tmp_path, monkeypatch, capsys):
    """Truth: the page, whose commands must succeed as printed, one after the other, with the answer that it shows."""
    monkeypatch.chdir(tmp_path)
    neck = Mechanism().replace(pulley_radius=0.005)
    measure(neck, tendon_test(grid=6, seed=1), Sensors(force_sigma=0.1), seed=1).to_csv("run.csv")
    measure(neck, shear_test(np.linspace(-60.0, 60.0, 9)), Sensors(force_sigma=0.1), seed=2).to_csv("other.csv")
    for block in blocks(page, "toml"):
        Path("sweep.toml").write_text(block)
    asked = commands(page)
    if page == README:
        assert asked[:2] == ["python3 tools/run.py ecm-fast reproduce", "python3 tools/run.py pytest"]
        asked = asked[2:]
    for command in asked:
        words = shlex.split(command)
        assert words[:3] == ["python3", "tools/run.py", "ecm-fast"]
        assert main(words[3:]) == 0, capsys.readouterr().err
    if page == README:
        printed = " ".join(capsys.readouterr().out.split())
        sentence, *lines = blocks(README, "text")[2].replace("the\nmechanism", "the mechanism").splitlines()
        assert all(" ".join(line.split()) in printed for line in (sentence, *lines))


def test_the_readme_fits_in_150_lines():
    """Truth: a project rule."""
    assert len(README.read_text(encoding="utf-8").splitlines()) <= 150


@pytest.mark.parametrize("page", EVERY_PAGE, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_and_file_it_names_is_there(page):
    """Truth: the files of the repository."""
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+)\)", text):
        assert "://" in target or (page.parent / target).exists(), target
    for name in re.findall(r"`((?:ecm_fast|tools|bench|tests|kernels|models)/[\w/.]+)`", text):
        assert (ROOT / name).exists() or (ROOT / "ecm_fast" / name).exists(), name


def test_every_equation_stands_where_the_page_says():
    """Truth: the text of the files, which give the paper's numbers."""
    rows = re.findall(r"^\| (\(.*?\)) \|.*\| (.*?) \|$", EQUATIONS.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(rows) > 10
    for numbers, files in rows:
        paths = [EQUATIONS.parent / link for link in re.findall(r"\]\((.*?)\)", files)]
        for number in numbers.split(", "):
            assert any(number in path.read_text("utf-8") for path in paths), (number, files)


def test_the_drawing_shows_every_name():
    """Truth: the declared quantities of the mechanism, each of which the drawing must name."""
    drawing = (ROOT / ".pictures" / "mechanism.svg").read_text(encoding="utf-8")
    words = set(re.findall(r"\w+", re.sub(r"<[^>]*>", " ", drawing)))
    names = {entry.name for section in SECTIONS.values() for entry in quantities(section)} | {"axial_law"}
    loads = {"lam_l_N", "lam_r_N", "fx_N", "fz_N", "tau_Nm", "tilt_deg"}
    assert names | loads <= words
