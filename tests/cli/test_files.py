"""Files of the user on the command line: what is read, and that no output replaces an input."""

import json
import os
from pathlib import Path

import pytest
from commands import Refused

from ecm_fast.cli import main
from ecm_fast.errors import InputError
from ecm_fast.files import MOST_BYTES, inputs_kept, read_whole, write_whole

RUN = "lam_l_N,lam_r_N,x_mm,z_mm,theta_rad\n" + "".join(f"{i},{2 * i % 7},107,{i / 9},0\n" for i in range(12))
NECK = "# my own remark\npreset = 'slender'\n[beam]\nEI = 2.9\n"


@pytest.mark.parametrize(
    ("words", "own", "content"),
    [
        ("diagnose run.csv --mechanism mechanism.toml --out .", "mechanism.toml", NECK),
        ("diagnose run.csv --mechanism out/mechanism.toml", "out/mechanism.toml", NECK),
        ("diagnose run.csv --report run.csv", "run.csv", RUN),
        ("diagnose run.csv --test more.csv --report more.csv", "more.csv", RUN),
        ("identify run.csv --fit EI --mechanism identified.toml --out .", "identified.toml", NECK),
        ("predict predicted.csv --out .", "predicted.csv", RUN),
        ("predict run.csv --mechanism link.toml --out out", "out/predicted.csv", NECK),
        ("polynomial eval out/polynomial.json wrenches.csv --out .", "wrenches.csv", RUN),
        ("hide --mechanism neck.toml --truth neck.toml", "neck.toml", NECK),
        ("hide --truth out/sealed.csv", "run.csv", RUN),
        pytest.param("effects --plugin effects.json --out .", "effects.json", "pass\n", marks=pytest.mark.slow),
        ("sweep summary.json --out .", "summary.json", "[sweep]\ncases = 64\n[inputs]\nlam_l = [0, 9]\n"),
    ],
)
def test_an_output_never_replaces_an_input(
    refused: Refused, words: str, own: str, content: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Contract: the file of the user stays as it was, byte for byte, whatever its name or its links."""
    Path("out").mkdir()
    for name, text in {"run.csv": RUN, "more.csv": RUN, own: content}.items():
        Path(name).write_text(text)
    if "link.toml" in words:
        Path("link.toml").symlink_to(own)
    if "polynomial" in words:
        assert main(["polynomial", "fit", "--poses", "50", "--degree", "1"]) == 0
        capsys.readouterr()
    if "sweep" in words:
        pytest.importorskip("pyarrow")
    text = refused(*words.split())
    assert "is an input of this command" in text or "two outputs of this command would go there" in text
    assert Path(own).read_text() == content


def test_a_file_under_another_name_is_the_same_input(tmp_path: Path) -> None:
    """A hard link has another path, and POSIX's device and number of the same file."""
    path, other = tmp_path / "a.toml", tmp_path / "b.toml"
    path.write_text("mine")
    os.link(path, other)
    with inputs_kept():
        assert read_whole(path) == b"mine"
        with pytest.raises(InputError, match=r"b\.toml: is an input of this command"):
            write_whole(other, "yours")
    write_whole(other, "yours")  # from Python, who reads and writes a file means it
    assert (path.read_text(), other.read_text()) == ("mine", "yours")


READERS = [
    "predict {}.csv",
    "predict {}.mat",
    "predict {}.parquet",
    "solve --tendons 1 2 --mechanism {}.toml",
    "sweep {}.toml",
    "next {}.json",
    "polynomial eval {}.json --pose 0 0 0",
    "score answer.json {}.json",
    "effects --plugin {}.py",
]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes and devices of POSIX")
@pytest.mark.timeout(60)
@pytest.mark.parametrize("words", READERS)
def test_pipes_devices_and_folders_are_refused(refused: Refused, words: str) -> None:
    """POSIX: to open a pipe waits for a writer, to read /dev/zero never ends; both must be one line at once."""
    name = words.split("{}")[1].split()[0]
    os.mkfifo(f"pipe{name}")
    Path(f"zero{name}").symlink_to("/dev/zero")
    Path(f"folder{name}").mkdir()
    for kind, reason in (("pipe", "not a regular file"), ("zero", "not a regular file"), ("folder", "irectory")):
        text = refused(*words.format(kind).split())
        assert text.startswith(f"{kind}{name}")
        assert reason in text


def test_a_file_too_large_to_be_read_is_refused(tmp_path: Path) -> None:
    """A sparse file takes no room on disk, and would take all of the memory."""
    path = tmp_path / "huge.toml"
    with path.open("wb") as file:
        file.truncate(MOST_BYTES + 1)
    with pytest.raises(OSError, match="allowed are"):
        read_whole(path)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="file names that are no text")
def test_names_that_are_no_text_stop_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """POSIX: a file name is any bytes. What is written about such a file has the byte as an escape."""
    monkeypatch.chdir(tmp_path)
    name = os.fsdecode(b"d\xff.csv")
    Path(name).write_text(RUN)
    assert main(["predict", name, "--out", os.fsdecode(b"o\xff"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert Path(found["csv"]).exists()
    assert write_whole("page.html", f"<p>{name}</p>").read_bytes() == b"<p>d\\udcff.csv</p>"


def test_a_plugin_that_ends_the_program_is_said(refused: Refused) -> None:
    """A module that calls `sys.exit` would otherwise end the command as if all was done."""
    Path("own.py").write_text("import sys\nsys.exit(0)\n")
    assert refused("effects", "--plugin", "own.py") == "own.py: SystemExit: 0"
