"""Mechanism, its file and its vector, against the paper and texts written by hand."""

import copy
import dataclasses
import math
import os
import pickle
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ecm_fast.errors import InputError
from ecm_fast.files import write_whole
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.mechanism.derived import limits
from ecm_fast.mechanism.mechanism import Effects, Mechanism
from ecm_fast.mechanism.parameters import PARAMETERS, PLACES, find, index
from ecm_fast.mechanism.sections import PRESETS, SECTIONS, Beam, Gravity, Head, Tendons
from ecm_fast.mechanism.toml_file import template
from ecm_fast.mechanism.vector import pack, unpack

# what the paper states, and what had to be inferred from it or assumed
THEORY = {
    "beam.length": (0.109, "found"),
    "beam.EA": (7500.0, "stated"),
    "beam.GA": (2420.0, "stated"),
    "beam.EI": (3.0, "stated"),
    "beam.mass_per_length": (9.47, "assumed"),
    "beam.axial_law": (0.0, "stated"),
    "head.mass": (1.0, "assumed"),
    "head.h": (0.05, "assumed"),
    "head.b": (0.0, "assumed"),
    "tendons.plate_half_width": (0.070, "derived"),
    "tendons.pulley_x": (0.0, "assumed"),
    "tendons.pulley_z": (0.070, "assumed"),
    "tendons.pulley_radius": (0.0, "assumed"),
    "gravity.g": (9.81, "assumed"),
    "gravity.tilt": (0.0, "assumed"),
}
NUMBER = "allowed is a finite number from"
LAWS = "allowed is 'neo-hookean' or 'hooke'"
KEYS = "allowed are preset, beam, head, tendons, gravity, effects, segment, tendon, marker"
LISTED = "the command 'effects' lists them"
BEAM_KEYS = "allowed are length, EA, GA, EI, mass_per_length, axial_law"


def message(call: Callable[..., Any], *args: Any, **kwargs: Any) -> str:
    with pytest.raises(InputError) as caught:
        call(*args, **kwargs)
    text = str(caught.value)
    assert len(text.splitlines()) == 1
    return text


# Presets


def test_defaults_are_those_of_the_table_and_name_their_source() -> None:
    """Published: the paper's values as tabulated by hand in `THEORY`."""
    built = [entry for entry in PARAMETERS[: len(PLACES)] if not entry.key.startswith("effects.")]
    assert {entry.key: (entry.default, entry.status) for entry in built} == THEORY
    assert all(entry.source for entry in built)


def test_the_slender_preset() -> None:
    """Published: the values of the table, written by hand."""
    neck = Mechanism.preset("slender")
    assert neck == Mechanism() == Mechanism.preset()
    assert neck.beam == Beam(0.109, 7500.0, 2420.0, 3.0, 9.47, "neo-hookean")
    assert neck.head == Head(1.0, 0.05, 0.0)
    assert neck.tendons == Tendons(0.070, 0.0, 0.070, 0.0)
    assert neck.gravity == Gravity(9.81)
    assert dict(neck.effects) == {}
    assert PRESETS["slender"]["beam.length"].status == "found"


def test_the_paper_preset_differs_in_the_length_alone() -> None:
    """Published: L = 0.040 m follows from the paper's Section 3."""
    paper, slender = Mechanism.preset("paper"), Mechanism.preset("slender")
    assert paper.beam.length == 0.040
    assert paper.replace(length=0.109) == slender
    entry = PRESETS["paper"]["beam.length"]
    assert (entry.default, entry.status) == (0.040, "derived")
    assert "2.9 N" in entry.source


def test_a_misspelt_preset() -> None:
    """Contract: the text of the error, written by hand."""
    assert message(Mechanism.preset, "papr") == (
        "preset = 'papr': allowed is 'slender' or 'paper' (did you mean 'paper'?)"
    )


