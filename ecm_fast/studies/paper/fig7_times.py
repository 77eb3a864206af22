"""Fig. 7 of the paper: solve times of all models on this machine.

The paper times both models at 100 random pairs of pose and wrench from the workspace of its Fig. 4. Here a pair is
a random pair of tendon forces, which the finite element models are given, and the pose it leads to, which the
polynomial is given. The plain NumPy model stands for what the paper's program may have been like: nothing is known of
that program but that the polynomial was at least 200 times faster.

One solve is timed on its own at each pose, the shortest of several; every call of a series starts from where the one
before ended, at another random pose. A batch solves the poses many times over in a random order, and each of as many
batches as there are poses is timed on its own.
"""

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ... import __version__
from ...errors import InputError
from ...files import csv_text, write_whole
from ...mechanism.mechanism import Mechanism
from ...mechanism.mesh.discretization import Discretization
from ...mechanism.sections import PRESETS
from ...mechanism.vector import pack
from ...models import reference
from ...models.finite_element import FiniteElementModel
from ...models.polynomial.model import PolynomialModel
from ...models.polynomial.training import training_poses
from ...pages.plots import picture_bytes, plot_times, random_tendon_forces, shown_time
from ..timing import EMPTY, each_in_turn, machine, nothing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Fig7", "fig7"]

Array = NDArray[np.float64]
Way = tuple[Callable[..., object], Sequence[tuple[Any, ...]]]

_PLAIN = "20 linear elements in plain NumPy"
_CALL, _BATCH = "cubic polynomial, one call", "cubic polynomial, batch"
_ELEMENTS, _TRAINING = 20, 1000  # the paper's Section 3: 20 linear elements; 1000 training poses
_MODELS = {"20 linear elements": (_ELEMENTS, 1), "one element of order 5": (1, 5), "one element of order 4": (1, 4)}


@dataclass(frozen=True, eq=False, repr=False)
class Fig7:
    """Times of one solve.

    Attributes
    ----------
    settings : everything that the times depend on
    times : (n,) by way [s]: for each pose, or for each batch the mean of its solves
    """

    settings: Mapping[str, Any]
    times: Mapping[str, Array]

    @property
    def rows(self) -> tuple[dict[str, Any], ...]:
        """One row a way: its times [s], and how many times as long as the polynomial it takes, call by call."""
        return tuple(
            {
                "way": name,
                "shortest_s": float(seconds.min()),
                "median_s": float(np.median(seconds)),
                "longest_s": float(seconds.max()),
                "polynomials": float(np.median(seconds) / np.median(self.times[_BATCH if "batch" in name else _CALL])),
            }
            for name, seconds in self.times.items()
        )

    def figure(self) -> "Figure":
        """Draw the histograms."""
        return plot_times(self.times)

    def write(self, folder: str | os.PathLike[str]) -> tuple[Path, ...]:
        """Write table, times and picture into a folder that is there; returns the paths.

        Raises
        ------
        InputError : a file cannot be written, or matplotlib is missing.
        """
        place, figure = Path(folder), self.figure()
        content = {"settings": dict(self.settings), "rows": self.rows}
        return (
            write_whole(place / "bench.json", json.dumps(content, indent=1) + "\n"),
            write_whole(
                place / "bench.csv", csv_text({f"{name} [s]": seconds for name, seconds in self.times.items()})
            ),
            write_whole(place / "bench.svg", picture_bytes(figure, "svg")),
            write_whole(place / "bench.png", picture_bytes(figure, "png")),
        )

    def __str__(self) -> str:
        """Return the settings and the table as text."""
        lines = [f"{name}: {value}" for name, value in self.settings.items()]
        lines += ["", f"{'one solve':41}{'shortest':>10}{'median':>10}{'longest':>10}{'polynomials':>13}"]
        for row in self.rows:
            times = "".join(f"{shown_time(row[key]):>10}" for key in ("shortest_s", "median_s", "longest_s"))
            lines.append(f"{row['way']:41}{times}{row['polynomials']:13.3g}")
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<Fig7: {len(self.times)} ways, {self.settings['poses']} poses each>"


