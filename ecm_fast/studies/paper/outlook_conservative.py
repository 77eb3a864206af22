"""Conservative polynomials, the gradient of one energy, against free ones: the paper's outlook."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...mechanism.mechanism import Mechanism
from ...mechanism.sections import PRESETS
from ...models.finite_element import FiniteElementModel
from ...models.polynomial.multivariate import monomials
from ...pages.page import Picture, Section, Table
from ...pages.plots import COLORS, canvas
from .claims import COMPONENTS, PaperClaim, Part, verdict
from .fig5_polynomial import draw

__all__ = ["coefficient_count", "kinds"]

Array = NDArray[np.float64]

_DEGREES = (2, 3, 4, 5)  # about the paper's cubic
_KINDS = {"free": False, "conservative": True}
_SAME, _BETTER = 1.1, 0.9
"""Rms errors up to the first of these factors count as no worse, up to the second as better."""
_NAMES = ("fx", "fz", "τ")
_Errors = Mapping[tuple[str, int], Array]


def kinds(seed: int = 0, draws: int = 5, n: int = 1000, tests: int = 300) -> Part:
    """Train both kinds of polynomial of several degrees on the same poses."""
    found = {preset: _rms(preset, seed, draws, n, tests) for preset in PRESETS}
    claims = tuple(claim for preset in PRESETS for claim in _claims(preset, found[preset]))
    numbers = {
        preset: [
            {"kind": kind, "degree": degree, "coefficients": coefficient_count(kind, degree),
             **{f"rms_{name}": value for name, value in zip(COMPONENTS, rms, strict=True)}}
            for (kind, degree), rms in found[preset].items()
        ]
        for preset in PRESETS
    }  # fmt: skip
    sentences = (
        "The paper asks for polynomials with a symmetric stiffness, which have fewer coefficients. Such a polynomial "
        "is the gradient of one energy, of one degree more.",
        "Which to use: take the energy where a controller relies on a symmetric stiffness or on energy that is "
        "conserved, and on a short neck wherever the number of coefficients counts, since one degree more costs few. "
        "Take the free polynomial where only accuracy at a given degree counts, and always at even degrees on a "
        "slender neck, where the terms that fx needs imply terms of fz and tau of one degree more.",
    )
    tables = tuple(_table(preset, found[preset], draws) for preset in PRESETS)
    picture = _picture(found)
    return Part(claims, numbers, Section("Polynomials with an energy", sentences, tables, (picture,)))


def coefficient_count(kind: str, degree: int) -> int:
    """Return how many numbers three polynomials of three variables have, or one energy without its constant."""
    terms: int = monomials(np.zeros((1, 3)), degree + _KINDS[kind]).shape[1]
    return terms - 1 if _KINDS[kind] else 3 * terms


def _rms(preset: str, seed: int, draws: int, n: int, tests: int) -> dict[tuple[str, int], Array]:
    """Return the median rms error of fx, fz, tau, (3,), by kind and degree."""
    model = FiniteElementModel(Mechanism.preset(preset))
    return {
        (kind, degree): np.median(
            [draw(model, seed + i, n, tests, degree, conservative).rms for i in range(draws)], axis=0
        )
        for degree in _DEGREES
        for kind, conservative in _KINDS.items()
    }


def _claims(preset: str, errors: _Errors) -> list[PaperClaim]:
    loss = errors["conservative", 3] / errors["free", 3]
    change = errors["conservative", 4] / errors["free", 3]
    few, many = coefficient_count("conservative", 3), coefficient_count("free", 3)
    most = coefficient_count("conservative", 4)
    return [
        PaperClaim(
            f"Conclusion, preset {preset}: at degree 3 an energy of {few} coefficients is as good as the {many} of the "
            "free polynomial, every rms error within 10 %",
            "would benefit",
            f"errors times {_factors(loss)}",
            verdict(float(loss.max()), _SAME, f"errors times {_factors(loss)}"),
        ),
        PaperClaim(
            f"Conclusion, preset {preset}: with about as many coefficients, {most} against {many}, an energy is the "
            "more accurate one in every component",
            "would benefit",
            f"errors times {_factors(change)}",
            verdict(float(change.max()), _BETTER, f"errors times {_factors(change)}"),
        ),
    ]


def _factors(factors: Array) -> str:
    return ", ".join(f"{name} {factor:.3g}" for name, factor in zip(_NAMES, factors, strict=True))


def _table(preset: str, errors: _Errors, draws: int) -> Table:
    rows = tuple(
        (f"{kind}, degree {degree}", coefficient_count(kind, degree), *rms.tolist())
        for (kind, degree), rms in errors.items()
    )
    head = ("polynomial", "coefficients", "fx [N]", "fz [N]", "tau [N m]")
    return Table(f"Preset {preset}: rms errors at poses not trained on, median of {draws} draws", head, rows)


def _picture(by_preset: Mapping[str, _Errors]) -> Picture:
    columns: dict[str, list[Any]] = {name: [] for name in ("preset", "kind", "degree", "coefficients")}
    columns |= {f"rms_{name}": [] for name in COMPONENTS}
    for preset, entries in by_preset.items():
        for (kind, degree), rms in entries.items():
            row = (preset, kind, degree, coefficient_count(kind, degree), *rms.tolist())
            for column, value in zip(columns.values(), row, strict=True):
                column.append(value)
    with canvas(7.2, 3.4) as figure:
        for axes, (preset, entries) in zip(figure.subplots(1, 2), by_preset.items(), strict=True):
            for i, name in enumerate(_NAMES):
                for kind, style in (("free", "o-"), ("conservative", "s--")):
                    count = [coefficient_count(kind, degree) for degree in _DEGREES]
                    errors = [entries[kind, degree][i] for degree in _DEGREES]
                    axes.plot(count, errors, style, color=COLORS[i], markersize=4.0, label=f"{name}, {kind}")
            axes.set_yscale("log")
            axes.set_title(f"preset {preset}")
            axes.set_xlabel("coefficients")
            axes.grid(True)
        figure.axes[0].set_ylabel("rms error [N, N, N m]")
        figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    caption = "Rms errors of both kinds over their number of coefficients, degrees 2 to 5."
    return Picture("kinds", caption, figure, columns)