def test_derived_numbers_follow_from_what_the_paper_states() -> None:
    """Published: area, mass and plate width from the paper's 871080, 7500 N, 11 N m and 160 N."""
    area = 7500.0 / 871080.0
    assert area == pytest.approx(8.610e-3, rel=1e-4)
    assert Mechanism().beam.mass_per_length == pytest.approx(1100.0 * area, abs=0.005)
    assert Mechanism().tendons.plate_half_width == pytest.approx(11.0 / 160.0, abs=0.002)


def test_every_effect_is_absent_by_default() -> None:
    """Contract: size 0 is the default of every effect, inside its bounds."""
    defaults = [entry.default for effect in CATALOGUE.values() for entry in effect]
    assert pack(Mechanism())[len(THEORY) : len(PLACES)].tolist() == defaults
    for effect in CATALOGUE.values():
        assert effect.size.default == 0.0
        assert effect.size.lower <= 0.0 < effect.size.typical < effect.size.upper
        assert effect.size.status == "zero"


# Values


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: Beam(EA=-1.0), f"beam.EA = -1.0: {NUMBER} 1e-12 to 1e+15 N"),
        (lambda: Beam(EA=math.nan), f"beam.EA = nan: {NUMBER} 1e-12 to 1e+15 N"),
        (lambda: Beam(EI=math.inf), f"beam.EI = inf: {NUMBER} 1e-12 to 1e+15 N m^2"),
        (lambda: Beam(GA=10**400), f"beam.GA = inf: {NUMBER} 1e-12 to 1e+15 N"),
        (lambda: Beam(length=0), f"beam.length = 0: {NUMBER} 1e-06 to 1e+06 m"),
        (lambda: Beam(GA=True), f"beam.GA = True: {NUMBER} 1e-12 to 1e+15 N"),
        (lambda: Beam(GA="7"), f"beam.GA = '7': {NUMBER} 1e-12 to 1e+15 N"),
        (lambda: Beam(GA=None), f"beam.GA = None: {NUMBER} 1e-12 to 1e+15 N"),
        (lambda: Beam(axial_law="Hooke"), f"beam.axial_law = 'Hooke': {LAWS} (did you mean 'hooke'?)"),
        (lambda: Beam(axial_law=1), f"beam.axial_law = 1: {LAWS}"),
        (lambda: Head(mass=-0.1), f"head.mass = -0.1: {NUMBER} 0 to 1e+06 kg"),
        (lambda: Head(b=2e3), f"head.b = 2000.0: {NUMBER} -1000 to 1000 m"),
        (lambda: Tendons(pulley_radius=-1e-9), f"tendons.pulley_radius = -1e-09: {NUMBER} 0 to 1000 m"),
        (lambda: Gravity(1e5), f"gravity.g = 100000.0: {NUMBER} -10000 to 10000 m/s^2"),
        (lambda: Effects({"precurvature": 101}), f"effects.precurvature = 101: {NUMBER} -100 to 100 1/m"),
        (lambda: Effects({"precurvatur": 1}), "effects.precurvatur: no such effect (did you mean 'precurvature'?)"),
    ],
)  # fmt: skip
def test_a_value_that_cannot_be(make: Callable[[], object], text: str) -> None:
    """Contract: the text of the error, written by hand."""
    assert message(make) == text


@pytest.mark.parametrize("entry", PARAMETERS[: len(PLACES)], ids=lambda entry: entry.key)
def test_the_bounds_themselves_are_allowed(entry: Any) -> None:
    """Contract: bounds are inclusive, the next number beyond is refused; L + a > 0 and 1 + gain > 0 end some before."""
    for value, own in zip(limits(entry.key, pack(Mechanism())), (entry.lower, entry.upper), strict=True):
        par = pack(Mechanism())
        par[index(entry.key)] = value
        assert pack(unpack(par)).tolist() == par.tolist()
        par[index(entry.key)] = np.nextafter(own, np.inf if own == entry.upper else -np.inf)
        assert message(unpack, par).startswith(f"{entry.key} = ")


def test_whole_numbers_become_floats() -> None:
    """Contract: the type."""
    assert type(Beam(EA=7500).EA) is float
    assert Beam(EA=7500) == Beam()


