"""A real silicone tentacle: 14 postures under one tendon, four markers each (soromox, arXiv 2608.06650, MIT)."""

import csv
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ecm_fast as ecm
from ecm_fast.mechanism.body import Marker

AUTHORS = np.array([11.3, 13.3, 13.8, 29.9])
"""[mm] mean distances of their identified model from the four markers, from the file's provenance."""
OFFSETS = np.array([25.0, -21.0, 20.0, 0.0])
"""[mm] of the markers from the axis, at 60 degrees from the tendon's plane."""


BESIDE = Path(__file__).resolve().parents[3] / "shared" / "data" / "measured"
MEASURED = Path(os.environ.get("ECM_FAST_MEASURED", BESIDE))


@pytest.fixture(scope="module")
def postures():
    path = MEASURED / "soromox_tentacle" / "one_tendon_postures.csv"
    if not path.exists():
        pytest.skip(f"{MEASURED} with measurements of others is not here")
    text = path.read_text(encoding="utf-8")
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))


def tentacle() -> ecm.Mechanism:
    """Return the tentacle in a tendon's plane, by the file's provenance; E, nu, density where the authors began."""
    places = (0.1291, 0.2195, 0.2800)
    markers = [Marker(name=f"M{i + 1}", place=place, offset_z=0.5e-3 * OFFSETS[i]) for i, place in enumerate(places)]
    robot = ecm.Mechanism.robot("tentacle").replace(
        **{"segment1.radius_start": 0.01541, "segment1.radius_end": 0.00642, "segment2.radius_start": 0.00642,
           "E": 0.505e6, "nu": 0.45, "density": 1500.0}
    )  # fmt: skip
    return replace(robot, named_tendons=robot.named_tendons[:1],
                   markers=(*markers, Marker(name="M4", on_head=1.0, offset_x=0.008)))  # fmt: skip


def measurements(rows) -> ecm.Measurements:
    columns = {"lam_front_N": [float(row["tension_N"]) for row in rows]}
    for i in range(1, 5):
        columns[f"M{i}_x_m"] = [float(row[f"M{i}_down_m"]) for row in rows]
        columns[f"M{i}_z_m"] = [float(row[f"M{i}_lateral_m"]) for row in rows]
    return ecm.Measurements.from_columns(columns)


def distances(robot: ecm.Mechanism, rows) -> np.ndarray:
    """Return distances from the markers in space, (n, 4) [mm]: across the plane a marker stays where it is fixed."""
    in_plane = 1e3 * ecm.predict(robot, measurements(rows)).residual[:, 3:].reshape(-1, 4, 2)
    across = np.array([
        [1e3 * float(row[f"M{i}_out_of_plane_m"]) for i in range(1, 5)]
        + (1.0 if row["tendon"] == "1" else -1.0) * np.sqrt(0.75) * OFFSETS
        for row in rows
    ])  # fmt: skip
    return np.sqrt((in_plane**2).sum(axis=2) + across**2)


def test_two_numbers_bring_the_model_nearer_than_the_authors(postures):
    """Published: every marker is nearer than in the authors' identified model, 10.1, 9.5, 8.1, 16.4 mm here."""
    fit = ecm.identify(tentacle(), measurements(postures), ["E", "density"])
    assert (distances(fit.mechanism, postures).mean(axis=0) < AUTHORS).all()
    assert fit["E"].value == pytest.approx(0.37e6, rel=0.05)
    assert fit["density"].value == pytest.approx(1220.0, rel=0.1)


def test_what_is_found_in_one_session_holds_in_the_other(postures):
    """Locked rows: the first marker sits some 9 mm further along than stated, in either session, and B shows it."""
    first, second = ([row for row in postures if row["session"] == session] for session in "AB")
    names = ["E", "density", "tendon1.shift"]
    before = ecm.identify(tentacle(), measurements(first), names)
    after = [ecm.identify(tentacle(), measurements(rows), [*names, "M1.place"]) for rows in (first, second)]
    places = [fit["M1.place"] for fit in after]
    assert all(place.value == pytest.approx(0.138, abs=0.003) for place in places)
    assert all(place.value - 0.1291 > 8.0 * place.std for place in places)
    gap = [distances(fit.mechanism, second)[:, 0].mean() for fit in (before, after[0])]
    assert gap[1] < 0.6 * gap[0]
