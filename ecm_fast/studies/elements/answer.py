"""The text of an element study: the smallest number of elements, and their family.

Every sentence is about candidates that the study compared; where one of them is missing, so is the sentence.
"""

import math
from collections.abc import Iterable, Iterator

from .errors import short
from .study import ElementStudy, Measured, needed

__all__ = ["ASKED", "answer", "by_kind", "counts_needed"]

ASKED = (1e-3, 1e-4, 1e-6)  # accuracies of the answer: a picture, a camera of 0.01 mm, the default of a model
_PAPER = 20  # linear elements, in the paper's comparison of times
_ORDERS = ("linear", "quadratic", "cubic", "quartic", "quintic", "sextic")
_STRAINS = (("linear-strain", "quadratic"), ("quadratic-strain", "cubic"), ("cubic-strain", "quartic"))


def answer(study: ElementStudy) -> tuple[str, ...]:
    """Return the answer, a paragraph a text."""
    measured = _MeasuredByKind(study)
    parts = _how_few(study), _to_one(measured), _locking(measured), _knowing(measured), _uneven(measured)
    return tuple(text for text in (" ".join(sentences) for sentences in parts) if text)


def by_kind(study: ElementStudy) -> dict[str, list[Measured]]:
    """Return what was measured, by kind."""
    kinds: dict[str, list[Measured]] = {}
    for row in study.rows:
        kinds.setdefault(row.candidate.kind, []).append(row)
    return kinds


def counts_needed(study: ElementStudy) -> dict[str, list[int | None]]:
    """Return, for every kind, how many equal elements it takes for each of `ASKED`; None: more than were tried."""
    counts = {}
    for kind, rows in by_kind(study).items():
        even = [(row.candidate.elements, row.error) for row in rows if row.candidate.mesh == "even"]
        counts[kind] = [needed(even, asked) for asked in ASKED]
    return counts


class _MeasuredByKind:
    """Measured candidates by kind, number of elements and mesh; None where one was not."""

    def __init__(self, study: ElementStudy) -> None:
        self._known = study.known.error
        self._rows = {(row.candidate.kind, row.candidate.elements, row.candidate.mesh): row for row in study.rows}
        self.meshes = {row.candidate.mesh for row in study.rows} - {"even"}

    def __call__(self, kind: str, elements: int, mesh: str = "even") -> Measured | None:
        row = self._rows.get((kind, elements, mesh))
        return row if row is not None and 0.0 < row.error < math.inf else None

    def power(self, kind: str) -> float:
        """Power of the element length with which the error falls, between the two finest above rounding, or nan."""
        even = sorted(row.candidate.elements for row in self._rows.values()
                      if (row.candidate.kind, row.candidate.mesh) == (kind, "even")
                      and 100.0 * self._known < row.error < math.inf)[-2:]  # fmt: skip
        if len(even) < 2:
            return math.nan
        errors = [self._rows[kind, count, "even"].error for count in even]
        return math.log(errors[0] / errors[1]) / math.log(even[1] / even[0])

    def pairs(
        self, pairs: Iterable[tuple[tuple[str, int, str], tuple[str, int, str]]]
    ) -> list[tuple[Measured, Measured]]:
        """Return those pairs of which both were measured."""
        both = ((self(*one), self(*other)) for one, other in pairs)
        return [(one, other) for one, other in both if one is not None and other is not None]


def _how_few(study: ElementStudy) -> Iterator[str]:
    most = {kind: max(row.candidate.elements for row in rows) for kind, rows in by_kind(study).items()}
    counts = counts_needed(study)
    texts = [f"{_series(counts[kind], most[kind])} {kind}" for kind in _ORDERS[:4] if kind in counts]
    if texts:
        asked = _joined([short(error) for error in ASKED])
        yield f"To keep errors of the tip below {asked} it takes {'; '.join(texts)} elements of equal length."