def test_numpy_numbers_are_numbers() -> None:
    """Contract: the type, and the value unchanged."""
    for value in (np.float64(2.5), np.float32(2.5), np.int64(2)):
        neck = Mechanism().replace(EI=value)
        assert type(neck.beam.EI) is float
        assert value == neck.beam.EI


def test_a_mechanism_is_frozen_and_travels() -> None:
    """Contract: immutable, hashable, the same after pickle and copy."""
    neck = Mechanism().replace(precurvature=0.2, EI=2.0)
    with pytest.raises(AttributeError):
        neck.beam.EI = 1.0  # type: ignore[misc]
    with pytest.raises(TypeError):
        neck.effects["precurvature"] = 1.0  # type: ignore[index]
    assert pickle.loads(pickle.dumps(neck)) == copy.deepcopy(neck) == neck
    assert hash(pickle.loads(pickle.dumps(neck))) == hash(neck)


def test_an_effect_of_size_zero_is_absent() -> None:
    """Contract: 0 switches an effect off."""
    assert dict(Effects({"precurvature": 0.0, "head_mass": 0.5})) == {"head_mass": 0.5}
    assert Mechanism().replace(precurvature=0.2).replace(precurvature=0) == Mechanism()


# Names


def test_replace_takes_several_names_short_and_dotted() -> None:
    """By hand: the expected values are written out."""
    neck = Mechanism().replace(EI=2.9, h=0.06, precurvature=0.2, **{"head.mass": 2.0, "effects.head_mass": 0.1})
    assert (neck.beam.EI, neck.beam.EA) == (2.9, 7500.0)
    assert neck.head == Head(2.0, 0.06, 0.0)
    assert dict(neck.effects) == {"precurvature": 0.2, "head_mass": 0.1}
    assert Mechanism() == Mechanism.preset("slender")
    assert neck.replace(axial_law="hooke").beam.axial_law == "hooke"
    assert neck.replace(clamp_tilt=0.1).effects == {"precurvature": 0.2, "head_mass": 0.1, "clamp_tilt": 0.1}
    assert neck.replace() == neck


def test_replace_says_what_is_wrong() -> None:
    """Contract: the text of the error, written by hand."""
    assert message(Mechanism().replace, preCurvature=1.0) == (
        "no parameter is called 'preCurvature' (did you mean 'precurvature'?)"
    )
    assert message(Mechanism().replace, EI=0.0) == f"beam.EI = 0.0: {NUMBER} 1e-12 to 1e+15 N m^2"


def test_find_and_index() -> None:
    """Contract: every name leads to its own place, a misspelt one to a suggestion."""
    assert find("EA") is find("beam.EA") is PARAMETERS[index("EA")]
    assert find("precurvature").key == "effects.precurvature"
    assert [index(entry.key) for entry in PARAMETERS] == list(range(len(PARAMETERS)))
    assert message(find, "lenght") == "no parameter is called 'lenght' (did you mean 'length'?)"
    assert message(find, "beam.EAA") == "no parameter is called 'beam.EAA' (did you mean 'beam.EA'?)"
    assert message(find, "?") == "no parameter is called '?'"


