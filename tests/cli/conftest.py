"""Shared fixtures of the command line: commands run in an empty folder."""

from pathlib import Path

import pytest
from commands import Ended, Refused, Run

from ecm_fast.cli import main

BARE = "preset = 'slender'\n[beam]\nmass_per_length = 0.0\n[head]\nmass = 0.0\n"


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Return a function that runs a command in a folder that holds a bare neck, ``bare.toml``, alone."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bare.toml").write_text(BARE)

    def _run(*words: object) -> Ended:
        code = main([str(word) for word in words])
        return Ended(code, *capsys.readouterr())

    return _run


@pytest.fixture
def refused(run: Run) -> Refused:
    """Return a function that runs a command which must be refused in one line, and returns that line."""

    def _refused(*words: object) -> str:
        ended = run(*words)
        assert (ended.code, ended.out) == (2, ""), ended.err
        assert ended.err.count("\n") == 1
        assert ended.err.startswith("ecm-fast: ")
        return ended.err.removeprefix("ecm-fast: ").removesuffix("\n")

    return _refused
