"""Figures: the deformed neck, its workspace, predictions against measurements, solve times.

Every function returns a matplotlib figure of its own, without pyplot and its global state. Matplotlib is optional and
imported when the first picture is drawn.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..kernels import layout as at
from ..kernels.general.pulleys import tendon_directions
from ..models.equilibrium import Equilibrium
from ..models.finite_element import FiniteElementModel
from ..models.instruments.prediction import Prediction

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

__all__ = [
    "CHANNELS_MRAD",
    "COLORS",
    "FAINT",
    "LARGEST_TENDON_FORCE",
    "MINUS",
    "canvas",
    "picture_bytes",
    "plot_residuals",
    "plot_shape",
    "plot_times",
    "plot_workspace",
    "random_tendon_forces",
    "shown_time",
]

Array = NDArray[np.float64]

LARGEST_TENDON_FORCE = 160.0
"""[N], the end of the range in the paper's Fig. 4."""

MINUS = "\N{MINUS SIGN}"
_MM, _DEG = 1e3, 180.0 / np.pi  # factors from m and rad to mm and deg
COLORS = ("#0b5394", "#c0392b", "#2e7d32", "#8e44ad", "#b9770e", "#117a8b", "#5d4037", "#ad1457")
FAINT = "#8a8f98"
CHANNELS_MRAD = (("x", "mm", _MM), ("z", "mm", _MM), ("θ", "mrad", 1e3))
"""Channels as pictures of small misfits have them: symbol, unit, factor."""
_CHANNELS = (("x", "mm", _MM), ("z", "mm", _MM), ("θ", "deg", _DEG))
_STYLE: Any = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "grid.color": "#d5d8dc",
    "grid.linewidth": 0.5,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
}


def random_tendon_forces(n: int = 1000, rng: int | np.random.Generator = 0) -> Array:
    """Return `n` pairs of tendon forces, evenly spread over 0..160 N as in the paper's Fig. 4, (n, 2) [N]."""
    return np.random.default_rng(rng).uniform(0.0, LARGEST_TENDON_FORCE, (n, 2))


def plot_shape(model: FiniteElementModel, equilibria: Equilibrium | Sequence[Equilibrium]) -> Figure:
    """Draw the neck in its plane: centerline, head plate, tendons to where they meet their pulleys, center of mass.

    Parameters
    ----------
    model : whose tendons and head are drawn
    equilibria : of that model, one color each

    Raises
    ------
    InputError : one of them is no equilibrium, or matplotlib is missing.
    """
    several = [equilibria] if isinstance(equilibria, Equilibrium) else list(equilibria)
    for i, eq in enumerate(several):
        if not eq.converged:
            raise InputError(f"equilibrium {i} cannot be drawn: {eq.message}")
    with canvas(5.2, 4.0 + 0.18 * len(several)) as figure:
        axes = figure.subplots()
        _plane(axes)
        _draw_base(axes, model, named=True)
        for i, eq in enumerate(several):
            _draw_neck(axes, model, eq, COLORS[i % len(COLORS)])
        _mirror(axes)
        if several:
            figure.legend(loc="outside lower center")
        return figure


def plot_workspace(model: FiniteElementModel, n: int = 1000, rng: int | np.random.Generator = 0) -> Figure:
    """Draw where the tip can go, the paper's Fig. 4: tip poses for random tendon forces 0..160 N, with a close-up.

    Effects of the path are left out.

    Parameters
    ----------
    model : of the neck
    n : how many pairs of tendon forces
    rng : seed or generator of the forces, see `random_tendon_forces`

    Raises
    ------
    InputError : matplotlib is missing.
    """
    pose = model.solve_batch(random_tendon_forces(n, rng), path="ignore").pose
    x, z, theta = (pose * [_MM, _MM, _DEG]).T
    with canvas(7.2, 3.4) as figure:
        whole, close = figure.subplots(1, 2, width_ratios=(1.0, 1.35))
        _plane(whole)
        _draw_base(whole, model)
        _draw_neck(whole, model, model.solve(path="ignore"), FAINT)
        # a thousand vector circles would weigh more than the rest of a report
        whole.plot(z, x, ".", color=COLORS[0], markersize=1.5, rasterized=True, label="tip poses")
        _mirror(whole)
        whole.set_title("neck at rest and tip poses")
        limit = float(np.abs(theta[np.isfinite(theta)]).max(initial=1e-9))
        dots = close.scatter(z, x, c=theta, s=4.0, cmap=_diverging(), vmin=-limit, vmax=limit, rasterized=True)
        _plane(close, equal=False)
        _mirror(close)
        close.set_title("close-up, x stretched")
        figure.colorbar(dots, ax=close, label="θ [deg]", shrink=0.9)
        return figure


