"""`tools/run.py`, with the network and the real installation left out: every step of the set-up is replaced."""

import ast
import importlib.util
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "tools" / "run.py"
PYPROJECT = """
[project]
name = "toy"
dependencies = ["numpy"]
[tool.ruff]
line-length = 120
"""


@pytest.fixture
def root(tmp_path):
    """A project with a copy of the script, whose `.venv` is yet to be made."""
    (tmp_path / "tools").mkdir()
    (tmp_path / "tools" / "run.py").write_bytes(SCRIPT.read_bytes())
    (tmp_path / "tools" / "constraints.txt").write_text("numpy==2.4.6\n")
    (tmp_path / "pyproject.toml").write_text(PYPROJECT)
    return tmp_path


@pytest.fixture
def run(root):
    """The script as a module, at home in that project."""
    spec = importlib.util.spec_from_file_location("run_script", root / "tools" / "run.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Steps:
    """Stands in for `step`: notes each command, makes `.venv`, and fails where told to."""

    def __init__(self, run, *failing):
        self.run, self.failing, self.commands = run, failing, []

    def __call__(self, command):
        self.commands.append(command[1:])
        self.run.BIN.mkdir(parents=True, exist_ok=True)
        return not any(" ".join(command[1:]).startswith(words) for words in self.failing)

    @property
    def names(self):
        return [" ".join(command[:4]).removeprefix("-m ") for command in self.commands]


def refusal(call, *arguments):
    """The one line with which a call ends the script."""
    with pytest.raises(SystemExit) as caught:
        call(*arguments)
    text = caught.value.code
    assert isinstance(text, str), "sys.exit with a text writes it to stderr and ends with 1"
    assert "\n" not in text
    return text


def test_old_python_is_refused_by_version(run):
    """By hand: the text of the error."""
    assert "needs Python 3.11 or newer, this is 3.10" in refusal(run.check_version, (3, 10, 13))


@pytest.mark.parametrize("version", [(3, 11, 0), (3, 12, 1), (4, 0, 0)])
def test_newer_python_is_taken(run, version):
    """By hand: versions."""
    assert run.check_version(version) is None


def test_old_python_can_read_the_script_as_far_as_the_refusal():
    """Python's own parser with the grammar of 3.7."""
    tree = ast.parse(SCRIPT.read_text(), feature_version=(3, 7))
    imported = {name.name for node in tree.body if isinstance(node, ast.Import) for name in node.names}
    assert "tomllib" not in imported, "not there before 3.11"


def test_no_tool_named_prints_the_usage(run):
    """By hand: the text."""
    assert refusal(run.main, []).startswith("usage: python3 tools/run.py TOOL")


@pytest.mark.parametrize("missing", ["venv", "ensurepip"])
def test_python_without_venv_names_the_package_to_install(run, monkeypatch, missing):
    """By hand: the text of the error."""
    steps = Steps(run)
    monkeypatch.setattr(run, "step", steps)
    monkeypatch.setattr(run.importlib.util, "find_spec", lambda name: None if name == missing else object())
    text = refusal(run.set_up)
    assert f"'{missing}'" in text
    assert "python3-venv" in text
    assert steps.commands == []


def test_set_up_installs_with_uv_and_leaves_its_stamp(run, monkeypatch):
    """By hand: the commands in order."""
    steps = Steps(run)
    monkeypatch.setattr(run, "step", steps)
    assert not run.is_ready()
    run.set_up()
    assert steps.names == [f"venv --clear {run.VENV}", "pip install --quiet", "uv pip install"]
    assert run.is_ready()


def test_where_uv_fails_pip_installs_the_same(run, monkeypatch):
    """By hand: the commands in order."""
    steps = Steps(run, "-m uv")
    monkeypatch.setattr(run, "step", steps)
    run.set_up()
    assert steps.names[2:] == ["uv pip install", "pip install --quiet"]
    assert all(set(run.PACKAGES) <= set(command) for command in steps.commands[2:])
    assert run.is_ready()


@pytest.mark.parametrize("failing", [("-m venv",), ("-m pip",), ("-m uv", "-m pip install --quiet --editable")])
def test_failed_set_up_says_so_and_is_not_ready(run, monkeypatch, failing):
    """Contract: no stamp after a failure."""
    monkeypatch.setattr(run, "step", Steps(run, *failing))
    assert "no network" in refusal(run.set_up)
    assert not run.is_ready()


@pytest.mark.parametrize(("value", "expected"), [("1", True), ("", False), (None, False)])
def test_bytecode_is_compiled_where_imports_would_not_keep_it(run, monkeypatch, value, expected):
    """By hand: the commands."""
    monkeypatch.delenv("PYTHONDONTWRITEBYTECODE", raising=False)
    if value is not None:
        monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", value)
    steps = Steps(run)
    monkeypatch.setattr(run, "step", steps)
    run.set_up()
    assert ("--compile-bytecode" in steps.commands[2]) is expected


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [("pyproject.toml", '"numpy"', '"numpy", "scipy"'), ("tools/constraints.txt", "2.4.6", "2.4.7")],
)
def test_stamp_changes_with_what_must_be_installed(run, root, file, old, new):
    """Contract: another digest."""
    before = run.stamp()
    path = root / file
    path.write_text(path.read_text().replace(old, new))
    assert run.stamp() != before


