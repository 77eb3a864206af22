"""Run one of the project's tools on a machine that has nothing but Python 3.11 or newer.

    python3 tools/run.py ecm-fast solve --tendons 40 10
    python3 tools/run.py pytest

The first run makes `.venv` in the project's root. It is made anew when the Python, the dependencies, the constraints
or the place of the project change. Every message goes to stderr: stdout belongs to the tool.
"""

import hashlib
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows
    import msvcrt

    fcntl = None

ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / ".venv"
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
PYTHON = str(BIN / ("python.exe" if os.name == "nt" else "python"))
PACKAGES = ["--editable", ".", "--group", "dev", "--constraint", "tools/constraints.txt"]


def main(words):
    """Set up `.venv` if it is not ready, then become the tool."""
    check_version(sys.version_info)
    if not words:
        sys.exit("usage: python3 tools/run.py TOOL [ARGUMENT ...]     TOOL: ecm-fast, pytest, ruff, mypy, python ...")
    if not is_ready():
        with only_one():
            if not is_ready():  # another process may have set it up while this one waited
                set_up()
    tool = shutil.which(words[0], path=str(BIN))
    if tool is None:
        sys.exit(f"tools/run.py: there is no tool {words[0]!r} in {BIN}")
    if os.name == "nt":  # execv would give the prompt back before the tool has ended
        sys.exit(subprocess.call([tool, *words[1:]]))
    os.execv(tool, [tool, *words[1:]])


def check_version(version):
    """Refuse a Python that is too old."""
    if version[:2] < (3, 11):
        sys.exit(f"tools/run.py: needs Python 3.11 or newer, this is {version[0]}.{version[1]} ({sys.executable})")


def is_ready():
    """Tell whether `.venv` was set up to the end, and for what is asked of it now."""
    try:
        return (VENV / "stamp").read_text() == stamp()
    except OSError:
        return False


def stamp():
    """Return a digest of all that decides what must be in `.venv`."""
    import tomllib  # not at the top, where a Python before 3.11 would stop without saying why

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project.pop("tool", None)  # the settings of ruff or pytest change nothing in .venv
    constraints = (ROOT / "tools" / "constraints.txt").read_text(encoding="utf-8")
    parts = [sys.version, sys.base_prefix, str(ROOT), project, constraints]
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


@contextmanager
def only_one():
    """Wait until no other process sets up `.venv`; the system frees the lock when its owner ends, however it ends."""
    try:
        file = open(ROOT / ".venv.lock", "w")  # noqa: SIM115  closed below
    except OSError as error:
        sys.exit(f"tools/run.py: cannot make .venv in {ROOT} ({error.strerror})")
    with file:
        if not try_lock(file):
            say("another process is setting up .venv, waiting for it")
            while not try_lock(file):
                time.sleep(0.2)
        yield


def try_lock(file):
    """Lock an open file, or return False when another process holds it."""
    try:
        if fcntl:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        else:
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
    except (BlockingIOError, PermissionError):  # held: the first from fcntl, the second from msvcrt
        return False
    return True


def set_up():
    """Make `.venv` from nothing. uv installs; where it cannot, pip does."""
    for module in ("venv", "ensurepip"):
        if importlib.util.find_spec(module) is None:
            sys.exit(f"tools/run.py: this Python has no module '{module}'; Debian and Ubuntu have it in python3-venv")
    say("setting up .venv, once (a few hundred MB of packages)")
    by_uv = [PYTHON, "-m", "uv", "pip", "install", "--python", PYTHON, *PACKAGES]
    if os.environ.get("PYTHONDONTWRITEBYTECODE"):  # no import would keep what it compiled: numba's takes 3 x as long
        by_uv.append("--compile-bytecode")
    by_pip = [PYTHON, "-m", "pip", "install", "--quiet", *PACKAGES]
    ok = step([sys.executable, "-m", "venv", "--clear", str(VENV)])
    ok = ok and step([PYTHON, "-m", "pip", "install", "--quiet", "--upgrade", "pip", "uv"])  # --group needs pip 25.1
    if not (ok and (step(by_uv) or step(by_pip))):
        sys.exit("tools/run.py: could not set up .venv; the reason is above, most often it is no network")
    (VENV / "stamp").write_text(stamp())  # last, so that a set-up broken off is done again


def step(command):
    """Run one step of the set-up, away from the tool's stdin and stdout; return whether it succeeded."""
    say(" ".join(["python", *command[1:]]))
    return subprocess.run(command, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=sys.stderr.fileno()).returncode == 0


def say(message):
    """Write one line about the set-up."""
    print(f"tools/run.py: {message}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
