"""Table 1 and Fig. 3 of the paper: stiffnesses identified from its two experiments, simulated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data.datasets import load
from ...data.measurements import Measurements
from ...mechanism.mechanism import Mechanism
from ...mechanism.sections import PRESETS
from ...pages.page import Picture, Section, Table
from ...pages.plots import CHANNELS_MRAD, COLORS, FAINT, canvas
from .claims import MM, NOT_PUBLIC, SIMULATED, PaperClaim, Part, by_channel, shown, verdict
from .table1_fit import StiffnessFit, fitted

__all__ = ["hooke_ratio", "table1"]

Array = NDArray[np.float64]

_AREA = 7500.0 / 871080.0
"""[m^2], from the paper's E = EA / A."""
_COMPRESSED = {28: (7448.94, 8972.10), 40: (7591.09, 9071.84)}
"""EA [N] by the length [mm] of the specimen, neo-Hookean and Hookean (Table 1)."""
_SHEARED = {"1": ("33 N", 2405.0, 2.993), "2": ("66 N", 2422.0, 3.003)}
"""Largest force, GA [N] and EI [N m^2] (Table 1) by the session of the simulated test."""
_SHORTENING = 0.2  # the largest shortening of the compression test, Section 2.4
_RATIO_BOUND, _DIVISION_BOUND = 0.005, 0.005  # shares: bounds that the claims state
_SIGMAS = 3.0  # one in 370 by chance
_X, _SHEAR = ("x",), ("z", "theta")
"""Channels that enter the misfit, (43) and below (45)."""
_PAPER = {"elements": 20, "order": 1}  # the discretization of Section 3


def hooke_ratio(shortening: float = _SHORTENING, n: int = 2001) -> float:
    """Return Hooke's EA over the neo-Hookean EA, fitted on exact positions evenly over 0 to `shortening`.

    Under Hooke's law the shortening is the force over EA, so the misfit is linear in 1/EA.
    """
    short = np.linspace(0.0, shortening, n)
    force = ((1.0 - short) ** -2 - (1.0 - short)) / 3.0  # of (19), in units of EA
    return float(force @ force / (force @ short))


def table1(seed: int = 0) -> Part:
    """Find EA from two compression tests, GA and EI from two shear tests of each preset.

    The data are fixed, so that nothing depends on the seed.
    """
    compressed = {length: _compression(length) for length in _COMPRESSED}
    sheared = {preset: _shear(preset) for preset in PRESETS}
    claims = [*_law_claims(compressed), *_found_claims(compressed, sheared), _division_claim(sheared)]
    numbers = {
        "hooke_ratio": hooke_ratio(),
        "compression": {
            f"{length}_mm": {law: _numbers(("EA_N",), fit) for law, fit in laws.items()}
            for length, (_, _, laws) in compressed.items()
        },
        "shear": {
            preset: {
                _SHEARED[session][0]: {name: _numbers(("GA_N", "EI_Nm2"), fit) for name, fit in fits.items()}
                for session, (_, fits) in sessions.items()
            }
            for preset, sessions in sheared.items()
        },
    }
    sentences = (
        "The paper fits EA to positions of compressed specimens and GA, EI to height and rotation of a sheared neck. "
        "Its readings are not public; a simulated test bed that knows the paper's values gives the data here, so that "
        "a value found again shows the method, not the material.",
        f"One number needs no data: Hooke's law, fitted to the positions that the neo-Hookean law gives evenly over "
        f"0 to 20 % shortening, makes the specimen {hooke_ratio():.4f} times as stiff.",
    )
    pictures = (_stress_picture(compressed), *(_shear_picture(preset, sheared[preset]) for preset in PRESETS))
    section = Section("Stiffnesses (Table 1, Fig. 3)", sentences, (_table(compressed, sheared),), pictures)
    return Part(tuple(claims), numbers, section)


_Compressed = tuple[Mechanism, Measurements, dict[str, StiffnessFit]]
_Sheared = dict[str, tuple[Measurements, dict[str, StiffnessFit]]]


def _compression(length: int) -> _Compressed:
    truth, data = load(f"simulated_compression_{length}mm")
    laws = {law: fitted(truth.replace(axial_law=law), data, {"EA": 6000.0}, _X) for law in ("neo-hookean", "hooke")}
    return truth, data, laws


def _shear(preset: str) -> _Sheared:
    truth, data = load(f"simulated_{preset}_shear")
    found: _Sheared = {}
    for session in _SHEARED:
        rows = data.select(data.session == session)
        start = {"GA": 2000.0, "EI": 4.0}
        found[session] = (
            rows,
            {
                "default": fitted(truth, rows, start, _SHEAR),
                "20 linear elements": fitted(truth, rows, start, _SHEAR, **_PAPER),
            },
        )
    return found


