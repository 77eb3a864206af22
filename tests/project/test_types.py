"""Types of the public names and of the code in every page: mypy's own verdict, at its strictest."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import ecm_fast

pytestmark = pytest.mark.slow

pytest.importorskip("mypy")
ROOT = Path(__file__).resolve().parents[2]


def complaints(tmp_path: Path, programs: list[str], *options: str) -> list[str]:
    """Return what ``mypy --strict`` says of programs, each a file of its own."""
    files = []
    for i, program in enumerate(programs):
        files.append(tmp_path / f"program_{i}.py")
        files[-1].write_text(program, encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "--cache-dir", str(tmp_path / "cache")]
    done = subprocess.run(
        [*command, *options, *map(str, files)], capture_output=True, text=True, timeout=280, cwd=tmp_path
    )
    assert done.returncode in (0, 1), done.stderr
    return done.stdout.splitlines()


def test_a_type_checker_knows_every_public_name(tmp_path: Path) -> None:
    """``mypy --strict`` takes a name for private that is not listed: every one is used here, and one that is none."""
    uses = "\n".join(f"ecm.{name}" for name in ecm_fast.__all__)
    messages = complaints(tmp_path, [f"import ecm_fast as ecm\n{uses}\necm.no_such_name\n"])
    assert len(messages) == 1, messages
    assert 'Module has no attribute "no_such_name"' in messages[0]


def test_the_code_of_every_page_type_checks(tmp_path: Path) -> None:
    """``mypy --strict``, but that an example may define functions of its own without types."""
    pages = [ROOT / "README.md", *sorted((ROOT / "ecm_fast").rglob("README.md"))]
    code = [block for page in pages for block in re.findall(r"```python\n(.*?)```", page.read_text("utf-8"), re.DOTALL)]
    assert len(code) > 5
    assert complaints(tmp_path, code, "--allow-untyped-defs", "--allow-untyped-calls") == []


def test_the_lists_of_public_names_agree() -> None:
    """`__all__`, where each name is imported from, and what type checkers are shown."""
    source = ast.parse(Path(ecm_fast.__file__).read_text(encoding="utf-8"))
    block = next(node for node in source.body if isinstance(node, ast.If))
    shown = {alias.name: node.module for node in block.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert shown == {**ecm_fast._MODULE, **{name: home.rpartition(".")[0] for name, home in ecm_fast._FOLDER.items()}}
    assert {*shown, "__version__"} == set(ecm_fast.__all__)
    assert len(ecm_fast.__all__) == len(set(ecm_fast.__all__))
