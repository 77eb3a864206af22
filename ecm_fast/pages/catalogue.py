"""The page of the catalogue: each effect with its law, signature and look-alikes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..data.measurements import Measurements
from ..diagnosis import Plan
from ..identification.rows import FitRows, FitSet
from ..mechanism.catalogue import CATALOGUE, Effect
from ..mechanism.mechanism import Mechanism
from ..mechanism.parameters import index
from ..mechanism.vector import pack
from .page import Picture, Section, Table, write_report
from .plots import CHANNELS_MRAD, COLORS, FAINT, canvas

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["look_alikes", "signatures", "sweep", "write_catalogue"]

Array = NDArray[np.float64]

_SIDE = 9  # points a side of the grid of tendon forces
_SHOWN = 4  # look-alikes that a row has room for
_ALIKE = 0.7  # cosine from which signatures are called alike


def sweep(lam_max: float = 160.0) -> Measurements:
    """Return an even grid of tendon forces [N], the left one to and fro as a person would go through it."""
    level = np.linspace(0.0, lam_max, _SIDE)
    left = np.concatenate([level if i % 2 == 0 else level[::-1] for i in range(_SIDE)])
    n = _SIDE**2
    columns = {"lam_l_N": left, "lam_r_N": np.repeat(level, _SIDE)}
    return Measurements.from_columns({**columns, "t_s": 15.0 * np.arange(n), "dwell_s": np.full(n, 10.0)}, "sweep")


def signatures(mechanism: Mechanism, data: Measurements, effects: Sequence[Effect]) -> Array:
    """Return the change of every reading by a typical size of each effect, (k, n, 3) [m, m, rad]."""
    from ..mechanism.mesh.discretization import Discretization

    rows = FitRows(
        [FitSet(mechanism, data)], [effect.size.key for effect in effects], Discretization.from_elements(1, 5)
    )
    par = pack(mechanism)
    by = rows.at(np.array([par[index(effect.size.key)] for effect in effects])).by
    typical = np.array([effect.size.typical for effect in effects])
    return np.moveaxis(by * typical, 2, 0)


def look_alikes(plan: Plan, least: float = _ALIKE) -> dict[str, list[tuple[str, float]]]:
    """Return for every effect the names whose signatures are most alike, with the cosine, EA, GA, EI projected out."""
    out = {}
    for i, name in enumerate(plan.names):
        cosine = plan.cosines[i].copy()
        cosine[i] = 0.0
        order = np.argsort(-np.abs(cosine))[:_SHOWN]
        out[name] = [(plan.names[j], float(cosine[j])) for j in order if abs(cosine[j]) >= least]
    return out


def write_catalogue(mechanism: Mechanism, folder: Path, plan: Plan, source: str = "") -> Path:
    """Write ``effects.html`` and the numbers of its pictures; return the page.

    Parameters
    ----------
    mechanism : on which the effects are shown
    folder : for the files
    found : what loads can show
    source : where these loads come from; empty for a grid of tendon forces

    Raises
    ------
    InputError : a file cannot be written, or matplotlib or jinja2 is missing.
    """
    grid = sweep()
    alike = look_alikes(plan)
    sections = [Section("", _sentences(plan, source))]
    groups = dict.fromkeys(effect.group for effect in CATALOGUE.values())
    for group in groups:
        effects = [effect for effect in CATALOGUE.values() if effect.group == group]
        shapes = signatures(mechanism, grid, effects)
        picture = Picture(
            "signature_" + "".join(c if c.isalnum() else "_" for c in group),
            "What a typical size of each effect does to x, z and θ over the sum (to the right) and the difference "
            "(up) of the tendon forces, 0 to 160 N; blue less, red more, each map on its own scale.",
            _figure(effects, grid, shapes),
            _columns(effects, grid, shapes),
        )
        sections.append(Section(group, (), (_table(effects, plan, alike),), (picture,)))
    return write_report(folder / "effects.html", "Physical effects the model can take in", sections)


def _sentences(plan: Plan, source: str) -> tuple[str, ...]:
    counts = {visible: len(plan.effects_that_are(visible)) for visible in ("named", "seen", "absorbed", "invisible")}
    where = f"the {plan.rows} rows of {source}" if source else f"{plan.rows} tendon forces between 0 and 160 N"
    return (
        f"{len(CATALOGUE)} effects. With {where}, {plan.noise}: {counts['named']} would be named at their typical "
        f"size, {counts['seen']} seen but not told from look-alikes, {counts['absorbed']} absorbed by EA, GA and EI, "
        f"{counts['invisible']} invisible.",
        "Look-alikes: cosine between the signatures in all readings once EA, GA and EI are refitted; 1 or -1 is the "
        "same pattern. Size found: the smallest size that is found nine times in ten.",
    )


def _table(effects: Sequence[Effect], plan: Plan, alike: dict[str, list[tuple[str, float]]]) -> Table:
    sights = {sight.name: sight for sight in plan.sights}
    rows: list[tuple[str | float | None, ...]] = []
    for effect in effects:
        unit = "" if effect.size.unit == "-" else f" {effect.size.unit}"
        sight = sights.get(effect.name)
        smallest = None if sight is None else sight.smallest
        others = ", ".join(f"{name} {cosine:.2f}" for name, cosine in alike.get(effect.name, []))
        needs = f"; needs {', '.join(effect.needs)}" if effect.needs else ""
        what = f"{effect.size.meaning}: {effect.law}{needs}"
        seen = "" if sight is None else sight.visible
        rows.append((effect.name, what, f"{effect.size.typical:g}{unit}", effect.mirror, seen, smallest, others))
    return Table("", ("name", "what it is, and its law", "typical", "mirror", "seen", "size found", "look-alikes"),
                 tuple(rows))  # fmt: skip


def _figure(effects: Sequence[Effect], grid: Measurements, shapes: Array) -> Figure:
    total, difference = grid.lam_l + grid.lam_r, grid.lam_l - grid.lam_r
    order = np.lexsort((grid.lam_l, grid.lam_r))
    u, v = (values[order].reshape(_SIDE, _SIDE) / (2.0 * np.abs(values).max()) for values in (total, difference))
    with canvas(7.2, 0.35 + 0.62 * len(effects)) as figure:
        axes = figure.subplots()
        for row, shape in enumerate(shapes):
            for channel, (name, unit, scale) in enumerate(CHANNELS_MRAD):
                values = shape[order, channel].reshape(_SIDE, _SIDE) * scale
                size = float(np.nanmax(np.abs(values), initial=0.0))
                place = 3.0 + 2.0 * channel
                if size > 0.0:
                    axes.pcolormesh(place + 2.0 * u, 0.9 * v - row, values, cmap="RdBu_r", vmin=-size, vmax=size,
                                    shading="gouraud", rasterized=True)  # fmt: skip
                axes.text(place + 1.05, -row - 0.4, f"{name} {size:.2g} {unit}", fontsize=7.0, color=FAINT)
            axes.text(0.0, -row, effects[row].name, va="center", color=COLORS[0])
        axes.set_xlim(0.0, 9.0)
        axes.set_ylim(0.55 - len(effects), 0.55)
        axes.set_axis_off()
        return figure


def _columns(effects: Sequence[Effect], grid: Measurements, shapes: Array) -> dict[str, Any]:
    pose = shapes.reshape(-1, 3)
    return {
        "effect": np.repeat([effect.name for effect in effects], grid.n),
        "lam_l_N": np.tile(grid.lam_l, len(effects)),
        "lam_r_N": np.tile(grid.lam_r, len(effects)),
        "dx_m": pose[:, 0],
        "dz_m": pose[:, 1],
        "dtheta_rad": pose[:, 2],
    }
