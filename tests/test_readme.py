"""What the README shows works as it stands there."""

import re
import shlex
from pathlib import Path

import pytest

from ecm_fast.__main__ import main

ROOT = Path(__file__).resolve().parent.parent
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", TEXT, re.DOTALL)
COMMANDS = [line.split("#")[0].strip() for kind, text in BLOCKS if kind == "sh" for line in text.splitlines()]


@pytest.mark.parametrize("code", [text for kind, text in BLOCKS if kind == "python"])
def test_python_blocks_run(code, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "README.md", "exec"), {})
    assert "nan" not in capsys.readouterr().out


def test_commands_run_in_order(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("run.csv").write_text("lam_l_N,lam_r_N,x_mm\n40,10,107.9\n")
    Path("sweep.toml").write_text(next(text for kind, text in BLOCKS if kind == "toml"))
    assert COMMANDS[:2] == ["python3 tools/run.py ecm-fast reproduce", "python3 tools/run.py pytest"]
    for command in COMMANDS[2:]:
        words = shlex.split(command)
        assert words[:3] == ["python3", "tools/run.py", "ecm-fast"]
        assert main(words[3:]) == 0, capsys.readouterr().err


def test_every_file_it_names_is_there():
    for name in re.findall(r"`((?:ecm_fast|tools|kernels|effects)/[\w/]+\.py)`", TEXT):
        assert (ROOT / name).exists() or (ROOT / "ecm_fast" / name).exists(), name