def _law_claims(compressed: Mapping[int, _Compressed]) -> list[PaperClaim]:
    ours, claims = hooke_ratio(), []
    for length, (neo, hooke) in _COMPRESSED.items():
        off = ours / (hooke / neo) - 1.0
        claims.append(
            PaperClaim(
                f"Table 1, {length} mm: EA by Hooke's law over EA by the neo-Hookean law, within 0.5 %",
                f"{hooke / neo:.4f}",
                f"{ours:.4f} on exact positions",
                verdict(abs(off), _RATIO_BOUND, f"{off:+.1%}; the real specimen is not exactly neo-Hookean"),
            )
        )
    for length, (_, _, laws) in compressed.items():
        neo_fit, hooke_fit = laws["neo-hookean"], laws["hooke"]
        over = float(hooke_fit.value[0] / neo_fit.value[0])
        claims.append(
            PaperClaim(
                f"Fig. 3 left, {length} mm (simulated): Hooke's law overestimates the stiffness and fits worse",
                "much better by the neo-Hookean law",
                f"EA {over:.3f} times; misfit {hooke_fit.rms:.2f} against {neo_fit.rms:.2f} of the noise",
                "holds" if over > 1.0 and hooke_fit.rms > neo_fit.rms else "differs by the opposite",
            )
        )
    return claims


def _found_claims(compressed: Mapping[int, _Compressed], sheared: Mapping[str, _Sheared]) -> list[PaperClaim]:
    claims = [
        PaperClaim(
            "Table 1: EA, GA and EI of the real neck and its specimens",
            "EA 7448.94, 7591.09 N; GA 2405, 2422 N; EI 2.993, 3.003 N m^2",
            "nothing to fit them to",
            NOT_PUBLIC,
        ),
        PaperClaim(
            "Fig. 3 right: errors of the shear test", "a curve without numbers", _shear_rms(sheared), NOT_PUBLIC
        ),
    ]
    for length, (truth, _, laws) in compressed.items():
        fit = laws["neo-hookean"]
        off = float(np.abs(fit.value[0] - truth.beam.EA) / fit.std[0])
        claims.append(_found(f"EA, specimen of {length} mm", f"{truth.beam.EA:g} N", "{:.0f} ± {:.0f} N", fit, off))
    for preset, sessions in sheared.items():
        beam = Mechanism.preset(preset).beam
        for session, (_, fits) in sessions.items():
            fit = fits["default"]
            off = float(np.abs((fit.value - [beam.GA, beam.EI]) / fit.std).max())
            where = f"GA and EI, preset {preset}, up to {_SHEARED[session][0]}"
            known = f"{beam.GA:g} N, {beam.EI:g} N m^2"
            claims.append(_found(where, known, "{:.0f} ± {:.0f} N, {:.3f} ± {:.3f} N m^2", fit, off))
    return claims


def _found(what: str, known: str, form: str, fit: StiffnessFit, off: float) -> PaperClaim:
    return PaperClaim(
        f"Table 1 (simulated): {what}: found again within {_SIGMAS:g} standard deviations",
        f"{known}, built in",
        form.format(*np.column_stack([fit.value, fit.std]).ravel()),
        verdict(off, _SIGMAS, f"{shown(off, '.1f')} standard deviations"),
    )


def _shear_rms(sheared: Mapping[str, _Sheared]) -> str:
    parts = []
    for preset, sessions in sheared.items():
        residual = np.concatenate([fits["default"].residual for _, fits in sessions.values()])
        x, z, theta = np.sqrt(np.mean(residual**2, axis=0)) * [MM, MM, 1e3]
        parts.append(f"{preset}: rms {x:.2f} mm, {z:.2f} mm, {theta:.1f} mrad (noise 0.1, 0.1, 1)")
    return "; ".join(parts)


def _division_claim(sheared: Mapping[str, _Sheared]) -> PaperClaim:
    default, paper = "default", "20 linear elements"
    shifts = {
        preset: max(float(np.abs(fits[paper].value / fits[default].value - 1.0).max()) for _, fits in sessions.values())
        for preset, sessions in sheared.items()
    }
    largest = max(shifts.values())
    return PaperClaim(
        "Section 2.4: 20 linear elements suffice to identify GA and EI, within 0.5 %",
        "20 elements",
        "; ".join(f"{preset}: shifted by {shift:.2%}" for preset, shift in shifts.items()),
        verdict(largest, _DIVISION_BOUND, shown(largest, ".2%")),
    )


def _numbers(names: Sequence[str], fit: StiffnessFit) -> dict[str, Any]:
    values = {name: {"value": fit.value[i], "std": fit.std[i]} for i, name in enumerate(names)}
    return {**values, "rms_of_noise": fit.rms}


