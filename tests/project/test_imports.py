"""Imports: their direction, and their cost."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

import ecm_fast

PACKAGE = Path(ecm_fast.__file__).parent


def loaded_after(statement: str) -> set[str]:
    """Return the modules that a fresh interpreter holds after `statement`."""
    code = f"import json, sys\n{statement}\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True)
    return set(json.loads(done.stdout.splitlines()[-1]))


def test_the_package_itself_loads_nothing() -> None:
    """Python's own list of loaded modules."""
    modules = loaded_after("import ecm_fast")
    assert modules & {"numba", "numpy", "scipy", "matplotlib"} == set()


def test_the_model_loads_no_optimizer_and_no_plots() -> None:
    """Python's own list of loaded modules."""
    modules = loaded_after("import ecm_fast; ecm_fast.FiniteElementModel().solve((40.0, 10.0)).raise_if_failed()")
    assert "numba" in modules
    assert modules & {"scipy.optimize", "scipy.stats", "scipy.sparse", "matplotlib", "pyarrow"} == set()


def test_imports_go_one_way() -> None:
    """import-linter, with the contracts of pyproject.toml."""
    pytest.importorskip("importlinter")
    command = [sys.executable, "-c", "from importlinter.cli import lint_imports_command as run; run()", "--no-cache"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, cwd=PACKAGE.parent)
    assert done.returncode == 0, done.stdout
    assert " 0 broken" in done.stdout


def test_every_public_name_is_there() -> None:
    """Contract: `__all__`."""
    for name in ecm_fast.__all__:
        assert getattr(ecm_fast, name) is not None
    assert set(ecm_fast.__all__) <= set(dir(ecm_fast))


def test_a_name_that_is_not_public() -> None:
    """Contract: the text of the error."""
    with pytest.raises(AttributeError, match=r"^module 'ecm_fast' has no attribute 'FiniteElement'$"):
        _ = ecm_fast.FiniteElement
