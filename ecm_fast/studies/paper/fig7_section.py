"""Fig. 7 of the paper: the section on solve times."""

from collections.abc import Mapping

import numpy as np

from ...mechanism.mechanism import Mechanism
from ...mechanism.sections import PRESETS
from ...pages.page import Picture, Section, Table
from .claims import PaperClaim, Part, verdict
from .fig7_times import Fig7, fig7

__all__ = ["times"]

_FACTOR = 200.0  # in time: the bound that the claim states
_CLAIMED = (
    "20 linear elements in plain NumPy",
    "20 linear elements, solve",
    "one element of order 5, control step",
    "one element of order 5, batch, 1 core",
)


def times(seed: int = 0, n: int = 100, batch: int = 512, rounds: int = 2) -> Part:
    """Time every way to solve on `n` poses; of `rounds` rounds, in which the ways take turns, the fastest counts."""
    found = {
        preset: fig7(Mechanism.preset(preset), poses=n, seed=seed, batch=batch, rounds=rounds) for preset in PRESETS
    }
    claims = tuple(claim for preset in PRESETS for claim in _claims(preset, found[preset]))
    numbers = {preset: {"settings": dict(fig.settings), "rows": list(fig.rows)} for preset, fig in found.items()}
    scale = 1e6
    rows = tuple(
        (preset, row["way"], *(scale * row[key] for key in ("shortest_s", "median_s", "longest_s")), row["polynomials"])
        for preset, fig in found.items()
        for row in fig.rows
    )
    head = ("preset", "one solve", "shortest [µs]", "median [µs]", "longest [µs]", "over the polynomial")
    sentences = (
        "The paper times 100 random poses and finds its polynomial at least 200 times faster than its finite element "
        f"model. Here {n} random poses are solved by every way in turn; the plain program stands for what one writes "
        "without a compiler. Single calls are compared with a single call of the compiled polynomial, batches with its "
        "batch; what an empty call from Python takes is subtracted from single calls.",
        "; ".join(f"{name}: {value}" for name, value in found["slender"].settings.items() if name != "mechanism"),
    )
    table = Table("Time of one answer on this machine", head, rows)
    return Part(claims, numbers, Section("Computing time (Fig. 7)", sentences, (table,), _pictures(found)))


def _claims(preset: str, fig: Fig7) -> list[PaperClaim]:
    claims = []
    for row in fig.rows:
        if row["way"] in _CLAIMED:
            factor = row["polynomials"]
            ours, other = 1e6 * row["median_s"], 1e6 * row["median_s"] / factor
            claims.append(
                PaperClaim(
                    f"Fig. 7, preset {preset}: the polynomial is at least 200 times faster than the FEM, {row['way']}",
                    "at least 200 times",
                    f"{factor:.3g} times, {other:.2g} against {ours:.3g} µs",
                    verdict(_FACTOR, factor, f"a factor of {factor:.3g}"),
                )
            )
    return claims


def _pictures(figs: Mapping[str, Fig7]) -> tuple[Picture, ...]:
    pictures = []
    for preset, fig in figs.items():
        columns = {f"{name.replace(', ', '_').replace(' ', '_')}_s": np.asarray(taken).tolist()
                   for name, taken in fig.times.items()}  # fmt: skip
        caption = f"Fig. 7, preset {preset}: histograms of the time of one answer, on a logarithmic scale."
        pictures.append(Picture(f"times_{preset}", caption, fig.figure(), columns))
    return tuple(pictures)
