"""Write the simulated campaigns that ship with the package, `ecm_fast/data/datasets/simulated/`.

    python tools/make_datasets.py [--check]

The experiments are those of the paper, Section 2.4 and Section 3, done on the test bed of `ecm_fast.testbed`.
"""

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ecm_fast.data.columns import COLUMNS
from ecm_fast.data.measurements import Measurements, read_measurements
from ecm_fast.mechanism.mechanism import Mechanism
from ecm_fast.testbed import Sensors, compression_test, in_sequence, measure, shear_test, tendon_test

FOLDER = Path(__file__).resolve().parent.parent / "ecm_fast" / "data" / "datasets" / "simulated"
SENSORS = Sensors(camera_resolution=(1e-6, 1e-6, 1e-5), force_sigma=0.1, force_resolution=0.01)
SEED = 2026
SPECIMENS = {"28mm": (0.028, 7448.94), "40mm": (0.040, 7591.09)}
"""Length [m] and EA [N] of the compressed specimens: Table 1 of the paper."""
SAME_ON_EVERY_MACHINE = 1e-9
"""Readings are rounded, so that the last digits of a solve do not show."""

HEADER = """\
SIMULATED, nobody measured this. Written by tools/make_datasets.py: the beam's differential equations were integrated
(ecm_fast.testbed), no finite elements, and noise was added.
{what}
Truth: the mechanism file of the same name; EA {EA:g} N, GA {GA:g} N, EI {EI:g} N m^2, L {length:g} m, neo-Hookean, no
further effect. Seed of the loads, where they are random: {load_seed}; of the noise: {seed}.
Noise, one standard deviation, Gaussian and white: 0.1 mm in x and z, 1 mrad in theta;
{forces}.
Readings are rounded to 1 um, 0.01 mrad and, of the tendon forces, 0.01 N."""
CELLS = "0.1 N in both tendon force readings"
WEIGHTS = "none in fx and fz, which are the forces that act; the tendons are off"


class Campaign(NamedTuple):
    """One file: its name, what was done, on what, and how the forces were read."""

    name: str
    what: str
    mechanism: Mechanism
    loads: Measurements
    sensors: Sensors
    forces: str


def campaigns() -> Iterator[Campaign]:
    """Yield the campaigns that ship."""
    unloaded = Sensors(camera_resolution=SENSORS.camera_resolution)
    shear = in_sequence(shear_test(np.linspace(0.0, 33.0, 12)), shear_test(np.linspace(0.0, 66.0, 12)))
    for preset in ("slender", "paper"):
        neck = Mechanism.preset(preset)
        tendon = tendon_test(260, replicated=10, replicates=5, seed=SEED)
        what = f"Tendon test of the {preset} preset: 260 random pairs up to 160 N, ten of them five times, 300 rows."
        yield Campaign(f"simulated_{preset}_tendon", what, neck, tendon, SENSORS, CELLS)
        what = f"Shear test of the {preset} preset: side forces up to 33 N (session 1) and 66 N (session 2)."
        yield Campaign(f"simulated_{preset}_shear", what, neck, shear, unloaded, WEIGHTS)
    for label, (length, EA) in SPECIMENS.items():
        specimen, pushes = compression_test(length, Mechanism().replace(EA=EA), n=41)
        what = f"Compression of a bare specimen, {label[:2]} mm long, without weight, by up to 20 % of its length."
        yield Campaign(f"simulated_compression_{label}", what, specimen, pushes, unloaded, WEIGHTS)


def write(folder: Path) -> None:
    """Write every campaign and its mechanism."""
    for place, campaign in enumerate(campaigns()):
        beam, seed = campaign.mechanism.beam, SEED + place
        data = measure(campaign.mechanism, campaign.loads, campaign.sensors, seed)
        header = HEADER.format(
            what=campaign.what,
            forces=campaign.forces,
            load_seed=SEED,
            EA=beam.EA,
            GA=beam.GA,
            EI=beam.EI,
            length=beam.length,
            seed=seed,
        )
        data.to_csv(folder / f"{campaign.name}.csv", header)
        campaign.mechanism.to_toml(folder / f"{campaign.name}.toml")


def stale(folder: Path) -> list[str]:
    """Return the names of the files in `folder` that are not what `write` writes."""
    with tempfile.TemporaryDirectory() as fresh:
        write(Path(fresh))
        wanted = sorted(path.name for path in Path(fresh).iterdir())
        there = sorted(path.name for path in folder.iterdir())
        differ = [name for name in wanted if name in there and not same(Path(fresh) / name, folder / name)]
    return sorted({*differ, *(set(wanted) ^ set(there))})


def same(one: Path, other: Path) -> bool:
    """Tell whether two files say the same, to what digits are worth on another machine."""
    texts = [path.read_text(encoding="utf-8") for path in (one, other)]
    if texts[0] == texts[1] or one.suffix != ".csv":
        return texts[0] == texts[1]
    if len({tuple(line for line in text.splitlines() if line.startswith("#")) for text in texts}) > 1:
        return False
    left, right = read_measurements(one), read_measurements(other)
    if left.columns != right.columns or left.n != right.n:
        return False
    return all(
        np.allclose(getattr(left, name), getattr(right, name), rtol=0, atol=SAME_ON_EVERY_MACHINE, equal_nan=True)
        if column.units
        else np.array_equal(getattr(left, name), getattr(right, name))
        for name, column in COLUMNS.items()
    )


def main() -> int:
    """Write the files, or with --check say which are out of date."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="only compare; exit 1 when a file is out of date")
    if parser.parse_args().check:
        return int(bool(stale(FOLDER)))
    write(FOLDER)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
