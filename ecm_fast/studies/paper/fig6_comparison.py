"""Fig. 6 of the paper: both models on simulated data of the neck, with and without a missing effect."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data.datasets import load
from ...data.measurements import Measurements
from ...mechanism.sections import PRESETS
from ...models.finite_element import FiniteElementModel
from ...models.instruments.prediction import predict
from ...models.polynomial.model import PolynomialModel
from ...models.polynomial.training import measured_wrenches, training_poses
from ...pages.page import Picture, Section, Table
from ...pages.plots import COLORS, FAINT, canvas
from ...testbed import Sensors, measure
from .claims import (
    CHANNEL_KEYS,
    COMPONENTS,
    DEG,
    MM,
    NOT_PUBLIC,
    SIMULATED,
    PaperClaim,
    Part,
    by_channel,
    by_component,
    verdict,
)

__all__ = ["Errors", "comparison", "errors"]

Array = NDArray[np.float64]

_FEM = {"x": 4.7, "z": 2.6, "theta": 1.8}
_POLYNOMIAL = {"fx": 9.4, "fz": 11.6, "tau": 9.7}
"""Errors [%] of the measured workspace and of the measured wrenches (Section 4.1)."""
_BENT = 0.2
"""[1/m] curvature at rest that the models do not know of."""
_LIKE, _UNLIKE = "as the model", "precurved"


@dataclass(frozen=True)
class Errors:
    """Misfit that is left of the measurements.

    Attributes
    ----------
    pose : (n, 3) measured less predicted by the finite element model [m, m, rad]
    wrench : (n, 3) of tendons and loads at the measured pose, less what the polynomial predicts [N, N, N m]
    workspace, wrenches : (3,) extent of what was measured
    data : the measurements
    """

    pose: Array
    wrench: Array
    workspace: Array
    wrenches: Array
    data: Measurements

    def shares(self) -> dict[str, Array]:
        """Return rms and largest errors as shares of the extent, (2, 3) by model."""
        both = {"FEM": (self.pose, self.workspace), "polynomial": (self.wrench, self.wrenches)}
        return {
            name: np.array([np.sqrt(np.mean(error**2, axis=0)), np.abs(error).max(axis=0)]) / extent
            for name, (error, extent) in both.items()
        }


def comparison(seed: int = 0, n: int = 1000) -> Part:
    """Predict simulated measurements of both presets with both models, which know nothing of a bend at rest."""
    found = {preset: _both(preset, seed, n) for preset in PRESETS}
    claims: list[PaperClaim] = []
    rows: list[tuple[str | float | None, ...]] = []
    for preset, cases in found.items():
        for case, entry in cases.items():
            claims += _claims(preset, case, entry)
            rows += _rows(preset, case, entry)
    numbers = {preset: {case: _numbers(entry) for case, entry in cases.items()} for preset, cases in found.items()}
    sentences = (
        "The paper compares both models with measured poses of the tendon-driven neck, which are not public. The data "
        "here are simulated with the model's own physics. They can show how far noise carries and what a single "
        "missing effect does; they cannot show the error of the paper's model against its neck, and that the errors "
        "are small here says nothing of it.",
        "Camera noise of 0.1 mm is a large share of a small workspace: on the paper preset x moves by 1.6 mm in all, "
        "so that the largest error in x is noise. The polynomial's input is the measured pose, and the stiff neck "
        "turns noise of the pose into large errors of the wrench: its errors say more of the camera than of the "
        "polynomial.",
        f"The missing effect is a bend at rest of {_BENT:g} per m. The paper does not say whether its numbers are "
        "largest or rms errors; both are given.",
        *(_growth(preset, cases) for preset, cases in found.items()),
    )
    head = ("preset", "SIMULATED neck", "model", "of", "paper [%]", "largest [%]", "rms [%]", "largest", "rms", "unit")
    table = Table("Errors in per cent of the measured extent, and as they are", head, tuple(rows))
    pictures = tuple(_picture(preset, case, entry) for preset, cases in found.items() for case, entry in cases.items())
    return Part(tuple(claims), numbers, Section("Accuracy (Fig. 6)", sentences, (table,), pictures))


def _growth(preset: str, cases: Mapping[str, Errors]) -> str:
    rms = {case: np.sqrt(np.mean(entry.pose**2, axis=0)) * [MM, MM, DEG] for case, entry in cases.items()}
    changes = [
        f"{name} from {before:.2f} to {after:.2f} {unit}"
        for name, unit, before, after in zip(_FEM, ("mm", "mm", "deg"), rms[_LIKE], rms[_UNLIKE], strict=True)
    ]
    return f"Preset {preset}: the missing effect changes the rms error of the finite element model in " + (
        f"{changes[0]}, {changes[1]} and {changes[2]}."
    )


def _both(preset: str, seed: int, n: int) -> dict[str, Errors]:
    neck, data = load(f"simulated_{preset}_tendon")
    bent = measure(neck.replace(precurvature=_BENT), data, Sensors(force_sigma=0.1), seed)
    model = FiniteElementModel(neck)
    known = training_poses(model, n, seed)
    poly = PolynomialModel.fit(known.poses, known.wrenches)
    return {_LIKE: errors(model, poly, data), _UNLIKE: errors(model, poly, bent)}


def errors(model: FiniteElementModel, poly: PolynomialModel, data: Measurements) -> Errors:
    """Return how far both models are off: the pose from the tendon forces, the wrench from the measured pose."""
    wrench = measured_wrenches(model, data)
    left = wrench - poly.polynomial(data.pose)
    return Errors(
        predict(model.mechanism, data).residual, left, np.ptp(data.pose, axis=0), np.ptp(wrench, axis=0), data
    )


def _claims(preset: str, case: str, errors: Errors) -> list[PaperClaim]:
    shares = errors.shares()
    (_, fem), (_, poly) = shares["FEM"], shares["polynomial"]
    where = f"Fig. 6, preset {preset}, neck {case} (simulated)"
    x, z, theta = np.abs(errors.pose).max(axis=0) * [MM, MM, DEG]
    return [
        PaperClaim(
            f"{where}: error of the FEM, largest, of the workspace",
            _listed(_FEM),
            f"{_percent(_FEM, fem)}; {x:.2g} mm, {z:.2g} mm, {theta:.2g} deg",
            NOT_PUBLIC,
        ),
        PaperClaim(
            f"{where}: error of the polynomial, largest, of the range", _listed(_POLYNOMIAL),
            _percent(_POLYNOMIAL, poly), NOT_PUBLIC,
        ),
        PaperClaim(
            f"{where}: the polynomial is less accurate than the FEM in every channel, x against fx and so on",
            "less accurate",
            f"{_percent(_POLYNOMIAL, poly)} against {_percent(_FEM, fem)}",
            verdict(float((fem / poly).max()), 1.0, f"{float((fem / poly).max()):.2g} times the FEM's share at worst"),
        ),
    ]  # fmt: skip


def _listed(paper: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {value:g} %" for name, value in paper.items())


def _percent(names: Mapping[str, float], shares: Array) -> str:
    return ", ".join(f"{name} {100.0 * share:.1f} %" for name, share in zip(names, shares, strict=True))


def _rows(preset: str, case: str, of_case: Errors) -> list[tuple[str | float | None, ...]]:
    shares = of_case.shares()
    rows: list[tuple[str | float | None, ...]] = []
    for model, paper, error, scales, units in (
        ("FEM", _FEM, of_case.pose, (MM, MM, DEG), ("mm", "mm", "deg")),
        ("polynomial", _POLYNOMIAL, of_case.wrench, (1.0, 1.0, 1.0), ("N", "N", "N m")),
    ):
        rms, largest = 100.0 * shares[model]
        for i, (name, value) in enumerate(paper.items()):
            errors = error[:, i] * scales[i]
            size = float(np.abs(errors).max()), float(np.sqrt(np.mean(errors**2)))
            rows.append((preset, case, model, name, value, float(largest[i]), float(rms[i]), *size, units[i]))
    return rows


def _numbers(errors: Errors) -> dict[str, Any]:
    return {
        model: {
            kind: dict(zip(names, values.tolist(), strict=True))
            for kind, values in zip(("rms_share", "largest_share"), shares, strict=True)
        }
        for (model, shares), names in zip(errors.shares().items(), (CHANNEL_KEYS, COMPONENTS), strict=True)
    }


def _picture(preset: str, case: str, errors: Errors) -> Picture:
    theta = np.rad2deg(errors.data.theta)
    panels = (
        ("FEM: measured less predicted pose", errors.pose / errors.workspace, ("x", "z", "θ"), "workspace"),
        ("polynomial: measured less predicted wrench", errors.wrench / errors.wrenches, ("fx", "fz", "τ"), "range"),
    )
    with canvas(7.2, 3.2, f"{SIMULATED}; neck {case}") as figure:
        for axes, (title, shares, names, extent) in zip(figure.subplots(1, 2), panels, strict=True):
            axes.axhline(0.0, color=FAINT, linewidth=0.8)
            for i, name in enumerate(names):
                axes.plot(theta, 100.0 * shares[:, i], ".", color=COLORS[i], markersize=3.0, label=name,
                          rasterized=True)  # fmt: skip
            axes.set_title(title)
            axes.set_xlabel("measured θ [deg]")
            axes.set_ylabel(f"error [% of the {extent}]")
            axes.grid(True)
            axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=3, markerscale=3.0)
    caption = (
        f"Fig. 6, preset {preset}, neck {case}: left what the finite element model leaves of the poses, right what the "
        "cubic polynomial leaves of the wrenches."
    )
    columns = {
        "lam_l_N": errors.data.lam_l,
        "lam_r_N": errors.data.lam_r,
        **{f"measured_{name}": column for name, column in by_channel(errors.data.pose).items()},
        **{f"error_{name}": column for name, column in by_channel(errors.pose).items()},
        **by_component(errors.wrench, "error_"),
    }
    return Picture(f"comparison_{preset}_{case.replace(' ', '_')}", caption, figure, columns)