def test_a_short_name_that_two_sections_share_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Contract: an ambiguous name is an error that lists the full names."""
    from ecm_fast.mechanism import parameters

    shared = {entry.name for entry in PARAMETERS[: len(PLACES)] if len(parameters._SHORT[entry.name]) > 1}
    assert shared == {"pulley_radius", "pulley_x", "pulley_z", "length"}
    for name in shared:  # effects, segments and named tendons yield to the sections of a neck
        assert find(name).key == ("beam.length" if name == "length" else f"tendons.{name}")
    monkeypatch.setitem(parameters._SHORT, "mass", ["head.mass", "beam.mass"])
    assert message(find, "mass") == "parameter 'mass' is ambiguous: say head.mass or beam.mass"


# The vector


def test_pack_puts_every_number_at_its_place() -> None:
    """By hand: the vector by name, and the way back."""
    neck = Mechanism.preset("paper").replace(axial_law="hooke", gravity_tilt=0.3, pulley_shift=-0.002)
    par = dict(zip([entry.key for entry in PARAMETERS[: len(PLACES)]], pack(neck).tolist(), strict=False))
    expected = {key: value for key, (value, _) in THEORY.items()}
    expected |= {entry.key: entry.default for effect in CATALOGUE.values() for entry in effect}
    expected |= {"beam.length": 0.040, "beam.axial_law": 1.0}
    expected |= {"effects.gravity_tilt": 0.3, "effects.pulley_shift": -0.002}
    assert par == expected
    assert unpack(pack(neck)) == neck


def test_a_vector_that_is_none() -> None:
    """Contract: the text of the error, written by hand."""
    n = len(PARAMETERS)
    assert message(unpack, np.zeros(3)) == f"a parameter vector has shape ({n},), not (3,)"
    par = pack(Mechanism())
    par[index("axial_law")] = 0.5
    assert message(unpack, par) == "beam.axial_law = 0.5: allowed is 0 (neo-hookean) or 1 (hooke)"


# The file


FULL = Mechanism.preset("paper").replace(
    axial_law="hooke", EA=1.0 / 3.0, GA=1e15, EI=1e-12, b=-5e-324, g=-9.8, pulley_shift=-0.1, precurvature=math.pi,
    **{"soft_spot.size": 0.2, "soft_spot.width": 0.02},
)  # fmt: skip


def test_a_file_reads_back_to_the_same_mechanism(tmp_path: Path) -> None:
    """Round trip: every digit survives."""
    path = tmp_path / "neck.toml"
    FULL.to_toml(path)
    assert Mechanism.from_toml(path) == FULL
    assert pack(Mechanism.from_toml(str(path))).tolist() == pack(FULL).tolist()


@pytest.mark.parametrize("preset", ["slender", "paper"])
def test_the_template_is_the_preset_and_names_every_source(tmp_path: Path, preset: str) -> None:
    """Published: the status of every value as tabulated by hand in `THEORY`."""
    path = tmp_path / "neck.toml"
    path.write_text(template(preset), encoding="utf-8")
    assert Mechanism.from_toml(path) == Mechanism.preset(preset)
    lines = {line.split(" = ")[0]: line for line in template(preset).splitlines() if " = " in line}
    for key, (_, status) in THEORY.items():
        expected = "derived" if (preset, key) == ("paper", "beam.length") else status
        assert f"({expected}: " in lines[key.split(".")[1]]


SOFT = Mechanism().replace(**{"soft_spot.size": 0.1, "soft_spot.place": 0.5})


def test_every_key_is_optional(tmp_path: Path) -> None:
    """By hand: the expected mechanisms are written out."""
    path = tmp_path / "neck.toml"
    for content, expected in {
        "": Mechanism(),
        "[beam]\n[effects]\n": Mechanism(),
        'preset = "paper"': Mechanism.preset("paper"),
        'preset = "paper"\n[beam]\nEI = 2': Mechanism.preset("paper").replace(EI=2.0),
        "[effects]\nprecurvature = 0.2": Mechanism().replace(precurvature=0.2),
        "[effects.precurvature]\nprecurvature = 0.2": Mechanism().replace(precurvature=0.2),
        "[effects]\nsoft_spot = 0.1": Mechanism().replace(**{"soft_spot.size": 0.1}),
        "[effects.soft_spot]\nsize = 0.1\nplace = 0.5": SOFT,
        "[effects]\nsoft_spot.size = 0.1\nsoft_spot.place = 0.5": SOFT,
        "\ufeff[head]\r\nh = 2.0 # as a plain editor of Windows writes it\r\n": Mechanism().replace(h=2.0),
    }.items():  # fmt: skip
        path.write_bytes(content.encode())
        assert Mechanism.from_toml(path) == expected, content


def test_the_example_of_the_interface_is_a_good_file(tmp_path: Path) -> None:
    """By hand: the documented example."""
    path = tmp_path / "neck.toml"
    path.write_text(
        'preset = "slender"\n[beam]\nlength = 0.109\nEA = 7500.0\nGA = 2420.0\nEI = 3.0\nmass_per_length = 9.47\n'
        'axial_law = "neo-hookean"\n[head]\nmass = 1.0\nh = 0.05\nb = 0.0\n[tendons]\nplate_half_width = 0.070\n'
        "pulley_x = 0.0\npulley_z = 0.070\npulley_radius = 0.0\n[gravity]\ng = 9.81\n[effects]\nprecurvature = 0.2\n"
    )
    assert Mechanism.from_toml(path) == Mechanism().replace(precurvature=0.2)


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("beam = 3", "beam = 3: allowed is a table, written [beam]"),
        ("effects = []", "effects = []: allowed is a table, written [effects]"),
        ("[bean]\nEA = 1", f"unknown key 'bean' (did you mean 'beam'?); {KEYS}"),
        ("EA = 1", f"unknown key 'EA'; {KEYS}"),
        ('preset = "papers"', "preset = 'papers': allowed is 'slender' or 'paper' (did you mean 'paper'?)"),
        ("preset = 1", "preset = 1: allowed is 'slender' or 'paper'"),
        ("[beam]\nlenght = 1", f"unknown key beam.lenght (did you mean 'length'?); {BEAM_KEYS}"),
        ("[head]\nmas = 1", "unknown key head.mas (did you mean 'mass'?); allowed are mass, h, b"),
        ('[beam]\nEA = "7500"', f"beam.EA = '7500': {NUMBER} 1e-12 to 1e+15 N"),
        ("[beam]\nEA = true", f"beam.EA = True: {NUMBER} 1e-12 to 1e+15 N"),
        ("[beam]\nEA = nan", f"beam.EA = nan: {NUMBER} 1e-12 to 1e+15 N"),
        ("[beam]\nEA = -inf", f"beam.EA = -inf: {NUMBER} 1e-12 to 1e+15 N"),
        ("[beam]\nEA = [7500.0]", f"beam.EA = [7500.0]: {NUMBER} 1e-12 to 1e+15 N"),
        ("[beam.EA]\nvalue = 1", f"beam.EA = {{'value': 1}}: {NUMBER} 1e-12 to 1e+15 N"),
        ('[beam]\naxial_law = "neo-hooke"', f"beam.axial_law = 'neo-hooke': {LAWS} (did you mean 'neo-hookean'?)"),
        ("[gravity]\ng = 1e5", f"gravity.g = 100000.0: {NUMBER} -10000 to 10000 m/s^2"),
        ("[effects]\nclamp = 1", f"unknown effect effects.clamp (did you mean 'clamp_tilt'?); {LISTED}"),
        ("[effects]\nprecurvature = 1e3", f"effects.precurvature = 1000.0: {NUMBER} -100 to 100 1/m"),
        ("[effects.precurvature]\nsize = 1", "unknown key effects.precurvature.size; allowed are precurvature"),
        (
            "[effects.soft_spot]\nwith = 1",
            "unknown key effects.soft_spot.with (did you mean 'width'?); allowed are size, place, width",
        ),
        ("[effects.soft_spot]\nplace = 2", f"effects.soft_spot.place = 2: {NUMBER} 0 to 1"),
        ('[beam]\n"a\\nb" = 1', f"unknown key beam.'a\\nb'; {BEAM_KEYS}"),
        ('[effects]\n"a\\nb" = 1', f"unknown effect effects.'a\\nb'; {LISTED}"),
    ],
)  # fmt: skip
def test_a_file_that_cannot_be_meant(tmp_path: Path, content: str, text: str) -> None:
    """Contract: the text of the error, written by hand."""
    path = tmp_path / "neck.toml"
    path.write_text(content, encoding="utf-8")
    assert message(Mechanism.from_toml, path) == f"{path}: {text}"


@pytest.mark.parametrize(
    "content",
    [
        b"[beam",
        b"EA",
        b"[beam]\nEA = 1\nEA = 2",
        b"[beam]\nEA = 1.\n",
        b"\xff\xfe[\x00b\x00",
        b"\x00",
        b"a = " + b"[" * 100_000,
        b"a = " + b"9" * 5000,
    ],
)
def test_a_file_that_is_not_toml(tmp_path: Path, content: bytes) -> None:
    """Contract: one line that names the file."""
    path = tmp_path / "neck.toml"
    path.write_bytes(content)
    assert message(Mechanism.from_toml, path).startswith(f"{path}: not a TOML file (")


@pytest.mark.parametrize(
    ("content", "key"),
    [
        ("beam = {}", "beam"),
        ("preset = {}", "preset"),
        ("[beam]\nEA = [{}]", "beam.EA"),
        ("[beam]\naxial_law = {}", "beam.axial_law"),
    ],
)
def test_a_number_too_long_to_be_written_out(tmp_path: Path, content: str, key: str) -> None:
    """Contract: one line that names the key, whatever the number of digits."""
    path = tmp_path / "neck.toml"
    path.write_text(content.format("0x" + "f" * 5000))
    assert message(Mechanism.from_toml, path).startswith(f"{path}: {key} = ")


def test_a_table_nested_too_deep_to_be_written_out(tmp_path: Path) -> None:
    """Contract: one line that names the key, whatever the depth."""
    path = tmp_path / "neck.toml"
    path.write_text("[beam]\nEA" + ".a" * 5000 + " = 1")
    assert message(Mechanism.from_toml, path).startswith(f"{path}: beam.EA = ")


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    """Contract: the operating system's reason in one line."""
    assert message(Mechanism.from_toml, tmp_path / "no.toml") == (
        f"{tmp_path / 'no.toml'}: cannot be read (No such file or directory)"
    )
    assert message(Mechanism.from_toml, tmp_path) == f"{tmp_path}: cannot be read (Is a directory)"


