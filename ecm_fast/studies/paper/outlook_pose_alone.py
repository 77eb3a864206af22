"""The assumption that the tip pose alone determines the wrench, as the paper's outlook asks.

Along the axis of a given neck it does, as long as the beam between its two ends does not buckle. It fails where
something acts along the neck, or hangs on its head, that the polynomial was not trained with. The other way round,
from a wrench to the pose, it fails at the load at which the free neck buckles.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...mechanism.mechanism import Mechanism
from ...mechanism.sections import PRESETS
from ...models.finite_element import FiniteElementModel
from ...models.polynomial.model import PolynomialModel
from ...models.polynomial.training import relative_errors, tip_wrenches, training_poses
from ...pages.page import Picture, Section, Table
from ...pages.plots import COLORS, FAINT, MINUS, canvas, random_tendon_forces
from .claims import COMPONENTS, MM, NOT_GIVEN, PaperClaim, Part, by_channel, by_component, shown, verdict

__all__ = ["buckling", "holding", "pose_alone"]

Array = NDArray[np.float64]

_CHANGES: dict[str, dict[str, float]] = {
    "beam without weight": {"mass_per_length": 0.0},
    "beam twice as heavy": {"mass_per_length": 2.0 * Mechanism().beam.mass_per_length},
    "head 0.5 kg heavier": {"mass": 1.5},
    "tipped by 30 deg": {"gravity_tilt": np.pi / 6.0},
    "head's center of mass 10 mm to the side": {"b": 0.01},
}
_OFF_BOUND = 0.01  # share of the range: the bound that the claim states
_STEPS, _CONVERGED = 20, 1e-11  # Newton steps at most, and the relative misfit that ends them
_PUSH, _SIDE = 900.0, 1.0
"""Largest push, and the side force that decides where the neck yields to it [N]."""
_NAMES = ("fx", "fz", "τ")


def pose_alone(seed: int = 0, n: int = 300, pushes: int = 61) -> Part:
    """Hold the tip of changed necks at `n` poses that tendons reach, and push a slender one past its buckling load."""
    claims: list[PaperClaim] = []
    rows: list[tuple[str | float | None, ...]] = []
    numbers: dict[str, Any] = {}
    pictures = []
    for preset in PRESETS:
        lam = random_tendon_forces(n, seed)
        model = FiniteElementModel(Mechanism.preset(preset))
        poses = model.solve_batch(lam).pose
        nominal = tip_wrenches(model, poses, lam)
        off = {
            # to 1e-8 N and N m, beyond which Newton's method leaves its own error
            name: np.round(holding(model.mechanism.replace(**change), poses, nominal) - nominal, 8)
            for name, change in _CHANGES.items()
        }
        known = training_poses(model, 1000, seed)
        misfit = relative_errors(PolynomialModel.fit(known.poses, known.wrenches), known).rms
        claims += [_claim(preset, name, change, np.ptp(nominal, axis=0)) for name, change in off.items()]
        claims.append(_unique(preset, poses))
        rows += [_row(preset, name, change, np.ptp(nominal, axis=0)) for name, change in off.items()]
        numbers[preset] = _numbers(off, misfit)
        pictures.append(_picture(preset, poses, off))
    branches, critical = _pushed(pushes), buckling(Mechanism.preset("slender"), held=False)[0]
    claims.append(_two_poses(branches, critical))
    numbers["buckling"] = {"critical_load_N": critical, "largest_z_m": float(np.nanmax(branches["z_m"]))}
    pictures.append(_branch_picture(branches, critical))
    sentences = (
        "A polynomial from pose to wrench assumes that the pose of the tip is enough. To check this, the tip of a "
        "changed neck is held where the unchanged one stands, and the wrench that this takes is compared. A change "
        "that shows in it cannot be seen in the pose. What is left when the mean over all poses is subtracted is the "
        "part that no constant offset mends.",
        "Along its axis, one neck has several wrenches for one pose only where the beam buckles between its two held "
        "ends. Closed form: P (g + P/GA) = (2 pi/L)^2 EI, with the stretch g that P gives by (19); with (pi/2L)^2 it "
        "is the load at which the free neck buckles and one wrench has two poses.",
    )
    head = ("preset", "change", "largest fx [N]", "fz [N]", "tau [N m]", "of the range [%]", "rms less mean: fx [N]",
            "fz [N]", "tau [N m]")  # fmt: skip
    table = Table("By how much the wrench at the same pose changes", head, tuple(rows))
    section = Section("Does the pose alone fix the wrench?", sentences, (table,), tuple(pictures))
    return Part(tuple(claims), numbers, section)


def holding(neck: Mechanism, poses: Array, start: Array) -> Array:
    """Return the wrenches (n, 3) that hold the tip of a neck at poses (n, 3), by Newton's method from `start`."""
    model, wrench = FiniteElementModel(neck), start.copy()
    size = np.array([neck.beam.length, neck.beam.length, 1.0])
    for _ in range(_STEPS):
        solved = model.sensitivities([], np.zeros((len(poses), 2)), wrench, tolerance=1e-12)
        miss = poses - solved.pose
        wrench += np.linalg.solve(solved.compliance, miss[:, :, None])[:, :, 0]
        if np.abs(miss / size).max() < _CONVERGED:
            return wrench
    return np.full_like(wrench, np.nan)


