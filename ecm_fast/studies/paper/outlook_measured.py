"""Polynomials trained on measured poses, and polynomials from loads to the pose."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...mechanism.mechanism import Mechanism
from ...mechanism.sections import PRESETS
from ...models.finite_element import FiniteElementModel
from ...models.polynomial.model import ForwardPolynomial, PolynomialModel
from ...models.polynomial.training import TrainingSet, relative_errors, tip_wrenches, training_poses, training_rows
from ...pages.page import Picture, Section, Table
from ...pages.plots import COLORS, canvas, random_tendon_forces
from ...testbed import Sensors, measure, tendon_test
from .claims import COMPONENTS, DEG, MM, NOT_GIVEN, SIMULATED, PaperClaim, Part, shown, verdict

__all__ = ["forward_errors", "inverse_errors", "trained"]

Array = NDArray[np.float64]

_MODEL, _MEASURED, _BOTH = "the model's poses", "measured poses", "both"
_TENDONS, _BOX = "tendons", "box"
NECKS = {"as the model": 0.0, "precurved": 0.2}
"""Measured quantity: curvature at rest [1/m], of which the model knows nothing."""
_DEGREES = (3, 4, 5)  # the paper's cubic, and two degrees more
_FORWARD_BOUND = 0.01  # share of the range: the bound that the claim states
_NAMES = ("fx", "fz", "τ")

_Inverse = dict[tuple[str, str], dict[str, Array]]
_Forward = dict[tuple[str, int], tuple[Array, Array]]


def trained(seed: int = 0, n: int = 1000, rows: int = 300) -> Part:
    """Train on `n` poses of the model, on `rows` simulated measured ones, and on both; then from loads to the pose."""
    inverse = {preset: inverse_errors(preset, seed, n, rows) for preset in PRESETS}
    forward = {preset: forward_errors(preset, seed, n, rows) for preset in PRESETS}
    claims = tuple(
        claim for preset in PRESETS for claim in (*_claims(preset, inverse[preset]), _forward(preset, forward[preset]))
    )
    numbers = {preset: _numbers(inverse[preset], forward[preset]) for preset in PRESETS}
    sentences = (
        "The paper trains its polynomial on poses of the model and expects measured ones to bring it closer to the "
        f"real system. Here the measured poses are {rows} simulated ones with noise of 0.1 mm, 1 mrad and 0.1 N, once "
        "of a neck like the model, once of one that is bent at rest by 0.2 per m, of which the model knows nothing; "
        "the wrench at each is P(q) lambda (40) of its force readings. Errors are against the truth without noise.",
        "Tendons reach a thin sheet of poses only. What is trained on them alone is no model of any pose beside the "
        "sheet, and noise of the pose turns into error of the wrench; training on both bounds that, but the model's "
        "poses then keep pulling toward what the model believes.",
        "The other way round, from tendon forces or from a wrench to the pose, takes the same regression.",
    )
    tables = (_inverse_table(inverse), _forward_table(forward))
    heading = "Polynomials trained on measured poses, and forward ones"
    return Part(claims, numbers, Section(heading, sentences, tables, (_picture(inverse),)))


def inverse_errors(preset: str, seed: int, n: int, rows: int) -> _Inverse:
    """Return rms errors (3,) [N, N, N m] of cubic polynomials, by neck and training set, and by where it is tested."""
    drawn = Mechanism.preset(preset)
    model, found = FiniteElementModel(drawn), {}
    for neck, curvature in NECKS.items():
        real, rng = drawn.replace(precurvature=curvature), np.random.default_rng(seed)
        simulated = training_poses(model, n, rng)
        measured = training_rows(model, measure(real, tendon_test(rows, seed=rng), Sensors(force_sigma=0.1), rng))
        tests = {_TENDONS: _held_by_tendons(real, rows, rng), _BOX: training_poses(FiniteElementModel(real), rows, rng)}
        for source, known in {_MODEL: simulated, _MEASURED: measured, _BOTH: simulated + measured}.items():
            poly = PolynomialModel.fit(known.poses, known.wrenches)
            found[neck, source] = {where: relative_errors(poly, test).rms for where, test in tests.items()}
    return found


def _held_by_tendons(neck: Mechanism, n: int, rng: np.random.Generator) -> TrainingSet:
    """Return poses under random tendon forces with the wrench of the tendons there."""
    model, lam = FiniteElementModel(neck), random_tendon_forces(n, rng)
    poses = model.solve_batch(lam).pose
    return TrainingSet(poses, tip_wrenches(model, poses, lam), 0)


def forward_errors(preset: str, seed: int, n: int, tests: int) -> _Forward:
    """Return rms and largest errors (3,) [m, m, rad] at new loads, by the way in and the degree."""
    model, rng = FiniteElementModel(Mechanism.preset(preset)), np.random.default_rng(seed)
    lam, wrenched = random_tendon_forces(n + tests, rng), training_poses(model, n + tests, rng)
    ways = {"tendons": (lam, model.solve_batch(lam).pose), "wrench": (wrenched.wrenches, wrenched.poses)}
    found = {}
    for way, (loads, poses) in ways.items():
        for degree in _DEGREES:
            poly = ForwardPolynomial.fit(loads[:n], poses[:n], degree)
            error = np.abs(poly.polynomial(loads[n:]) - poses[n:])
            found[way, degree] = np.sqrt(np.mean(error**2, axis=0)), error.max(axis=0)
    return found


def _claims(preset: str, inverse: _Inverse) -> list[PaperClaim]:
    claims = []
    for neck in NECKS:
        ratio = inverse[neck, _MEASURED][_TENDONS] / inverse[neck, _MODEL][_TENDONS]
        factors = ", ".join(f"{name} {factor:.3g}" for name, factor in zip(_NAMES, ratio, strict=True))
        claims.append(
            PaperClaim(
                f"Section 4.3, preset {preset}, neck {neck} (simulated): training on measured poses makes the "
                "polynomial more accurate under tendons in every component",
                "increases the accuracy",
                f"errors times {factors}",
                verdict(float(ratio.max()), 1.0, f"errors times {factors}: noise of the poses"),
            )
        )
    return claims


def _forward(preset: str, forward: _Forward) -> PaperClaim:
    _, largest = forward["tendons", 3]
    length = Mechanism.preset(preset).beam.length
    error = float((largest / [length, length, 1.0]).max())
    x, z, theta = largest * [MM, MM, DEG]
    return PaperClaim(
        f"Beyond the paper, preset {preset}: a cubic polynomial from tendon forces to the pose is within 1 % of the "
        "length and 0.01 rad at every new load",
        NOT_GIVEN,
        f"largest errors x {x:.2g} mm, z {z:.2g} mm, theta {theta:.2g} deg",
        verdict(error, _FORWARD_BOUND, shown(error, ".2%")),
    )


def _numbers(inverse: _Inverse, forward: _Forward) -> dict[str, Any]:
    return {
        "inverse": [
            {"neck": neck, "trained_on": source, "tested_on": where, **dict(zip(COMPONENTS, rms, strict=True))}
            for (neck, source), errors in inverse.items()
            for where, rms in errors.items()
        ],
        "forward": [
            {"from": way, "degree": degree, "rms_m_m_rad": rms, "largest_m_m_rad": largest}
            for (way, degree), (rms, largest) in forward.items()
        ],
    }


def _inverse_table(inverse: Mapping[str, _Inverse]) -> Table:
    rows = tuple(
        (preset, neck, source, *errors[_TENDONS].tolist(), *errors[_BOX].tolist())
        for preset, found in inverse.items()
        for (neck, source), errors in found.items()
    )
    head = ("preset", "SIMULATED neck", "trained on", "tendons: fx [N]", "fz [N]", "tau [N m]", "box: fx [N]",
            "fz [N]", "tau [N m]")  # fmt: skip
    return Table("Rms errors of cubic polynomials at poses held by tendons, and by wrenches of the box", head, rows)


def _forward_table(forward: Mapping[str, _Forward]) -> Table:
    unit = [MM, MM, DEG]
    rows = tuple(
        (preset, way, degree, *(rms * unit).tolist(), *(largest * unit).tolist())
        for preset, found in forward.items()
        for (way, degree), (rms, largest) in found.items()
    )
    head = ("preset", "from", "degree", "rms x [mm]", "z [mm]", "theta [deg]", "largest x [mm]", "z [mm]",
            "theta [deg]")  # fmt: skip
    return Table("Polynomials from loads to the pose: errors at loads not trained on", head, rows)


def _picture(inverse: Mapping[str, _Inverse]) -> Picture:
    columns: dict[str, list[Any]] = {name: [] for name in ("preset", "neck", "trained_on")}
    columns |= {f"rms_{name}": [] for name in COMPONENTS}
    sources = (_MODEL, _MEASURED, _BOTH)
    with canvas(7.2, 3.2, SIMULATED) as figure:
        for axes, (preset, found) in zip(figure.subplots(1, 2), inverse.items(), strict=True):
            for neck, filled in zip(NECKS, (True, False), strict=True):
                for i, name in enumerate(_NAMES):
                    rms = [found[neck, source][_TENDONS][i] for source in sources]
                    face = COLORS[i] if filled else "white"
                    places = np.arange(3) + (0.0 if filled else 0.12)
                    label = f"{name}, {neck}"
                    axes.plot(places, rms, "o", color=COLORS[i], markerfacecolor=face, markersize=5.0, label=label)
                for source in sources:
                    row = (preset, neck, source, *found[neck, source][_TENDONS].tolist())
                    for column, value in zip(columns.values(), row, strict=True):
                        column.append(value)
            axes.set_yscale("log")
            axes.set_xticks(range(3), ["model", "measured", "both"])
            axes.set_xlim(-0.5, 2.6)
            axes.set_title(f"preset {preset}")
            axes.set_xlabel("trained on")
            axes.grid(True, axis="y")
        figure.axes[0].set_ylabel("rms error [N, N, N m]")
        figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    caption = (
        "Rms errors under tendons of cubic polynomials, by what they were trained on; filled: the neck is as the model "
        "believes, open: it is bent at rest."
    )
    return Picture("trained", caption, figure, columns)