# Writing files whole


def test_a_file_is_written_and_replaced(tmp_path: Path) -> None:
    """Contract: the bytes, and no other file left in the folder."""
    path = tmp_path / "a.txt"
    assert write_whole(path, "one\n") == path
    assert write_whole(str(path), b"two\n") == path
    assert path.read_bytes() == b"two\n"
    assert os.listdir(tmp_path) == ["a.txt"]


@pytest.mark.skipif(os.name == "nt", reason="Windows has no permission bits")
def test_a_new_file_is_as_public_as_any(tmp_path: Path) -> None:
    """Contract: the permissions that the operating system gives any file."""
    (tmp_path / "usual").touch()
    write_whole(tmp_path / "new", "")
    assert (tmp_path / "new").stat().st_mode == (tmp_path / "usual").stat().st_mode


@pytest.mark.parametrize("step", ["open", "chmod", "replace"])
@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt(), MemoryError()])
def test_a_failure_in_the_middle_leaves_the_old_file_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str, error: BaseException
) -> None:
    """Contract: a write that fails at any step changes nothing."""
    path = tmp_path / "a.txt"
    path.write_text("old")

    def fail(*args: Any, **kwargs: Any) -> None:
        raise error

    monkeypatch.setattr(os, step, fail)
    with pytest.raises(InputError if isinstance(error, OSError) else type(error)) as caught:
        write_whole(path, "new")
    monkeypatch.undo()
    if isinstance(error, OSError):
        assert str(caught.value) == f"{path}: cannot be written here (No space left on device)"
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