def plot_residuals(prediction: Prediction) -> Figure:
    """Draw measured against predicted, and below it what is left, for every channel that was measured.

    Raises
    ------
    InputError : no row has a measured channel and a prediction, or matplotlib is missing.
    """
    known = np.isfinite(prediction.residual)
    shown = [i for i in range(len(_CHANNELS)) if known[:, i].any()]
    if not shown:
        raise InputError(f"{prediction.data.source}: nothing to draw, no row has a measured pose and a prediction")
    with canvas(max(3.4, 2.6 * len(shown)), 4.0) as figure:
        grid = figure.subplots(2, len(shown), squeeze=False, sharex="col", height_ratios=(2.0, 1.0))
        for (top, bottom), i in zip(grid.T, shown, strict=True):
            name, unit, scale = _CHANNELS[i]
            predicted, residual = (a[known[:, i], i] * scale for a in (prediction.pose, prediction.residual))
            _draw_residuals(top, bottom, predicted, residual, name, unit)
        return figure


def plot_times(times: Mapping[str, Array]) -> Figure:
    """Draw histograms of times, the paper's Fig. 7: one below the other, on one logarithmic axis.

    Parameters
    ----------
    times : by what took them, (n,) each [s]

    Raises
    ------
    InputError : matplotlib is missing.
    """
    every = np.concatenate(list(times.values()))
    edges = np.geomspace(0.8 * every.min(), 1.25 * every.max(), 140)
    with canvas(7.2, 0.6 + 0.36 * len(times)) as figure:
        rows = figure.subplots(len(times), 1, sharex=True, squeeze=False)[:, 0]
        for i, (axes, (name, seconds)) in enumerate(zip(rows, times.items(), strict=True)):
            axes.hist(seconds, edges, color=COLORS[i % len(COLORS)])
            axes.set_xscale("log")
            axes.tick_params(which="both", left=False, labelleft=False, bottom=axes is rows[-1])
            axes.spines["left"].set_visible(False)
            axes.set_ylabel(name, rotation=0.0, ha="right", va="center")
            axes.text(1.0, 0.5, shown_time(float(np.median(seconds))), transform=axes.transAxes, ha="left", va="center")
            axes.grid(True, axis="x")
        rows[0].set_title("median", loc="right")
        rows[-1].set_xlabel("time of one solve [s]")
        return figure


def picture_bytes(figure: Figure, kind: Literal["svg", "png"]) -> bytes:
    """Return a figure as the content of a file; the same picture, drawn anew, gives the same bytes."""
    import matplotlib

    content = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "ecm-fast", "svg.fonttype": "none"}):
        figure.savefig(content, format=kind, dpi=200, metadata={"Date": None} if kind == "svg" else None)
    return content.getvalue()


@contextmanager
def canvas(width: float, height: float, remark: str = "") -> Iterator[Figure]:
    """Give a figure of `width` by `height` inches; what is drawn in the block has the style of the package.

    A `remark` stands above everything, in a color that is not overlooked.
    """
    try:
        import matplotlib
        from matplotlib.figure import Figure
    except ImportError:
        raise InputError("a picture needs matplotlib: pip install 'ecm-fast[plots]'") from None
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        if remark:
            figure.suptitle(remark, color=COLORS[1], fontsize=9.0, fontweight="bold")
        yield figure


def _plane(axes: Axes, *, equal: bool = True) -> None:
    """Label the axes of the plane: x up, z to the left, so that the left tendon is on the left."""
    axes.set_xlabel("z [mm]")
    axes.set_ylabel("x [mm]")
    axes.grid(True)
    if equal:
        axes.set_aspect("equal")


def _mirror(axes: Axes) -> None:
    """Make the z axis symmetric, growing to the left."""
    limit = max(abs(bound) for bound in axes.get_xlim())
    axes.set_xlim(limit, -limit)


