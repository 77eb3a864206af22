"""The page of the catalogue: patterns against full solves, look-alikes against what is known of them."""

import json

import numpy as np
import pytest

pytest.importorskip("matplotlib")
pytest.importorskip("jinja2")

from ecm_fast.cli import main
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.mechanism.mechanism import Mechanism
from ecm_fast.models.instruments.prediction import predict
from ecm_fast.pages.catalogue import signatures, sweep

pytestmark = pytest.mark.slow


def test_patterns_are_differences_of_solves() -> None:
    """Central differences of full solves."""
    names = ("precurvature", "stiffness_taper", "clamp_tilt", "pulley_spacing")
    grid, neck, share = sweep(), Mechanism(), 1e-3
    shapes = signatures(neck, grid, [CATALOGUE[name] for name in names])
    for name, shape in zip(names, shapes, strict=True):
        size = CATALOGUE[name].size
        ends = [predict(neck.replace(**{name: sign * share * size.typical}), grid).pose for sign in (-1.0, 1.0)]
        np.testing.assert_allclose(
            shape, (ends[1] - ends[0]) / (2.0 * share), rtol=1e-3, atol=1e-4 * np.abs(shape).max()
        )


def test_mirror_classes_show_in_the_patterns() -> None:
    """Mirror symmetry: even and odd patterns."""
    grid = sweep()
    effects = [effect for effect in CATALOGUE.values() if effect.mirror in ("even", "odd")]
    sign, swap = np.array([1.0, -1.0, -1.0]), np.lexsort((grid.lam_l, grid.lam_r))
    back = np.lexsort((grid.lam_r, grid.lam_l))
    for effect, shape in zip(effects, signatures(Mechanism(), grid, effects), strict=True):
        here, there = shape[swap], shape[back] * sign * (1.0 if effect.mirror == "even" else -1.0)
        np.testing.assert_allclose(here, there, atol=1e-7 * np.abs(shape).max() + 1e-12, err_msg=effect.name)


def test_the_command_shows_look_alikes_and_writes_a_page(tmp_path, capsys) -> None:
    """Known look-alikes, and the links of the page."""
    assert main(["effects", "--out", str(tmp_path), "--json"]) == 0
    entries = {entry["name"]: entry for entry in json.loads(capsys.readouterr().out)["effects"]}
    assert set(entries) == set(CATALOGUE)
    alike = [other["name"] for other in entries["precurvature"]["look_alikes"]]
    assert set(alike) & {"head_com_sideways", "force_zero_asymmetry", "side_force"}
    text = (tmp_path / "effects.html").read_text(encoding="utf-8")
    assert all(f"<td>{name}</td>" in text for name in CATALOGUE)
    assert "://" not in text
    assert text.count("<svg ") == len({effect.group for effect in CATALOGUE.values()})


def test_without_a_mechanism_the_catalogue_stays_a_list(capsys) -> None:
    """Contract: the keys of the JSON."""
    assert main(["effects", "--json"]) == 0
    assert "look_alikes" not in json.loads(capsys.readouterr().out)["effects"][0]
