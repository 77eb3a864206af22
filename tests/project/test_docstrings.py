"""Docstrings and names: noun phrases that a reader can search for."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULES = sorted(path for folder in ("ecm_fast", "tests", "bench", "tools") for path in (ROOT / folder).rglob("*.py"))
QUESTIONS = {"How", "What", "When", "Where", "Whether", "Which", "Who", "Why"}


def first_word(path: Path) -> str:
    """Return the first word of a module's docstring."""
    doc = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
    assert doc, f"{path} has no docstring"
    return doc.split()[0].strip(":,'\"")


@pytest.mark.parametrize("folder", ["ecm_fast", "tests", "bench", "tools"])
def test_modules_are_described_by_noun_phrases(folder):
    """Truth: a project rule. "The result of one solve" can be searched for, "What a solve returns" cannot."""
    modules = [path for path in MODULES if path.is_relative_to(ROOT / folder)]
    assert modules
    assert {str(path.relative_to(ROOT)) for path in modules if first_word(path) in QUESTIONS} == set()