def _diverging() -> Colormap:
    """Return a map from blue over dark gray to red: matplotlib's own are lost on white paper in the middle."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("signed angle", [COLORS[0], "#3f444b", COLORS[1]])


def _draw_base(axes: Axes, model: FiniteElementModel, *, named: bool = False) -> None:
    """Draw the clamp and both pulleys, and write which is which."""
    from matplotlib.patches import Circle

    tip = model.tip
    width = 0.15 * tip[at.T_LENGTH] * _MM
    axes.plot([-width, width], [0.0, 0.0], color="black", linewidth=3.0, solid_capstyle="butt")
    pulleys = {"left": (at.T_PULLEY_LX, at.T_PULLEY_LZ), "right": (at.T_PULLEY_RX, at.T_PULLEY_RZ)}
    for name, place in pulleys.items():
        x, z, radius = tip[place[0]] * _MM, tip[place[1]] * _MM, abs(tip[at.T_REACH_L]) * _MM
        axes.add_patch(Circle((z, x), radius, fill=False, color="black", linewidth=0.8))
        axes.plot(z, x, "o", color="black", markersize=2.0)
        if named:
            axes.margins(y=0.09)  # room for the names
            axes.annotate(name, (z, x - radius), (0, -4), textcoords="offset points", ha="center", va="top")


def _draw_neck(axes: Axes, model: FiniteElementModel, eq: Equilibrium, color: str) -> None:
    tip = model.tip
    s, c = np.sin(eq.theta), np.cos(eq.theta)
    e_lx, e_lz, free_l, e_rx, e_rz, free_r, l_x, l_z, r_x, r_z = tendon_directions(tip, eq.x, eq.z, s, c)
    com = np.array([tip[at.T_COM_X] * c + tip[at.T_COM_Z] * s, tip[at.T_COM_Z] * c - tip[at.T_COM_X] * s])
    q = np.array([eq.x, eq.z])
    left, right = q + np.array([l_x, l_z]), q + np.array([r_x, r_z])

    def line(points: Any, **style: Any) -> None:
        x, z = np.asarray(points).T
        axes.plot(z * _MM, x * _MM, **{"color": color, **style})

    line(
        eq.shape(60)[:, :2],
        linewidth=2.2,
        label=f"tip at x {eq.x * _MM:.1f} mm, z {_signed(eq.z * _MM)} mm, θ {_signed(eq.theta * _DEG)}°",
    )
    line([left, right], linewidth=3.0)
    line([left, left + free_l * np.array([e_lx, e_lz])], linewidth=0.8)
    line([right, right + free_r * np.array([e_rx, e_rz])], linewidth=0.8)
    if tip[at.T_WEIGHT_X] != 0.0 or tip[at.T_WEIGHT_Z] != 0.0:
        line([q, q + com], linewidth=0.8, linestyle=":")
        line([q + com], marker="o", markersize=5.0, markerfacecolor="white")


def _signed(value: float) -> str:
    """Return one decimal with a true minus sign, and no minus before a zero."""
    return f"{round(value, 1) + 0.0:.1f}".replace("-", MINUS)


def _draw_residuals(top: Axes, bottom: Axes, predicted: Array, residual: Array, name: str, unit: str) -> None:
    measured = predicted + residual
    ends = [min(predicted.min(), measured.min()), max(predicted.max(), measured.max())]
    top.plot(ends, ends, color=FAINT, linewidth=0.8, label="equal")
    top.plot(predicted, measured, "o", color=COLORS[0], markersize=4.0, label="rows")
    top.set_ylabel(f"measured {name} [{unit}]")
    top.set_title(f"{name}: rms {np.sqrt(np.mean(residual**2)):.2g} {unit}")
    bottom.axhline(0.0, color=FAINT, linewidth=0.8)
    bottom.vlines(predicted, 0.0, residual, color=COLORS[1], linewidth=1.0)
    bottom.plot(predicted, residual, "o", color=COLORS[1], markersize=4.0)
    bottom.set_ylabel(f"measured {MINUS}\npredicted [{unit}]")
    bottom.set_xlabel(f"predicted {name} [{unit}]")
    for axes in (top, bottom):
        axes.grid(True)
        axes.margins(0.08)


def shown_time(seconds: float) -> str:
    """Return a time with three digits and the unit that suits it."""
    for unit, size in (("ns", 1e-9), ("us", 1e-6), ("ms", 1e-3)):
        if seconds < 999.5 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"