def buckling(neck: Mechanism, *, held: bool) -> tuple[float, float]:
    """Return the end force [N] and the shortening [-] at which the weightless straight neck buckles.

    Parameters
    ----------
    held : the tip is held in place and angle; else it is free
    """
    from scipy.optimize import brentq

    beam = neck.beam
    wave = (2.0 if held else 0.5) * np.pi / beam.length

    def force(stretch: float) -> float:
        return beam.EA / 3.0 * (stretch**-2 - stretch)

    def excess(stretch: float) -> float:
        P = force(stretch)
        return float(P * (stretch + P / beam.GA) - wave**2 * beam.EI)

    stretch = float(brentq(excess, 1e-3, 1.0, xtol=1e-14))
    return force(stretch), 1.0 - stretch


def _claim(preset: str, name: str, off: Array, extent: Array) -> PaperClaim:
    share = np.abs(off).max(axis=0) / extent
    largest = ", ".join(
        f"{component} {value:.3g} {unit} ({part:.2%})"
        for component, unit, value, part in zip(_NAMES, ("N", "N", "N m"), np.abs(off).max(axis=0), share, strict=True)
    )
    return PaperClaim(
        f"Section 4.3, preset {preset}, {name}: the pose alone still fixes the wrench to 1 % of its range",
        "to be investigated",
        f"largest change {largest}",
        verdict(float(share.max()), _OFF_BOUND, f"{shown(float(share.max()), '.1%')} of the range"),
    )


def _unique(preset: str, poses: Array) -> PaperClaim:
    neck = Mechanism.preset(preset)
    force, shortening = buckling(neck, held=True)
    reached = 1.0 - float(poses[:, 0].min()) / neck.beam.length
    return PaperClaim(
        f"Section 4.3, preset {preset}: along the axis, no pose of the workspace has a second wrench",
        NOT_GIVEN,
        f"a held neck buckles at {shortening:.1%} shortening under {force:.0f} N; the workspace ends at {reached:.1%}",
        verdict(reached, shortening, f"{reached:.1%} shortening"),
    )


def _two_poses(branches: Mapping[str, Array], critical: float) -> PaperClaim:
    last = branches["fx_N"] == branches["fx_N"].min()
    apart = float(np.ptp(branches["z_m"][last])) * MM
    return PaperClaim(
        "Section 4.3, preset slender without weights: one wrench has one pose within the paper's box, fx to -330 N",
        NOT_GIVEN,
        f"beyond {critical:.0f} N there are two, {shown(apart, '.0f')} mm apart at {_PUSH:.0f} N",
        verdict(330.0, critical, f"a buckling load of {critical:.0f} N"),
    )