def _table(compressed: Mapping[int, _Compressed], sheared: Mapping[str, _Sheared]) -> Table:
    rows: list[tuple[str | float | None, ...]] = []
    for length, paper in _COMPRESSED.items():
        truth, _, laws = compressed[length]
        for (law, fit), value in zip(laws.items(), paper, strict=True):
            known = truth.beam.EA if law == "neo-hookean" else hooke_ratio() * truth.beam.EA
            rows.append((f"EA {law} [N]", f"specimen {length} mm", value, known, fit.value[0], fit.std[0]))
    for preset, sessions in sheared.items():
        truth = Mechanism.preset(preset)
        for session, (force, *values) in _SHEARED.items():
            fit = sessions[session][1]["default"]
            for i, (name, value) in enumerate(zip(("GA", "EI"), values, strict=True)):
                unit, known = ("N", truth.beam.GA) if name == "GA" else ("N m^2", truth.beam.EI)
                rows.append((f"{name} [{unit}]", f"{preset}, up to {force}", value, known, fit.value[i], fit.std[i]))
    head = ("parameter", "test", "paper, measured", "SIMULATED: built in", "found again", "one standard deviation")
    return Table("Table 1 beside what is found again on simulated data of 0.1 mm and 1 mrad noise", head, tuple(rows))


def _stress_picture(compressed: Mapping[int, _Compressed]) -> Picture:
    columns: dict[str, list[float | str]] = {name: [] for name in ("specimen_m", "strain", "stress_Pa")}
    columns |= {"neo_hookean_Pa": [], "hooke_Pa": []}
    with canvas(7.2, 3.2, SIMULATED) as figure:
        for axes, (length, (_, data, laws)) in zip(figure.subplots(1, 2, sharey=True), compressed.items(), strict=True):
            strain = 1.0 - data.x * MM / length
            stress = -data.fx / _AREA
            curves = _curves(np.linspace(0.0, 1.1 * _SHORTENING, 60), laws)
            axes.plot(100 * strain, stress / 1e3, "o", color=FAINT, markersize=3.5, label="simulated readings")
            for (law, curve), color in zip(curves.items(), COLORS[:2], strict=True):
                label = f"{law}, EA {laws[law].value[0]:.0f} N"
                axes.plot(np.linspace(0.0, 110 * _SHORTENING, 60), curve / 1e3, color=color, label=label)
            axes.set_title(f"specimen of {length} mm")
            axes.set_xlabel("axial strain, shortening [%]")
            axes.grid(True)
            axes.legend(loc="upper left")
            curves = _curves(strain, laws)
            columns["specimen_m"] += [length / MM] * data.n
            for name, values in zip(list(columns)[1:], (strain, stress, *curves.values()), strict=True):
                columns[name] += values.tolist()
        figure.axes[0].set_ylabel("axial stress [kPa]")
    caption = (
        "Fig. 3, left: stress and strain of two simulated specimens, with both laws fitted to their positions. The "
        "neo-Hookean law follows the curve, Hooke's is too stiff at first and too soft at last."
    )
    return Picture("table1_stress", caption, figure, columns)


def _curves(strain: Array, laws: Mapping[str, StiffnessFit]) -> dict[str, Array]:
    """Return the compressive stress [Pa] of both laws (19) at shortenings."""
    stretch, neo, hooke = 1.0 - strain, laws["neo-hookean"].value[0], laws["hooke"].value[0]
    return {"neo-hookean": neo / 3.0 * (stretch**-2 - stretch) / _AREA, "hooke": hooke * strain / _AREA}


def _shear_picture(preset: str, sessions: _Sheared) -> Picture:
    tests = [(_SHEARED[session][0], data, fits["default"].residual) for session, (data, fits) in sessions.items()]
    with canvas(7.2, 2.7, SIMULATED) as figure:
        for i, axes in enumerate(figure.subplots(1, 3)):
            name, unit, scale = CHANNELS_MRAD[i]
            axes.axhline(0.0, color=FAINT, linewidth=0.8)
            for (force, data, residual), color, mark in zip(tests, COLORS[:2], "os", strict=True):
                axes.plot(data.fz, residual[:, i] * scale, mark, color=color, markersize=3.5, label=f"up to {force}")
            axes.set_xlabel("side force [N]")
            axes.set_ylabel(f"error of {name} [{unit}]")
            axes.grid(True)
        figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    caption = (
        f"Fig. 3, right, preset {preset}: simulated readings less the model with the GA and EI found, for the tests up "
        "to 33 N and 66 N. What is left is the noise, since neck and model share their physics."
    )
    left = np.concatenate([residual for _, _, residual in tests])
    columns = {
        "session": np.concatenate([data.session for _, data, _ in tests]),
        "fz_N": np.concatenate([data.fz for _, data, _ in tests]),
        **by_channel(left),
    }
    return Picture(f"table1_shear_{preset}", caption, figure, columns)