def fig7(
    mechanism: Mechanism | None = None,
    *,
    poses: int = 100,
    seed: int = 7,
    batch: int = 2048,
    tolerance: float = 1e-9,
    threads: int = 2,
    rounds: int = 2,
) -> Fig7:
    """Time every model at the same random poses.

    Parameters
    ----------
    mechanism : default the preset "slender"
    poses : how many
    seed : of the tendon forces, of the training wrenches and of the order in a batch
    batch : how many solves a batch has
    tolerance : largest error that Newton's method may leave, in rad and shares of the length
    threads : of the batches that are timed a second time
    rounds : the shortest of so many counts; a single call of the fast models is repeated ten times as often, one in
        plain NumPy once

    Raises
    ------
    InputError : a number is not one of these.
    """
    for name, value in {"poses": poses, "batch": batch, "threads": threads, "rounds": rounds}.items():
        if value < 1:
            raise InputError(f"{name} = {value}: allowed is a whole number >= 1")
    neck = Mechanism.preset("slender") if mechanism is None else mechanism
    cases = _Cases.from_mechanism(neck, poses, seed, batch)
    ways = _ways(neck, cases, tolerance, threads)
    counts = {name: rounds if "batch" in name else 10 * rounds for name in ways} | {_PLAIN: 1}
    found = each_in_turn(ways, rounds=counts)
    control = min(found.pop(EMPTY))
    times = {
        name: np.array(seconds) / batch if "batch" in name else np.array(seconds) - control
        for name, seconds in found.items()
    }
    settings = {
        "mechanism": _name(neck),
        "poses": poses,
        "seed": seed,
        "batch": batch,
        "threads": threads,
        "tolerance": tolerance,
        "rounds": f"{rounds} of batches, {counts[_PLAIN]} in plain NumPy, {10 * rounds} of other calls",
        "subtracted from single calls": f"{shown_time(control)}, what an empty call takes",
        "polynomial": f"degree 3, {_TRAINING} training poses",
        "ecm-fast": __version__,
        **machine(),
    }
    return Fig7(settings, times)


@dataclass(frozen=True, eq=False)
class _Cases:
    """Inputs of the models: tendon forces and poses, one by one, and the same in batches."""

    lam: Array
    pose: Array
    poly: PolynomialModel
    batches: NDArray[np.int64]

    @classmethod
    def from_mechanism(cls, neck: Mechanism, poses: int, seed: int, batch: int) -> "_Cases":
        rng, model = np.random.default_rng(seed), FiniteElementModel(neck)
        lam = random_tendon_forces(poses, rng)
        result = model.solve_batch(lam, path="ignore")
        if not result.stable.all():
            row = int(np.argmin(result.stable))
            raise InputError(f"tendon forces {lam[row, 0]:.4g} and {lam[row, 1]:.4g} N: no stable pose of this neck")
        known = training_poses(model, _TRAINING, rng, path="ignore")
        poly = PolynomialModel.fit(known.poses, known.wrenches)
        return cls(lam, result.pose, poly, rng.integers(poses, size=(poses, batch)))


def _ways(neck: Mechanism, cases: _Cases, tolerance: float, threads: int) -> dict[str, Way]:
    """Return every way to solve, with the arguments of its calls."""
    p, mesh = reference.named(pack(neck)), Discretization.from_elements(_ELEMENTS, 1)
    pairs, poses = [tuple(row) for row in cases.lam.tolist()], [tuple(row) for row in cases.pose.tolist()]
    loads, points = [(cases.lam[rows],) for rows in cases.batches], [(cases.pose[rows],) for rows in cases.batches]
    models = {name: FiniteElementModel(neck, *how) for name, how in _MODELS.items()}
    ways: dict[str, Way] = {
        _PLAIN: (lambda left, right: reference.solve(p, mesh, [left, right, 0.0, 0.0, 0.0, 1.0]), pairs)
    }
    for name, model in models.items():
        ways[f"{name}, solve"] = (lambda *lam, model=model: model.solve(lam, path="ignore"), pairs)
    for name, model in models.items():
        ways[f"{name}, control step"] = (model.stepper(tolerance=tolerance, path="ignore"), pairs)
    ways[_CALL] = (cases.poly.stepper(), poses)
    ways[EMPTY] = (nothing, pairs)
    for name, model in models.items():
        for n in sorted({1, threads}):
            ways[f"{name}, batch, {n} core{'s' if n > 1 else ''}"] = (_batch(model, tolerance, n), loads)
    ways[_BATCH] = (cases.poly.polynomial, points)
    return ways


def _name(neck: Mechanism) -> str:
    preset = next((name for name in PRESETS if Mechanism.preset(name) == neck), None)
    return repr(neck) if preset is None else f"preset {preset}"


def _batch(model: FiniteElementModel, tolerance: float, threads: int) -> Callable[[Array], object]:
    return lambda lam: model.solve_batch(lam, tolerance=tolerance, threads=threads, path="ignore")