@pytest.mark.parametrize(("name", "value"), [("version", "3.99.0"), ("base_prefix", "/elsewhere")])
def test_stamp_changes_with_the_interpreter(run, monkeypatch, name, value):
    """Contract: another digest."""
    before = run.stamp()
    monkeypatch.setattr(run.sys, name, value)
    assert run.stamp() != before


def test_stamp_changes_with_the_place_of_the_project(run, monkeypatch, root, tmp_path_factory):
    """A `.venv` copied along with its project would run the code of the place it came from."""
    before = run.stamp()
    copy = tmp_path_factory.mktemp("copy")
    for name in ("pyproject.toml", "tools/constraints.txt"):
        (copy / name).parent.mkdir(exist_ok=True)
        (copy / name).write_bytes((root / name).read_bytes())
    monkeypatch.setattr(run, "ROOT", copy)
    assert run.stamp() != before


def test_stamp_is_blind_to_settings_of_tools(run, root):
    """Contract: the same digest."""
    before = run.stamp()
    (root / "pyproject.toml").write_text(PYPROJECT.replace("120", "100"))
    assert run.stamp() == before


def test_set_up_at_once_by_two_happens_once(run, monkeypatch):
    """Contract: two threads, one set-up."""
    entered, others_turn = threading.Event(), threading.Event()
    steps = Steps(run)

    def slow_step(command):
        entered.set()
        assert others_turn.wait(20), "the other process never met the lock"
        return steps(command)

    def note(message):
        if "another process" in message:
            others_turn.set()

    ran = []
    monkeypatch.setattr(run, "step", slow_step)
    monkeypatch.setattr(run, "say", note)
    monkeypatch.setattr(run.shutil, "which", lambda tool, path: tool)
    monkeypatch.setattr(run.os, "execv", lambda tool, words: ran.append(tool))
    first = threading.Thread(target=run.main, args=(["first"],))
    second = threading.Thread(target=run.main, args=(["second"],))
    first.start()
    assert entered.wait(20)
    second.start()
    first.join(20)
    second.join(20)
    assert sorted(ran) == ["first", "second"]
    assert steps.names.count("uv pip install") == 1


def test_lock_is_free_again_when_its_owner_is_done(run, root):
    """The operating system's lock."""
    with run.only_one(), open(root / ".venv.lock", "w") as other:
        assert not run.try_lock(other)
    with open(root / ".venv.lock", "w") as other:
        assert run.try_lock(other)


def test_place_that_cannot_be_written_is_named(run, monkeypatch, root):
    """By hand: the text of the error."""
    monkeypatch.setattr(run, "ROOT", root / "absent")
    text = refusal(run.only_one().__enter__)
    assert str(root / "absent") in text


def test_steps_run_in_the_root_off_stdin_and_stdout(root):
    """Seen from a process of its own, as pytest has closed stdin here already."""
    noise = "import os, sys; print('step', os.getcwd(), repr(sys.stdin.read())); sys.exit(3)"
    caller = f"import sys, run; print(run.step([sys.executable, '-c', {noise!r}]), sys.stdin.read())"
    done = subprocess.run(
        [sys.executable, "-c", caller], cwd=root / "tools", input="typed", capture_output=True, text=True, check=True
    )
    assert done.stdout == "False typed\n"
    assert f"step {root} ''" in done.stderr


@pytest.mark.skipif(os.name == "nt", reason="the toy tool is a shell script")
def test_tool_gets_its_words_and_returns_its_exit_code(run, root):
    """A real shell script as tool."""
    run.BIN.mkdir(parents=True)
    tool = run.BIN / "toy"
    tool.write_text('#!/bin/sh\ncat\necho "$1|$2|$PWD"\nexit 7\n')
    tool.chmod(0o755)
    (run.VENV / "stamp").write_text(run.stamp())
    script = [sys.executable, str(root / "tools" / "run.py")]
    here = root / "tools"
    done = subprocess.run(
        [*script, "toy", "two words", "--json"], cwd=here, input="typed\n", capture_output=True, text=True
    )
    assert (done.returncode, done.stdout, done.stderr) == (7, f"typed\ntwo words|--json|{here}\n", "")
    absent = subprocess.run([*script, "tyo"], capture_output=True, text=True)
    assert absent.returncode == 1
    assert "no tool 'tyo'" in absent.stderr
