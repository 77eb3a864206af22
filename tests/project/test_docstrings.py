"""Docstrings and names: noun phrases that a reader can search for."""

import ast
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULES = sorted(path for folder in ("ecm_fast", "tests", "bench", "tools") for path in (ROOT / folder).rglob("*.py"))
QUESTIONS = {"How", "What", "When", "Where", "Which", "Who", "Why"}


@cache
def tree_of(path: Path) -> ast.Module:
    """Return the syntax tree of a file."""
    return ast.parse(path.read_text(encoding="utf-8"))


def first_word(path: Path) -> str:
    """Return the first word of a module's docstring."""
    doc = ast.get_docstring(tree_of(path))
    assert doc, f"{path} has no docstring"
    return doc.split()[0].strip(":,'\"")


@pytest.mark.parametrize("folder", ["ecm_fast", "tests", "bench", "tools"])
def test_modules_are_described_by_noun_phrases(folder):
    """Truth: a project rule. "The result of one solve" can be searched for, "What a solve returns" cannot."""
    modules = [path for path in MODULES if path.is_relative_to(ROOT / folder)]
    assert modules
    assert {str(path.relative_to(ROOT)) for path in modules if first_word(path) in {*QUESTIONS, "Whether"}} == set()


def test_docstrings_name_what_they_describe():
    """Truth: a project rule. What, How and Where begin a question, not a description."""
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef)
    for path in MODULES:
        nodes = [node for node in ast.walk(tree_of(path)) if isinstance(node, documented)]
        assert not QUESTIONS & {(ast.get_docstring(node) or "-").split()[0] for node in nodes}, path


def tests_of(path: Path) -> list[ast.FunctionDef]:
    """Return the test functions of a file."""
    return [
        node for node in ast.walk(tree_of(path)) if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    ]


TESTS = [(path, node) for path in MODULES if path.name.startswith("test_") for node in tests_of(path)]


def test_every_test_says_which_truth_it_rests_on():
    """Truth: a project rule. A reader learns from a test what is known independently of the program."""
    assert len(TESTS) > 700
    assert [f"{path.name}::{node.name}" for path, node in TESTS if not ast.get_docstring(node)] == []


def test_names_of_tests_fit_in_60_characters():
    """Truth: a project rule."""
    assert [node.name for _, node in TESTS if len(node.name) > 60] == []


def test_no_module_borrows_underscored_names() -> None:
    """Truth: a project rule, read off the syntax trees; a name with an underscore is its module's own."""
    borrowed = [
        f"{path.relative_to(ROOT)}: {alias.name}"
        for path in MODULES
        if path.is_relative_to(ROOT / "ecm_fast")
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if alias.name.startswith("_")
        and not (alias.name.startswith("__") or (ROOT / "ecm_fast" / "cli" / f"{alias.name}.py").exists())
    ]
    assert borrowed == []