def _to_one(measured: _MeasuredByKind) -> Iterator[str]:
    single = [row for row in (measured(kind, 1) for kind in _ORDERS) if row is not None]
    paper = measured("linear", _PAPER)
    better = [row for row in single if paper is not None and row.error <= paper.error]
    if better and paper is not None:
        yield (f"The number can be reduced to one: {_costs(better[0])} is more exact than {_costs(paper)}: "
               f"{short(better[0].error)} against {short(paper.error)}.")  # fmt: skip
        if rest := [f"{row.candidate.kind} {short(row.error)}" for row in better[1:]]:
            yield f"Of higher order, one leaves: {', '.join(rest)}."
    elif single and paper is not None:
        least = min(single, key=lambda row: row.error)
        yield (f"The number cannot be reduced to one: the best single element, {least.candidate.kind}, leaves "
               f"{short(least.error)}, {paper.candidate.name} leave {short(paper.error)}.")  # fmt: skip


def _locking(measured: _MeasuredByKind) -> Iterator[str]:
    for loose, locked in measured.pairs([(("linear", _PAPER, "even"), ("linear, 2 Gauss points", _PAPER, "even"))]):
        yield (f"With two Gauss points linear elements lock in shear: {_PAPER} leave {short(locked.error)}, "
               f"{_times(locked, loose)} times what they leave with one.")  # fmt: skip


def _knowing(measured: _MeasuredByKind) -> Iterator[str]:
    for arcs, lines in measured.pairs([(("SE(2)", _PAPER, "even"), ("linear", _PAPER, "even"))]):
        yield (f"Elements that know the deformed centerline as an arc of constant strains, SE(2), leave "
               f"{_times(arcs, lines)} times the error of as many linear ones, {short(arcs.error)} for {_PAPER}; the "
               f"errors fall with the powers {measured.power('SE(2)'):.2f} and {measured.power('linear'):.2f} of the "
               f"element length, theory says 2.")  # fmt: skip
    kinds = [((strain, 1, "even"), (lagrange, 1, "even")) for strain, lagrange in _STRAINS]
    if ratios := [f"{_times(one, other)} ({one.candidate.kind})" for one, other in measured.pairs(kinds)]:
        yield (f"One element of polynomial strains leaves, beside the Lagrange element with as many unknowns, "
               f"{_joined(ratios)} times the error.")  # fmt: skip
    for higher, arcs in measured.pairs([(("quadratic", _PAPER // 2, "even"), ("SE(2)", _PAPER, "even"))]):
        yield (f"A higher order gains {'more' if higher.error < arcs.error else 'less'}: {higher.candidate.name}, with "
               f"as many unknowns as {arcs.candidate.name}, leave {short(higher.error)} instead of "
               f"{short(arcs.error)}, {higher.microseconds} instead of {arcs.microseconds} a solve.")  # fmt: skip
        yield ("The reason: with as many Gauss points as the order, Lagrange elements leave the strains there free, "
               "and rebuild the centerline from them as strain elements do.")  # fmt: skip


def _uneven(measured: _MeasuredByKind) -> Iterator[str]:
    for mesh in sorted(measured.meshes):
        kinds = [((kind, n, mesh), (kind, n, "even")) for kind in (*_ORDERS, "SE(2)") for n in (3, 4, 10)]
        texts = [
            f"{one.candidate.elements} {one.candidate.kind} {short(one.error)} instead of {short(other.error)}"
            for one, other in measured.pairs(kinds)
        ]
        if texts:
            yield f"Elements {mesh} leave, beside as many equal ones: {'; '.join(texts)}."


def _costs(row: Measured) -> str:
    return f"{row.candidate.name} ({row.unknowns} unknowns, {row.microseconds})"


def _times(one: Measured, other: Measured) -> str:
    return f"{one.error / other.error:.2g}"


def _series(counts: list[int | None], most: int) -> str:
    return _joined([f"more than {most}" if count is None else str(count) for count in counts])


def _joined(words: list[str]) -> str:
    return f"{', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else words[0]