@pytest.mark.parametrize("step", ["open", "fsync", "chmod", "replace"])
def test_an_interrupt_leaves_no_temporary_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str) -> None:
    """Python's manual: a signal that comes during a system call is raised once that has done its work."""
    path, call = tmp_path / "a.txt", getattr(os, step)
    path.write_text("old")

    def interrupted(*args: Any, **kwargs: Any) -> None:
        if (done := call(*args, **kwargs)) is not None:
            os.close(done)
        raise KeyboardInterrupt

    monkeypatch.setattr(os, step, interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_whole(path, "new")
    monkeypatch.undo()
    assert path.read_text() == ("new" if step == "replace" else "old")
    assert os.listdir(tmp_path) == ["a.txt"]


def test_places_that_cannot_be_written(tmp_path: Path) -> None:
    """Contract: the operating system's reason in one line."""
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("")
    for place, reason in {
        tmp_path / "none" / "a.txt": "No such file or directory",
        tmp_path / "file" / "a.txt": "Not a directory",
        tmp_path / "folder": "Is a directory",
        tmp_path / "a\0b": "embedded null byte",
    }.items():
        assert message(write_whole, place, "x") == f"{place}: cannot be written here ({reason})"
    assert message(FULL.to_toml, tmp_path / "none" / "n.toml").startswith(f"{tmp_path / 'none' / 'n.toml'}: ")
    assert sorted(os.listdir(tmp_path)) == ["file", "folder"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_what_is_no_file_is_not_replaced_by_one(tmp_path: Path) -> None:
    """Writing to /dev/null as root must not turn it into a file."""
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="cannot be written here"):
        write_whole(tmp_path / "pipe", "x")
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    """Contract: the target is written, the link is kept."""
    (tmp_path / "link").symlink_to(tmp_path / "file")
    (tmp_path / "file").write_text("old")
    write_whole(tmp_path / "link", "new")
    assert (tmp_path / "file").read_text() == "new"
    assert (tmp_path / "link").is_symlink()


def test_remarks_stand_at_the_top_and_change_nothing(tmp_path):
    """By hand: the comment lines; the mechanism is unchanged."""
    path = tmp_path / "neck.toml"
    FULL.to_toml(path, ["from run.csv", "two\nlines = 1"])
    assert path.read_text(encoding="utf-8").splitlines()[1:3] == ["# from run.csv", "# two lines = 1"]
    assert Mechanism.from_toml(path) == FULL


def test_a_file_s_silence_is_listed(tmp_path: Path) -> None:
    """A rod of which only the beam is written: what else decides whether it stands, but for the tilt, which is none."""
    (tmp_path / "rod.toml").write_text("[beam]\nlength = 0.5\nEA = 1.6e6\nGA = 5e5\nEI = 1.0\n")
    rod = Mechanism.from_toml(tmp_path / "rod.toml")
    named = {f"{name}.{item.name}" for name, part in SECTIONS.items() for item in dataclasses.fields(part)}
    assert set(rod.assumed) == named - {"beam.length", "beam.EA", "beam.GA", "beam.EI", "gravity.tilt"}
    assert {"head.mass", "beam.mass_per_length", "gravity.g"} <= set(rod.assumed)
    assert rod == Mechanism().replace(length=0.5, EA=1.6e6, GA=5e5, EI=1.0)


@pytest.mark.parametrize(
    ("text", "gone"),
    [
        ('preset = "slender"\n[beam]\nEI = 2.0\n', None),
        ("[head]\nmass = 0.0\n", {"head.h", "head.b"}),
        ("[gravity]\ng = 0.0\n", {"beam.mass_per_length", "head.mass", "head.h", "head.b"}),
    ],
    ids=["preset", "massless", "weightless"],
)
def test_what_no_answer_depends_on_is_not_listed(tmp_path: Path, text: str, gone: set[str] | None) -> None:
    """Statics: without weight no mass counts, without a head's mass no place of it; a preset that is named is meant."""
    (tmp_path / "neck.toml").write_text(text)
    assumed = Mechanism.from_toml(tmp_path / "neck.toml").assumed
    assert assumed == () if gone is None else not gone & set(assumed)


def test_written_files_say_everything(tmp_path: Path) -> None:
    """Files of `init` and of `to_toml`, which a diagnosis writes."""
    (tmp_path / "init.toml").write_text(template("paper"))
    Mechanism().replace(EI=2.9).to_toml(tmp_path / "found.toml")
    assert (
        Mechanism.from_toml(tmp_path / "init.toml").assumed
        == Mechanism.from_toml(tmp_path / "found.toml").assumed
        == ()
    )
