"""The page of a diagnosis: the verdict, then the figures behind it, each with its numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from ...diagnosis import Diagnosis, Plan
from ...diagnosis.answer.next_step import next_step
from ...diagnosis.answer.sentences import MIRRORS, alike, dimensions, meaning, next_best
from ...diagnosis.checks.symmetry import Parity
from ...diagnosis.problem.problem import DRIFT
from ...diagnosis.results.next_loads import NextLoads
from ...mechanism.mechanism import Mechanism
from ...mechanism.parameters import find
from ..page import Picture, Section, Table, write_report
from .evidence import cosine_matrix, evidence_bars, gap_bar, left_over, parameter_profiles, promise, stiffness
from .maps import loops, parity_split, residual_maps, workspace, wrench_arrows
from .rows import MOST, Story

__all__ = ["write_diagnosis"]

_NAMES = 12  # rows that a table lists
_GATES = {"effects": "any effect of the catalogue", "smooth": "smooth patterns over loads and time"}
_ADDED = ("nothing added", "one effect added", "two effects added", "three effects added")
_TITLES = {
    "named": "What the data ask for",
    "family": "A set of explanations that these data cannot tell apart",
    "outside_catalogue": "Something that the catalogue does not explain",
    "nothing_found": "No missing effect was found",
    "data_gap": "The data lack what would tell",
}


def write_diagnosis(
    diagnosis: Diagnosis,
    mechanism: Mechanism,
    path: Path,
    *,
    parity: Parity | None = None,
    plan: Plan | None = None,
    next_loads: NextLoads | None = None,
    notes: Iterable[str] = (),
    priors: Mapping[str, tuple[float, float]] | None = None,
) -> Path:
    """Write the page of a diagnosis and beside it the numbers of its pictures.

    Parameters
    ----------
    found : the diagnosis
    mechanism : with which it began
    path : of the page
    parity : the tests that need no model
    plan : what these poses can show, for the matrix of look-alikes
    next_loads : what to measure next
    notes : what was noticed about the data
    priors : value and standard deviation of material tests, by name

    Raises
    ------
    InputError : a file cannot be written, or matplotlib or jinja2 is missing.
    """
    story = Story(diagnosis, mechanism)
    sections = [
        _first(story, next_loads),
        Section("Where it disagrees", _where(diagnosis, parity), (), _kept(
            workspace(story), residual_maps(story), parity_split(story), loops(story), wrench_arrows(story))),
        Section("What explains it", (), (_effects(diagnosis),) if diagnosis.effects else (), _kept(
            evidence_bars(story), cosine_matrix(plan) if plan else None, parameter_profiles(story, priors or {}))),
        Section("What is left", _left(diagnosis), (), _kept(left_over(story), stiffness(story))),
    ]  # fmt: skip
    if next_loads and next_loads.suggestions:
        sections.append(
            Section("What to measure next", next_loads.remarks, (_next(next_loads),), _kept(promise(next_loads)))
        )
    sections.append(Section("What these data can show", _invisible(diagnosis), (_sights(diagnosis),)))
    count = int(diagnosis.rows.locked.size)
    drawn = (f"Maps and loops show {MOST} of {count} rows, evenly over the order of measurement.",) * (count > MOST)
    warnings = (*drawn, *notes, *diagnosis.warnings, *diagnosis.alarms)
    sections.append(
        Section("To know before this is used", (*_noise(diagnosis, mechanism), *warnings), _outliers(diagnosis))
    )
    return write_report(path, _TITLES[diagnosis.verdict], sections)


def _kept(*pictures: Picture | None) -> tuple[Picture, ...]:
    """Return the pictures that there are, laid out once: saving one would do it twice."""
    kept = tuple(picture for picture in pictures if picture)
    for picture in kept:
        picture.figure.draw_without_rendering()
        picture.figure.set_layout_engine("none")
    return kept


def _first(story: Story, next_loads: NextLoads | None) -> Section:
    found = story.found
    sentences = [found.sentence]
    for claim in found.effects:
        sentences.append(f"{claim.name}: {meaning(claim)}; {MIRRORS[claim.mirror]}.")
        if claim.look_alikes:
            sentences.append(f"Not distinguishable from {claim.name} here: {alike(found.models, found.names, claim)}.")
    behind = next_best(found.models, found.names)
    sentences += [f"{behind[0].upper()}{behind[1:]}."] if behind else []
    if next_loads and next_loads.suggestions:
        sentences.append(_first_load(next_loads))
    sentences.append(f"Next: {next_step(found.verdict, found.gap.to_json_dict() if found.gap else {}, found.missing)}.")
    tables = (_gap_table(story),) if found.gap or found.transfer else ()
    return Section("", tuple(sentences), tables, _kept(gap_bar(story)))


def _first_load(suggested: NextLoads) -> str:
    first = suggested.suggestions[0]
    loads = ", ".join(f"{name} {value:g}" for name, value in first.loads.items())
    mount = "" if first.mount == "nothing" else f" (mount: {first.mount})"
    apart = f"{first.promised_sigma:.1f} sigma apart instead of {suggested.worst_before:.1f}"
    return f"Measure next: {first.repeats} times {loads}{mount}, {first.minutes:.1f} minutes; the set is then {apart}."


def _gap_table(story: Story) -> Table:
    gaps = ([story.found.gap] if story.found.gap else []) + list(story.found.transfer)
    span = np.zeros(3)
    for i in story.channels:
        span[i] = np.ptp(story.pose[np.isfinite(story.pose[:, i]), i])
    rows: list[tuple[str | float | None, ...]] = []
    for gap in gaps:
        for name, rms in gap.stages.items():
            shares = [
                100.0 * value / width if width > 0.0 else None
                for value, width in zip((rms.x, rms.z, rms.theta), span, strict=True)
            ]
            rows.append(
                (f"{gap.what}, {name}", rms.sigma, 1e3 * rms.x, 1e3 * rms.z, float(np.degrees(rms.theta)), *shares)
            )
    head = ("", "rms [sigma]", "x [mm]", "z [mm]", "θ [deg]", "x [%]", "z [%]", "θ [%]")
    return Table("The gap; percentages are of the measured workspace", head, tuple(rows))


def _where(diagnosis: Diagnosis, parity: Parity | None) -> tuple[str, ...]:
    out = []
    if parity:
        out.append(f"Without any model: {parity.sentence}.")
        out += [f"{test!r}." for test in parity.tests.values()]
    if diagnosis.where:
        parts = ", ".join(f"{name} {share:.0%}" for name, share in diagnosis.where.components.items())
        channels = ", ".join(f"{name} {share:.0%}" for name, share in diagnosis.where.channels.items())
        out.append(f"What one effect of each part of the mechanism could explain: {parts}. By channel: {channels}.")
        if diagnosis.where.region:
            out.append(f"The disagreement is local: {diagnosis.where.region} (chance {diagnosis.where.chance:.2g}).")
    return tuple(out)


def _effects(diagnosis: Diagnosis) -> Table:
    rows: list[tuple[str | float | None, ...]] = []
    for claim in diagnosis.effects:
        others = ", ".join(claim.look_alikes) or "none"
        for name, value in claim.parameters.items():
            low, high = claim.interval[name]
            rows.append((_with_unit(name), value, low, high, claim.sigmas, MIRRORS[claim.mirror], claim.group, others))
    rows += [
        (_with_unit(name), entry.value, entry.lower, entry.upper, None, "", "", "")
        for name, entry in diagnosis.calibration.items()
    ]
    head = ("parameter", "value", "lower", "upper", "sigma", "mirror", "group", "look-alikes")
    return Table("What was found, with 90 % intervals", head, tuple(rows))


def _with_unit(name: str) -> str:
    unit = find(name).unit
    return name if unit == "-" else f"{name} [{unit}]"


def _left(diagnosis: Diagnosis) -> tuple[str, ...]:
    gates = [
        f"{_GATES.get(gate.name, gate.name)}, {_ADDED[gate.stage]}: p {gate.p:.2g}{', alarm' if gate.alarm else ''}"
        for gate in diagnosis.gates
    ]
    out = [f"Tests for structure: {'; '.join(gates)}."] if gates else []
    if diagnosis.remainder:
        closed, near = f"{diagnosis.remainder.closed:.0%}", diagnosis.remainder.resembles
        out.append(f"A smooth wrench that no parameter could make explains {closed} of what is left; it resembles "
                   f"{near}, which does not explain it.")  # fmt: skip
    return tuple(out)


def _next(suggested: NextLoads) -> Table:
    rows: list[tuple[str | float | None, ...]] = [
        (
            f"{entry.repeats} x " + ", ".join(f"{name} {value:g}" for name, value in entry.loads.items()),
            entry.mount,
            entry.minutes,
            entry.promised_sigma,
            " against ".join(entry.split),
        )
        for entry in suggested.suggestions
    ]
    head = ("loads", "mount", "minutes", "promised sigma", "closest then")
    return Table(
        f"To tell apart {'; '.join(suggested.names)}: {suggested.worst_before:.2g} sigma now", head, tuple(rows)
    )


def _invisible(diagnosis: Diagnosis) -> tuple[str, ...]:
    out = []
    for visible, words in (
        ("absorbed", "EA, GA and EI take in what these would do"),
        ("invisible", "too small to see"),
    ):
        names = [sight.name for sight in diagnosis.sights if sight.visible == visible]
        if names:
            out.append(f"Cannot be found here, {words}: {', '.join(names)}.")
    if diagnosis.missing:
        out.append(f"Columns that would tell more: {', '.join(diagnosis.missing)}.")
    return tuple(out)


def _sights(diagnosis: Diagnosis) -> Table:
    rows: list[tuple[str | float | None, ...]] = []
    for sight in sorted(diagnosis.sights, key=lambda sight: -sight.sigmas):
        unit = "" if sight.unit == "-" else f" {sight.unit}"
        rivals = ", ".join(f"{name} {distance:.1f}" for name, _, distance in sight.rivals[:3])
        numbers = (f"{sight.typical:g}{unit}", sight.sigmas, sight.smallest)
        rows.append((sight.name, sight.visible, *numbers, rivals, sight.cure))
    head = ("effect", "seen", "typical", "sigma at typical", "found from", "nearest, sigma apart", "would be shown by")
    return Table("Every effect of the catalogue in these poses", head, tuple(rows))


def _noise(diagnosis: Diagnosis, given: Mechanism) -> tuple[str, ...]:
    noise = diagnosis.noise
    x, z, theta = (1e3 * value for value in noise.sigma)
    origin = ", ".join(f"{name} {word}" for name, word in noise.origin.items() if word)
    times = ", ".join(f"{value:.2f}" for value in noise.scale)
    built = dimensions(diagnosis.dimensions, given.effects) or "none is given here"
    return (f"Noise assumed: x {x:.3g} mm, z {z:.3g} mm, θ {theta:.3g} mrad, forces {noise.force:.3g} N ({origin}). "
            f"Each may drift by {DRIFT:g} of it from the first to the last row. "
            f"What is left is {times} times the noise in x, z, θ.",
            f"The build may be off by its tolerances (ecm-fast effects); {built}.")  # fmt: skip


def _outliers(diagnosis: Diagnosis) -> tuple[Table, ...]:
    if not diagnosis.outliers:
        return ()
    return (Table("Rows left out", ("row", "why"), tuple(diagnosis.outliers[:_NAMES])),)
