"""Code blocks and commands of the README and of the pages beside the code."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from ecm_fast import Mechanism
from ecm_fast.__main__ import main
from ecm_fast.testbed import Sensors, measure, shear_test, tendon_test

ROOT = Path(__file__).resolve().parents[2]
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
    neck = Mechanism().replace(pulley_radius=0.005)
    measure(neck, tendon_test(grid=6, seed=1), Sensors(force_sigma=0.1), seed=1).to_csv("run.csv")
    measure(neck, shear_test(np.linspace(-60.0, 60.0, 9)), Sensors(force_sigma=0.1), seed=2).to_csv("other.csv")
    Path("sweep.toml").write_text(next(text for kind, text in BLOCKS if kind == "toml"))
    assert COMMANDS[:2] == ["python3 tools/run.py ecm-fast reproduce", "python3 tools/run.py pytest"]
    for command in COMMANDS[2:]:
        words = shlex.split(command)
        assert words[:3] == ["python3", "tools/run.py", "ecm-fast"]
        assert main(words[3:]) == 0, capsys.readouterr().err


def test_every_file_it_names_is_there():
    for name in re.findall(r"`((?:ecm_fast|tools|kernels|effects)/[\w/]+\.py)`", TEXT):
        assert (ROOT / name).exists() or (ROOT / "ecm_fast" / name).exists(), name
