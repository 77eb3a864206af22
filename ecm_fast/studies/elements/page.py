"""The page of an element study: figures, tables, and the numbers as JSON."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...files import csv_text, write_whole
from ...pages.page import Picture, Section, Table, write_report
from ...pages.plots import COLORS, canvas
from .answer import ASKED, answer, by_kind, counts_needed
from .errors import LARGEST_TENDON_FORCE, error_maps, short
from .study import ElementStudy, Measured

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["plot_elements", "plot_error_maps", "summary", "write_study"]

Array = NDArray[np.float64]
_LOADS = ("lam_l_N", "lam_r_N", "fx_N", "fz_N", "tau_Nm")
_MESHES = {"even": "o", "graded to the clamp": "v", "graded to the soft spot": "v", "ending at jumps": "s"}
_MAPS = ("one cubic element", "one quintic element", "20 linear elements", "20 SE(2) elements")


def write_study(study: ElementStudy, folder: Path) -> Path:
    """Write ``elements.html``, ``elements.json``, a table ``elements.csv`` and the numbers of the pictures.

    Raises
    ------
    InputError : a file cannot be written, or matplotlib or jinja2 is missing.
    """
    content = summary(study)
    write_whole(folder / "elements.json", json.dumps(content, indent=1, allow_nan=False) + "\n")
    write_whole(folder / "elements.csv", csv_text(_columns(study)))
    drawn = [row for row in study.rows if math.isfinite(row.error)]
    pictures = (
        Picture(
            "element_errors",
            "Largest error of the tip over the load cases against time and against unknowns. Circles: equal elements, "
            "triangles: graded, squares: ending where the stiffness jumps. A ring marks those that none beats in both.",
            plot_elements(study),
            {
                "name": [row.candidate.name for row in drawn],
                **{name: [getattr(row, name) for row in drawn] for name in ("time", "unknowns", "error")},
            },
        ),
        _maps(study),
    )
    sections = [
        Section("", _sentences(study)),
        Section("How far the number of elements can be reduced", answer(study), (_needed_table(study),), pictures),
        Section("All that was compared", (), (_table(study),)),
    ]
    return write_report(folder / "elements.html", "How few elements suffice", sections)


def summary(study: ElementStudy) -> dict[str, Any]:
    """Return the study as JSON holds it; what is not finite is None."""
    best, known = study.recommended, study.known
    return {
        "loads": known.loads.name,
        "cases": len(known.loads),
        "dropped": known.dropped,
        "converged": {"order": 6, "elements": known.elements, "error": known.error},
        "tolerance": study.tolerance,
        "sentence": study.sentence,
        "recommended": None if best is None else _row(best),
        "front": [row.candidate.name for row in study.front],
        "needed": {
            kind: dict(zip(map(short, ASKED), counts, strict=True)) for kind, counts in counts_needed(study).items()
        },
        "answer": answer(study),
        "candidates": [_row(row) for row in study.rows],
    }


def _row(row: Measured) -> dict[str, Any]:
    candidate = row.candidate
    return {
        **{name: getattr(candidate, name) for name in ("name", "family", "order", "gauss", "mesh", "elements")},
        "shares": None if candidate.mesh == "even" else [length / sum(candidate.shares) for length in candidate.shares],
        "unknowns": row.unknowns,
        **{name: _finite(getattr(row, name)) for name in ("error", "median", "position")},
        "worst": dict(zip(_LOADS, row.worst, strict=True)),
        "failed": row.failed,
        "time_s": row.time,
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _columns(study: ElementStudy) -> dict[str, list[Any]]:
    """Return the table, one row a candidate, by column."""
    rows = [{key: value for key, value in _row(row).items() if key != "shares"} for row in study.rows]
    flat = [{**row, **{f"worst_{name}": load for name, load in row.pop("worst").items()}} for row in rows]
    front = {row.candidate for row in study.front}
    columns = {key: [row[key] for row in flat] for key in flat[0]}
    return {**columns, "front": [int(row.candidate in front) for row in study.rows]}


def _needed_table(study: ElementStudy) -> Table:
    rows = tuple((kind, *counts) for kind, counts in counts_needed(study).items())
    head = ("elements", *(f"for {short(asked)}" for asked in ASKED))
    return Table("How many equal elements it takes; a dash: more than were tried", head, rows)


def _sentences(study: ElementStudy) -> tuple[str, ...]:
    known, jumps = study.known, any(row.candidate.mesh == "ending at jumps" for row in study.rows)
    dropped = f" {known.dropped} more hold the neck in no stable pose and are left out." if known.dropped else ""
    spot = (
        ("The stiffness jumps where the soft spot begins and ends. Where an element spans a jump, its higher order "
         "gains little; elements that end there get it back.",)
        if jumps
        else ()
    )  # fmt: skip
    return (
        f"For {study.tolerance:g}: {study.sentence}.",
        f"Errors are the largest of x/L, z/L and theta over {len(known.loads)} load cases ({known.loads.name}), "
        f"against {known.elements} elements of order 6, from which half as many differ by {known.error:.0e}.{dropped}",
        *spot,
        "Times are of one solve in a batch on one core, from the straight beam: the least of a few short repetitions, "
        "all candidates in turn.",
    )


def _table(study: ElementStudy) -> Table:
    front = {row.candidate for row in study.front}
    rows = tuple(
        (
            row.candidate.name, row.unknowns, _finite(row.error), _finite(row.median), row.time * 1e6,
            ", ".join(f"{load:.3g}" for load in row.worst), "none beats it" if row.candidate in front else "",
        )
        for row in study.rows
    )  # fmt: skip
    head = ("candidate", "unknowns", "largest error", "median", "time [us]", "worst at lam_l, lam_r, fx, fz, tau", "")
    return Table("All candidates", head, rows)


def plot_elements(study: ElementStudy) -> Figure:
    """Draw errors against time and against unknowns, both axes logarithmic, with the Pareto front marked."""
    with canvas(7.6, 4.8) as figure:
        axes = figure.subplots(1, 2, sharey=True)
        for i, (kind, rows) in enumerate(by_kind(study).items()):
            for place, name in zip(axes, ("time", "unknowns"), strict=True):
                _draw_kind(place, rows, name, kind, i)
        front = study.front
        axes[0].plot([row.time * 1e6 for row in front], [row.error for row in front], "o", color="black",
                     markersize=9.0, fillstyle="none", label="none beats it")  # fmt: skip
        for place, label in zip(axes, ("time of one solve [µs]", "unknowns"), strict=True):
            place.set_xscale("log")
            place.set_yscale("log")
            for axis in (place.xaxis, place.yaxis):  # plain digits: powers are set as formulas, which takes a second
                axis.set_major_formatter("{x:g}")
                axis.set_minor_formatter("")
            place.set_xlabel(label)
            place.axhline(study.tolerance, color="black", linewidth=0.8, linestyle=":")
            place.grid(True)
        axes[0].set_ylabel("largest error of x/L, z/L, θ")
        handles, names = axes[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=3)
        return figure


def _draw_kind(axes: Axes, rows: list[Measured], name: str, kind: str, place: int) -> None:
    known = [row for row in rows if 0.0 < row.error < math.inf]
    line = "-" if place < len(COLORS) else "--"
    scale = 1e6 if name == "time" else 1
    for mesh, marker in _MESHES.items():
        of_mesh = [row for row in known if row.candidate.mesh == mesh]
        if of_mesh:
            even = mesh == "even"
            axes.plot(
                [getattr(row, name) * scale for row in of_mesh],
                [row.error for row in of_mesh],
                marker=marker,
                color=COLORS[place % len(COLORS)],
                markersize=3.5,
                linestyle=line if even else "none",
                linewidth=0.8,
                label=kind if even else "_",  # no entry in the legend
            )


def _maps(study: ElementStudy) -> Picture:
    best = [] if study.recommended is None else [study.recommended]
    shown = dict.fromkeys([*best, *(row for row in study.rows if row.candidate.name in _MAPS)])
    chosen = [row.candidate for row in shown]
    lam, maps = error_maps(study.mechanism, chosen)
    numbers = {"lam_l_N": lam[:, 0], "lam_r_N": lam[:, 1]}
    numbers |= {candidate.name: column for candidate, column in zip(chosen, maps.T, strict=True)}
    caption = (
        "Error of the tip over both tendon forces: where in the workspace each is worst. Colors are powers of ten."
    )
    return Picture("element_error_maps", caption, plot_error_maps(lam, maps, list(numbers)[2:]), numbers)


def plot_error_maps(lam: Array, maps: Array, names: list[str]) -> Figure:
    """Draw errors over the tendon forces, one panel a candidate.

    lam : (n, 2) [N], maps : (n, k), names : (k,)
    """
    from matplotlib.colors import LogNorm

    with canvas(7.6, 2.6 * math.ceil(len(names) / 2)) as figure:
        panels = figure.subplots(math.ceil(len(names) / 2), 2, squeeze=False).ravel()
        for axes, name, column in zip(panels, names, maps.T, strict=False):
            size = np.maximum(column, 1e-15)
            finite = size[np.isfinite(size)]
            lowest, highest = np.quantile(finite, 0.02), finite.max()
            norm = LogNorm(lowest, max(highest, 1.01 * lowest))
            dots = axes.scatter(*lam.T, c=size, s=15.0, marker="s", norm=norm, linewidths=0.0, rasterized=True)
            axes.set_title(f"{name}, largest {short(float(highest))}")
            axes.set_xlim(0.0, LARGEST_TENDON_FORCE)
            axes.set_ylim(0.0, LARGEST_TENDON_FORCE)
            axes.set_aspect("equal")
            axes.set_xlabel("left tendon [N]")
            axes.set_ylabel("right tendon [N]")
            figure.colorbar(dots, ax=axes, format="%g")
        for axes in panels[len(names) :]:
            axes.set_axis_off()
        return figure
