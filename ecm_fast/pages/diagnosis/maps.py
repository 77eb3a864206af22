"""Figures of the misfit row by row: in the workspace, over the loads, by symmetry, by path, as wrenches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...data.columns import CHANNEL_KEYS
from ...models.finite_element import FiniteElementModel
from ...models.instruments.checks.matched_rows import approach, load_table, match, mirrored
from ..page import Picture
from ..plots import CHANNELS_MRAD, COLORS, FAINT, canvas
from .rows import MANY, Story, map_points, row_columns

__all__ = ["loops", "parity_split", "residual_maps", "workspace", "wrench_arrows"]

Array = NDArray[np.float64]

_TIMES = 20.0  # magnification of misfits of some 0.1 mm
_NECKS = 5  # shapes drawn, evenly over the angle
_NEAR = 0.04  # share of the largest load within which two loads mirror each other
_LEAST = 1.0
"""[N], tendons that change less are off."""


def workspace(story: Story) -> Picture | None:
    """Measured tip positions with the error times 20, before and after; None where x or z was not measured."""
    rows, found = story.whole, story.found.rows
    if not rows.any() or not {0, 1} <= set(story.channels):
        return None
    x, z = 1e3 * story.pose[rows, 0], 1e3 * story.pose[rows, 1]
    with canvas(7.2, 3.3) as figure:
        grid = figure.subplots(1, 2, sharex=True, sharey=True)
        for axes, off, name in zip(grid, (found.before, found.after), ("before", "after"), strict=True):
            axes.plot(z, x, ".", color=FAINT, markersize=3.0, rasterized=z.size > MANY)
            dx, dz = (1e3 * _TIMES * off[rows, i] for i in (0, 1))
            axes.quiver(z, x, dz, dx, angles="xy", scale_units="xy", scale=1.0, width=0.003, color=COLORS[1],
                        rasterized=z.size > MANY)  # fmt: skip
            axes.update_datalim(np.column_stack([z + dz, x + dx]))
            axes.set_title(name)
            axes.set_xlabel("z [mm]")
            axes.grid(True)
        grid[0].set_ylabel("x [mm]")
        grid[0].autoscale_view()
        grid[0].invert_xaxis()
    columns = {
        **row_columns(story, rows),
        "x_m": story.pose[rows, 0],
        "z_m": story.pose[rows, 1],
        **{f"{name}_before_m": found.before[rows, i] for i, name in enumerate("xz")},
        **{f"{name}_after_m": found.after[rows, i] for i, name in enumerate("xz")},
    }
    caption = "Measured positions of the tip (dots) and how far measured lies from simulated, 20 times as long."
    return Picture("workspace", caption, figure, columns)


def residual_maps(story: Story) -> Picture | None:
    """Residuals over sum and difference of the tendon forces, before and after on one scale; None without tendons."""
    rows, found = story.whole, story.found.rows
    if not rows.any() or np.ptp(story.lam[rows], axis=0).max() < _LEAST:
        return None
    total, difference = story.lam[rows].sum(axis=1), story.lam[rows, 0] - story.lam[rows, 1]
    with canvas(7.2, 4.4) as figure:
        grid = figure.subplots(2, len(story.channels), sharex=True, sharey=True, squeeze=False)
        for i, channel in enumerate(story.channels):
            name, unit, scale = CHANNELS_MRAD[channel]
            values = [scale * off[rows, channel] for off in (found.before, found.after)]
            limit = float(np.quantile(np.abs(values[0]), 0.98)) or 1.0
            for axes, value in zip(grid[:, i], values, strict=True):
                map_points(axes, total, difference, value, limit)
                axes.grid(True)
            grid[0, i].set_title(f"{name}, ±{limit:.2g} {unit}")
            grid[1, i].set_xlabel("λl + λr [N]")
        grid[0, 0].set_ylabel("before\nλl − λr [N]")  # noqa: RUF001  a true minus sign
        grid[1, 0].set_ylabel("after\nλl − λr [N]")  # noqa: RUF001
    columns = {
        **row_columns(story, rows),
        **{f"{name}_{when}": off[rows, i] for when, off in (("before", found.before), ("after", found.after))
           for i, name in enumerate(CHANNEL_KEYS)},
    }  # fmt: skip
    caption = "What is left, measured less simulated, over sum and difference of the tendon forces; each channel has "
    caption += "one color scale for before and after, its ends above it: deep red measured more, deep blue less."
    return Picture("residual_maps", caption, figure, columns)


def parity_split(story: Story) -> Picture | None:
    """The gap before, split into what is alike on both sides and what differs; None without mirrored loads."""
    rows, found = story.whole, story.found.rows
    loads = np.concatenate([load_table(part) for part in story.data])[rows]
    if len(loads) < 2:
        return None
    pairs = match(mirrored(loads), loads, np.arange(len(loads)), _NEAR)
    if len(pairs) < 3:
        return None
    i, j = pairs.T
    swap = loads[i, 0] < loads[i, 1]
    i, j = np.where(swap, j, i), np.where(swap, i, j)
    sign = np.array([1.0, -1.0, -1.0])
    off = found.before[rows]
    even, odd = 0.5 * (off[i] + sign * off[j]), 0.5 * (off[i] - sign * off[j])
    total, difference = loads[i, 0] + loads[i, 1], np.abs(loads[i, 0] - loads[i, 1])
    with canvas(7.2, 4.2) as figure:
        grid = figure.subplots(2, len(story.channels), sharex=True, sharey=True, squeeze=False)
        for column, channel in enumerate(story.channels):
            name, unit, scale = CHANNELS_MRAD[channel]
            both = [scale * part[:, channel] for part in (even, odd)]
            limit = float(max(np.abs(part).max(initial=0.0) for part in both)) or 1.0
            for axes, value in zip(grid[:, column], both, strict=True):
                map_points(axes, total, difference, value, limit)
                axes.grid(True)
            grid[0, column].set_title(f"{name}, ±{limit:.2g} {unit}")
            grid[1, column].set_xlabel("λl + λr [N]")
        grid[0, 0].set_ylabel("alike on both sides\n|λl − λr| [N]")  # noqa: RUF001
        grid[1, 0].set_ylabel("left and right differ\n|λl − λr| [N]")  # noqa: RUF001
    columns = {"lam_sum_N": total, "lam_difference_N": difference}
    for word, part in (("even", even), ("odd", odd)):
        columns |= {f"{name}_{word}": part[:, k] for k, name in enumerate(CHANNEL_KEYS)}
    caption = f"The gap before, from {len(pairs)} pairs of mirrored loads: the part that is the same in the mirror "
    caption += "image, and the part that is not. Deep red and blue: the ends of the scale above."
    return Picture("parity", caption, figure, columns)


def loops(story: Story) -> Picture | None:
    """The gap in theta by the side from which each load was reached; None where no row has a side."""
    rows, found = story.whole, story.found.rows
    side = np.concatenate([approach(part) for part in story.data])
    rows = rows & (side != 0)
    if not rows.any() or 2 not in story.channels:
        return None
    with canvas(7.2, 2.8) as figure:
        grid = figure.subplots(1, 2, sharey=True)
        for axes, k, name in zip(grid, (0, 1), ("left", "right"), strict=True):
            for sign, color, word in ((1, COLORS[1], "reached rising"), (-1, COLORS[0], "reached falling")):
                part = rows & (side == sign)
                axes.plot(story.lam[part, k], 1e3 * found.before[part, 2], ".", color=color, markersize=4.0, label=word,
                          rasterized=int(part.sum()) > MANY)  # fmt: skip
            axes.set_xlabel(f"{name} tendon force [N]")
            axes.grid(True)
        grid[0].set_ylabel("gap in θ [mrad]")
        grid[1].legend()
    columns = {**row_columns(story, rows), "reached": side[rows], "theta_rad_before": found.before[rows, 2]}
    caption = (
        "The gap before, by the side from which λl − λr came to its value. Friction and hysteresis part the colors."  # noqa: RUF001
    )
    return Picture("loops", caption, figure, columns)


def wrench_arrows(story: Story) -> Picture | None:
    """The wrench at Q that would close the gap, on necks in a few poses; None where it is not known."""
    found = story.found.rows
    rows = story.whole & np.isfinite(found.wrench_before).all(axis=1)
    if not rows.any():
        return None
    model = FiniteElementModel(story.calibrated)
    places = np.flatnonzero(rows)
    order = places[np.argsort(story.pose[places, 2])]
    shown = order[np.unique(np.linspace(0, order.size - 1, _NECKS).round().astype(int))]
    most = max(float(np.hypot(*found.wrench_before[shown, :2].T).max()), 1e-9)
    length = 0.25e3 * story.mechanism.beam.length
    with canvas(7.2, 4.4) as figure:
        axes = figure.subplots()
        for i in shown:
            eq = model.solve(story.lam[i], path="ignore")
            if not eq.converged:
                continue
            x, z = 1e3 * eq.shape(40)[:, :2].T
            axes.plot(z, x, color=FAINT)
            for wrench, color in ((found.wrench_before[i], COLORS[1]), (found.wrench_after[i], COLORS[0])):
                fx, fz = wrench[:2] / most * length
                axes.annotate("", (z[-1] + fz, x[-1] + fx), (z[-1], x[-1]),
                              arrowprops={"arrowstyle": "->", "color": color})  # fmt: skip
            axes.annotate(f"{1e3 * found.wrench_before[i, 2]:.0f}", (z[-1], x[-1]), (0, 9), textcoords="offset points",
                          ha="center", fontsize=7.0, color=COLORS[1])  # fmt: skip
        axes.set_aspect("equal")
        axes.margins(0.12)
        axes.invert_xaxis()
        axes.set_xlabel("z [mm]")
        axes.set_ylabel("x [mm]")
        axes.grid(True)
    names = ("fx_N", "fz_N", "tau_Nm")
    columns = {
        **row_columns(story, rows),
        **{f"{name}_before": found.wrench_before[rows, k] for k, name in enumerate(names)},
        **{f"{name}_after": found.wrench_after[rows, k] for k, name in enumerate(names)},
    }
    caption = f"The wrench at the tip that would close the gap, before (red) and after (blue), in {shown.size} of the "
    caption += f"rows: the longest arrow is {most:.2g} N, the numbers are couples before in N mm."
    return Picture("wrenches", caption, figure, columns)