def _numbers(off: Mapping[str, Array], misfit: Array) -> dict[str, Any]:
    def named(values: Array) -> dict[str, float]:
        return dict(zip(COMPONENTS, values.tolist(), strict=True))

    changes = {
        name: {
            "largest": named(np.abs(change).max(axis=0)),
            "mean": named(change.mean(axis=0)),
            "rms_less_mean": named(np.round(change.std(axis=0), 8)),
        }
        for name, change in off.items()
    }
    return {"changes": changes, "rms_of_the_cubic_polynomial": named(misfit)}


def _row(preset: str, name: str, off: Array, extent: Array) -> tuple[str | float | None, ...]:
    largest = np.abs(off).max(axis=0)
    return (
        preset,
        name,
        *largest.tolist(),
        100.0 * float((largest / extent).max()),
        *np.round(off.std(axis=0), 8).tolist(),
    )


def _picture(preset: str, poses: Array, off: Mapping[str, Array]) -> Picture:
    theta = np.rad2deg(poses[:, 2])
    with canvas(7.2, 3.0) as figure:
        for i, axes in enumerate(figure.subplots(1, 3)):
            for (name, change), color in zip(off.items(), COLORS, strict=False):
                axes.plot(theta, change[:, i], ".", color=color, markersize=2.0, label=name, rasterized=True)
            axes.axhline(0.0, color=FAINT, linewidth=0.8)
            axes.set_xlabel("θ of the tip [deg]")
            axes.set_title(f"change of {_NAMES[i]} [{('N', 'N', 'N m')[i]}]")
            axes.grid(True)
        handles, labels = figure.axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2, markerscale=4.0)
    caption = (
        f"Preset {preset}: by how much the wrench changes that holds the tip at the same pose, when the weight of the "
        "beam or the head is not what it was."
    )
    columns: dict[str, Any] = dict(by_channel(poses))
    for name, change in off.items():
        columns |= by_component(change, f"{name.replace(' ', '_')}_change_of_")
    return Picture(f"pose_alone_{preset}", caption, figure, columns)


def _pushed(pushes: int) -> dict[str, Array]:
    """Return where the weightless slender neck goes under a growing push and a side force to either side."""
    neck = Mechanism.preset("slender").replace(mass_per_length=0.0, mass=0.0)
    push = np.linspace(0.0, _PUSH, pushes)
    wrench = np.zeros((2 * pushes, 3))
    wrench[:, 0], wrench[:, 1] = -np.tile(push, 2), np.repeat([_SIDE, -_SIDE], pushes)
    result = FiniteElementModel(neck).solve_batch(np.zeros((2 * pushes, 2)), wrench)
    return {**by_component(wrench), **by_channel(result.pose)}


def _branch_picture(branches: Mapping[str, Array], critical: float) -> Picture:
    with canvas(5.2, 3.2) as figure:
        axes = figure.subplots()
        for sign, color in ((1.0, COLORS[0]), (-1.0, COLORS[1])):
            chosen = branches["fz_N"] == sign * _SIDE
            label = f"side force {'+' if sign > 0 else MINUS}{_SIDE:g} N"
            axes.plot(-branches["fx_N"][chosen], branches["z_m"][chosen] * MM, color=color, label=label)
        axes.axvline(critical, color="black", linewidth=0.8, linestyle=":", label=f"closed form, {critical:.0f} N")
        axes.axvspan(0.0, 330.0, color=FAINT, alpha=0.15, linewidth=0.0, label="the paper's box")
        axes.set_xlabel("push along the axis [N]")
        axes.set_ylabel("z of the tip [mm]")
        axes.grid(True)
        axes.legend(loc="upper left")
    caption = (
        "Slender neck without weights: the same push has two poses beyond the buckling load; 1 N to the side decides "
        "which. A map from wrench to pose cannot hold both."
    )
    return Picture("pose_alone_buckling", caption, figure, branches)
