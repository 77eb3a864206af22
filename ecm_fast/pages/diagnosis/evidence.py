"""Figures of the answer: hold-out error, evidence, look-alikes, calibration, residuals, stiffness, next loads."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...diagnosis import Plan
from ...diagnosis.results.next_loads import NextLoads
from ...mechanism.catalogue import CATALOGUE
from ...mechanism.parameters import find
from ...mechanism.sections import STIFFNESSES
from ...models.finite_element import FiniteElementModel
from ..page import Picture
from ..plots import CHANNELS_MRAD, COLORS, FAINT, canvas
from .rows import MANY, Story

__all__ = ["cosine_matrix", "evidence_bars", "gap_bar", "left_over", "parameter_profiles", "promise", "stiffness"]

Array = NDArray[np.float64]

_BARS = 16  # that a picture has room for
_REACH = 3.5  # standard deviations either way that a profile shows
_POSES = ((0.0, 0.0), (120.0, 0.0), (120.0, 120.0))  # tendon forces [N] of the straight, a bent and a compressed pose
_FORCE = 10.0  # [N] at the head


def gap_bar(story: Story) -> Picture | None:
    """Locked rows as given, before, after, floor; None where none were locked."""
    gaps = ([story.found.gap] if story.found.gap else []) + list(story.found.transfer)
    if not gaps:
        return None
    colors = {"as given": COLORS[4], "calibrated alone": COLORS[1], "with what was found": COLORS[0], "floor": FAINT}
    stages = [(gap.what, name, rms) for gap in gaps for name, rms in gap.stages.items()]
    with canvas(7.2, 0.5 + 0.28 * len(stages)) as figure:
        axes = figure.subplots()
        labels, place = [], 0.0
        for what, name, rms in stages:
            place -= 1.6 if name == "as given" else 1.0
            axes.barh(place, rms.sigma, 0.8, color=colors.get(name, COLORS[3]))
            low, high = rms.interval
            if np.isfinite([low, high]).all():
                axes.plot([low, high], [place, place], color="black", linewidth=1.2)
            labels.append((place, f"{name}, {what}" if name == "as given" else name))
        axes.set_yticks(*zip(*labels, strict=True))
        axes.set_xlabel("rms of what is left, in units of the noise")
        axes.grid(True, axis="x")
    columns: dict[str, Any] = {
        "rows": [what for what, _, _ in stages],
        "when": [name for _, name, _ in stages],
        **{f"rms_{key}": [getattr(rms, key) for _, _, rms in stages] for key in ("x", "z", "theta", "sigma")},
        "lower": [rms.interval[0] for _, _, rms in stages],
        "upper": [rms.interval[1] for _, _, rms in stages],
    }
    caption = (
        "The gap in rows that no step of the diagnosis has seen: of the mechanism as given, calibrated alone, with "
        "what was found, and what noise leaves; black: interval from resampled blocks of rows."
    )
    return Picture("gap", caption, figure, columns)


def evidence_bars(story: Story) -> Picture | None:
    """Evidence of the explanations tried, the set shaded; None where none was tried."""
    models = story.found.models
    if not models:
        return None
    size = len(models[0].names)
    shown = [model for model in models if len(model.names) == size][:_BARS]
    with canvas(7.2, 0.8 + 0.24 * len(shown)) as figure:
        axes = figure.subplots()
        for place, model in enumerate(shown):
            color = COLORS[0] if model.in_set else FAINT
            axes.barh(-place, max(model.evidence, 0.0), 0.75, color=color, alpha=0.4 if model.refused else 1.0)
            text = f"{model.evidence:.4g}" + (f"  refused: {model.refused}" if model.refused else "")
            axes.annotate(text, (max(model.evidence, 0.0), -place), (3, 0), textcoords="offset points", va="center",
                          fontsize=7.0)  # fmt: skip
        axes.set_yticks([-place for place in range(len(shown))], [" and ".join(model.names) for model in shown])
        axes.margins(x=0.25)
        axes.set_xlim(left=0.0)
        axes.set_xlabel("evidence: twice the logarithm over that of no effect")
    columns: dict[str, Any] = {
        "names": [" and ".join(model.names) for model in models],
        **{name: [getattr(model, name) for model in models] for name in ("evidence", "behind", "in_set")},
        "chi2_taken_off": [model.chi2 for model in models],
        "refused": [model.refused for model in models],
    }
    caption = (
        "The explanations that come nearest, each refitted together with EA, GA and EI. Blue ones the data cannot "
    )
    return Picture("evidence", f"{caption}tell from the best.", figure, columns)


def cosine_matrix(plan: Plan) -> Picture:
    """Cosines between signatures in these poses, effects of a group side by side."""
    groups = list(dict.fromkeys(CATALOGUE[name].group for name in plan.names))
    kept = [i for i in range(len(plan.names)) if np.abs(plan.cosines[i]).any()]
    order = sorted(kept, key=lambda i: groups.index(CATALOGUE[plan.names[i]].group))
    names = [plan.names[i] for i in order]
    values = plan.cosines[np.ix_(order, order)]
    with canvas(7.2, 6.6) as figure:
        figure.set_layout_engine("none")
        axes = figure.add_axes((0.2, 0.2, 0.72, 0.78))
        axes.imshow(values, cmap="RdBu_r", vmin=-1.0, vmax=1.0, interpolation="nearest")
        axes.set_xticks([])
        axes.set_yticks([])
        for place, name in enumerate(names):  # as ticks they would take longer than the rest of the page
            axes.text(-0.8, place, name, fontsize=4.5, ha="right", va="center")
            axes.text(place, len(names) - 0.2, name, fontsize=4.5, ha="center", va="top", rotation=90.0)
        last = ""
        for place, name in enumerate(names):
            if CATALOGUE[name].group != last and place:
                for line in (axes.axhline, axes.axvline):
                    line(place - 0.5, color="black", linewidth=0.4)
            last = CATALOGUE[name].group
    first, second = np.meshgrid(range(len(names)), range(len(names)), indexing="ij")
    columns = {
        "first": np.array(names)[first.ravel()],
        "second": np.array(names)[second.ravel()],
        "cosine": values.ravel(),
    }
    caption = (
        "How alike effects look in these very poses, once EA, GA and EI are refitted: deep red or deep blue alike, "
    )
    return Picture("cosines", f"{caption}white nothing in common. Lines part groups.", figure, columns)


def parameter_profiles(story: Story, priors: Mapping[str, tuple[float, float]]) -> Picture:
    """Uncertainty of EA, GA and EI before and after, against material tests."""
    names = [name for name in STIFFNESSES if name in story.found.calibration]
    columns: dict[str, list[Any]] = {"parameter": [], "when": [], "value": [], "rise": []}
    with canvas(7.2, 2.4) as figure:
        grid = figure.subplots(1, max(len(names), 1), squeeze=False, sharey=True)[0]
        for axes, name in zip(grid, names, strict=False):
            fits = (
                ("before", story.found.before[name], COLORS[1]),
                ("after", story.found.calibration[name], COLORS[0]),
            )
            for when, entry, color in fits:
                if not 0.0 < entry.std < np.inf:
                    continue
                value = entry.value + entry.std * np.linspace(-_REACH, _REACH, 61)
                rise = ((value - entry.value) / entry.std) ** 2
                axes.plot(value, rise, color=color, label=when)
                columns["parameter"] += [name] * value.size
                columns["when"] += [when] * value.size
                columns["value"] += value.tolist()
                columns["rise"] += rise.tolist()
            quantity = find(name)
            nominal, std = priors.get(name, (quantity.default, quantity.typical))
            axes.axvspan(nominal - std, nominal + std, color=FAINT, alpha=0.35, linewidth=0.0)
            axes.axvline(nominal, color=FAINT)
            _zoom(axes, story, name, nominal, std)
            axes.set_xlabel(f"{name} [{quantity.unit.replace('^2', '²')}]")
            axes.set_ylim(0.0, 9.0)
            axes.grid(True)
        grid[0].set_ylabel("rise of the sum of squares")
        grid[0].legend()
    source = "that was given" if priors else "of the paper's material tests"
    caption = f"EA, GA and EI before and after, as parabolas of their standard deviations; gray: the value {source}."
    return Picture("parameters", caption, figure, columns)


def _zoom(axes: Any, story: Story, name: str, nominal: float, std: float) -> None:
    """Show the fits and the material test; a fit that has run away stays outside."""
    ends = [nominal - 3.0 * std, nominal + 3.0 * std]
    for entry in (story.found.before[name], story.found.calibration[name]):
        if 0.3 * nominal < entry.value < 3.0 * nominal:
            reach = min(3.0 * entry.std, nominal)
            ends += [entry.value - reach, entry.value + reach]
    axes.set_xlim(min(ends), max(ends))


def left_over(story: Story) -> Picture | None:
    """Whitened residuals after: against the normal distribution, and in the order of measurement."""
    from scipy.special import ndtri

    rows = story.found.rows
    white = np.where(rows.used, rows.after, np.nan) / np.where(rows.sigma > 0.0, rows.sigma, np.nan)
    if not np.isfinite(white).any():
        return None
    columns: dict[str, list[Any]] = {"channel": [], "row": [], "residual_sigma": [], "normal": []}
    with canvas(7.2, 3.0) as figure:
        left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.7), sharey=True)
        for i, (name, _, _) in enumerate(CHANNELS_MRAD):
            known = np.flatnonzero(np.isfinite(white[:, i]))
            if not known.size:
                continue
            value = white[known, i]
            rank = np.empty(known.size)
            rank[np.argsort(value, kind="stable")] = (np.arange(known.size) + 0.5) / known.size
            normal = ndtri(rank)
            style = {"color": COLORS[i], "markersize": 3.0, "label": name, "rasterized": known.size > MANY}
            left.plot(normal, value, ".", **style)
            right.plot(known + 1, value, ".", **style)
            columns["channel"] += [name] * known.size
            columns["row"] += (known + 1).tolist()
            columns["residual_sigma"] += value.tolist()
            columns["normal"] += normal.tolist()
        left.plot([-3.0, 3.0], [-3.0, 3.0], color=FAINT, linewidth=0.8)
        left.set_xlabel("as many normal deviates")
        left.set_ylabel("left after [sigma]")
        right.set_xlabel("row in the order of measurement")
        right.axhline(0.0, color=FAINT, linewidth=0.8)
        right.legend(ncols=3, loc="upper right")
        for axes in (left, right):
            axes.grid(True)
    caption = (
        "What is left after, in units of the noise: on the line if it is normal; without a trend if nothing drifts."
    )
    return Picture("left_over", caption, figure, columns)


def stiffness(story: Story) -> Picture:
    """Compliance of the tip in every direction, before and after."""
    turn = np.linspace(0.0, 2.0 * np.pi, 73)
    force = _FORCE * np.stack([np.cos(turn), np.sin(turn)])
    columns: dict[str, list[Any]] = {"lam_l_N": [], "lam_r_N": [], "when": [], "dx_m": [], "dz_m": []}
    with canvas(7.2, 2.6) as figure:
        grid = figure.subplots(1, len(_POSES), sharex=True, sharey=True)
        for when, mechanism, color in (
            ("before", story.calibrated, COLORS[1]),
            ("after", story.found.mechanism, COLORS[0]),
        ):
            model = FiniteElementModel(mechanism)
            for axes, lam in zip(grid, _POSES, strict=True):
                eq = model.solve(lam, path="ignore")
                if not eq.converged:
                    continue
                dx, dz = eq.compliance[:2, :2] @ force
                axes.plot(1e3 * dz, 1e3 * dx, color=color, label=when)
                for name, values in zip(columns, ([lam[0]] * 73, [lam[1]] * 73, [when] * 73, dx, dz), strict=True):
                    columns[name] += list(values)
        for axes, lam in zip(grid, _POSES, strict=True):
            axes.set_title(f"λl {lam[0]:g} N, λr {lam[1]:g} N")
            axes.set_xlabel("z [mm]")
            axes.grid(True)
        grid[0].set_ylabel("x [mm]")
        grid[0].legend(loc="upper right")
        grid[0].invert_xaxis()
    caption = (
        f"Where a force of {_FORCE:g} N in every direction moves the tip, before and after: the long axis is soft."
    )
    return Picture("stiffness", caption, figure, columns)


def promise(suggested: NextLoads) -> Picture:
    """Gain of the next loads, and that of each add-on alone."""
    minutes = np.cumsum([0.0, *(entry.minutes for entry in suggested.suggestions)])
    sigma = np.array([suggested.worst_before, *(entry.promised_sigma for entry in suggested.suggestions)])
    with canvas(7.2, 2.6) as figure:
        left, right = figure.subplots(1, 2)
        left.plot(minutes, sigma, "o-", color=COLORS[0])
        left.axhline(4.0, color=FAINT, linewidth=0.8)
        left.set_xlabel("minutes on the test bed")
        left.set_ylabel("smallest distance in the set [sigma]")
        left.set_ylim(bottom=0.0)
        left.grid(True)
        right.barh(list(suggested.alone), list(suggested.alone.values()), color=COLORS[0])
        right.set_xlabel("after the best single load with it [sigma]")
        right.grid(True, axis="x")
    columns = {"minutes": minutes, "promised_sigma": sigma}
    caption = "What measuring next buys: the distance of the two explanations that are hardest to tell apart; 4 sigma "
    return Picture("next_loads", f"{caption}is enough for a name.", figure, columns)
