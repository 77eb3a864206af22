"""The element study: error against a converged solution, and time, for any mechanism."""

import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...data.measurements import Measurements
from ...errors import InputError, NotConverged, shown
from ...mechanism.mechanism import Mechanism
from ...models.finite_element import FiniteElementModel
from .candidates import Candidate, candidates
from .errors import ROUNDING, Converged, LoadSet, converged, errors, short

__all__ = [
    "Choice",
    "ElementStudy",
    "Measured",
    "choose_discretization",
    "needed",
    "pareto",
    "recommended",
    "study_elements",
]

Array = NDArray[np.float64]
# the largest error of 300 cases is above the 99th percentile with 95 %; a thousand others confirm it
_CASES, _FRESH = 300, 1000
# a repetition that is shorter than a turn of the scheduler, of fewer cases than a batch fits its start to
_SHORT, _ROUNDS, _MOST_CASES = 2e-3, 7, 1000


@dataclass(frozen=True, repr=False)
class Measured:
    """Cost and error of one candidate; errors are the largest of x/L, z/L and theta.

    Attributes
    ----------
    unknowns : free coordinates of the nodes
    error, median : over the load cases; inf where a case has no stable equilibrium
    position : largest distance of the tip from its place, as a share of the length
    worst : (5,) tendon forces and dead wrench of the largest error [N, N, N, N, N m]
    failed : how many cases have no stable equilibrium
    time : of one solve in a batch on one core, from the straight beam to 1e-9 [s]
    """

    candidate: Candidate
    unknowns: int
    error: float
    median: float
    position: float
    worst: tuple[float, ...]
    failed: int
    time: float

    @property
    def sentence(self) -> str:
        """Kind, error and cost in words: "one quartic element: 2e-7, 0.6 us"."""
        return f"{self.candidate.name}: {short(self.error)}, {self.microseconds}"

    @property
    def microseconds(self) -> str:
        """Its time with two digits: "0.6 us"."""
        return f"{float(f'{self.time * 1e6:.2g}'):g} us"

    def __repr__(self) -> str:
        return f"Measured({self.sentence})"


@dataclass(frozen=True, repr=False)
class ElementStudy:
    """All candidates beside one another.

    Attributes
    ----------
    rows : one a candidate, in the order given
    known : what errors were measured against
    tolerance : that was asked for
    """

    mechanism: Mechanism
    rows: tuple[Measured, ...]
    known: Converged
    tolerance: float

    @property
    def recommended(self) -> Measured | None:
        """The fastest that keeps the tolerance, if any."""
        return recommended(self.rows, self.tolerance)

    @property
    def front(self) -> tuple[Measured, ...]:
        """Those that none beats both in time and in error, the fastest first."""
        return pareto(self.rows, max(self.known.error, ROUNDING))

    @property
    def sentence(self) -> str:
        """The recommendation in one sentence."""
        best = self.recommended
        return _none_keeps(self.rows, self.tolerance) if best is None else best.sentence

    def __repr__(self) -> str:
        return f"ElementStudy({len(self.rows)} candidates; for {self.tolerance:g}: {self.sentence})"


@dataclass(frozen=True, repr=False)
class Choice:
    """The cheapest model that keeps a tolerance.

    Attributes
    ----------
    model : ready to solve
    measured : what it costs and leaves on the loads it was chosen on
    fresh_error : largest error on loads that it was not chosen on
    runner_ups : the next that keep the tolerance on the first loads, by time
    """

    model: FiniteElementModel
    measured: Measured
    fresh_error: float
    runner_ups: tuple[Measured, ...]

    @property
    def error(self) -> float:
        """Largest error on the loads it was chosen on."""
        return self.measured.error

    def __repr__(self) -> str:
        return f"Choice({self.measured.sentence}; on fresh loads {short(self.fresh_error)})"


def study_elements(
    mechanism: Mechanism | None = None,
    loads: "str | Measurements | LoadSet | ArrayLike" = "tendons",
    tolerance: float = 1e-3,
    *,
    compared: Sequence[Candidate] | None = None,
    family: str | None = None,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> ElementStudy:
    """Measure error and time of every candidate.

    Parameters
    ----------
    mechanism : what is divided; default the preset
    loads : "tendons" or "box", of which 300 are drawn, or load cases, see `LoadSet.of`
    tolerance : of the tip pose, in shares of the length and rad, for the recommendation
    compared : the candidates; default `candidates` of the mechanism
    family : the only one of which the default candidates are, see `mechanism.mesh.families`; default all
    seed : of the drawn loads
    progress : called with one line of text before every part

    Raises
    ------
    InputError : no case holds the neck in a stable pose, or the tolerance is no positive number.
    """
    neck = Mechanism() if mechanism is None else mechanism
    if not 0.0 < tolerance < math.inf:
        raise InputError(f"tolerance = {shown(tolerance)}: allowed is a positive number")
    chosen = compared or candidates(neck, family)
    cases = LoadSet.drawn(loads, _CASES, seed) if isinstance(loads, str) else LoadSet.from_loads(loads)
    known = converged(neck, cases)
    return ElementStudy(neck, _measure(neck, chosen, known, progress), known, tolerance)


def _measure(
    mechanism: Mechanism, compared: Sequence[Candidate], known: Converged, progress: Callable[[str], None] | None
) -> tuple[Measured, ...]:
    models: list[FiniteElementModel] = []
    found, guesses, announced = [], [], ""
    for i, candidate in enumerate(compared):
        what = f"{candidate.kind} elements, {candidate.mesh}"
        if progress is not None and what != announced:
            done, announced = 20 * i // len(compared), what
            progress(f"[{'#' * done}{'.' * (20 - done)}] {what}")
        model = candidate.model(mechanism)
        known.loads.select(np.arange(1)).solve(model)  # what is made on first use is not timed
        start = time.perf_counter()
        found.append(errors(model, known))
        guesses.append((time.perf_counter() - start) / len(known.loads))
        models.append(model)
    if progress is not None:
        progress(f"[{'#' * 20}] times of {len(compared)} candidates, in turn")
    times = _times(models, known.loads, guesses)
    return tuple(
        _measured(candidate, model, off, known.loads, seconds)
        for candidate, model, off, seconds in zip(compared, models, found, times, strict=True)
    )


def _measured(
    candidate: Candidate, model: FiniteElementModel, both: tuple[Array, Array], loads: LoadSet, seconds: float
) -> Measured:
    (off, distance), worst = both, int(np.argmax(both[0]))
    where = (*loads.lam[worst].tolist(), *loads.wrench[worst].tolist())
    sizes = float(off[worst]), float(np.median(off)), float(distance.max())
    failed, unknowns = int(np.isinf(off).sum()), 3 * (model.discretization.nodes.size - 1)
    return Measured(candidate, unknowns, *sizes, where, failed, seconds)


def _times(models: Sequence[FiniteElementModel], loads: LoadSet, guesses: Sequence[float]) -> list[float]:
    """Least time of one case in a batch [s], from short repetitions in turn, so that all meet the same machine."""
    rows = np.resize(np.arange(len(loads)), _MOST_CASES)
    best = [math.inf] * len(models)
    for _ in range(_ROUNDS):
        for i, (model, guess) in enumerate(zip(models, guesses, strict=True)):
            timed = rows[: int(np.clip(_SHORT / min(guess, best[i]), 2, _MOST_CASES))]
            lam, wrench = loads.lam[timed], loads.wrench[timed]
            start = time.perf_counter()
            model.solve_batch(lam, wrench, path="ignore")
            best[i] = min(best[i], (time.perf_counter() - start) / len(timed))
    return best


def recommended(rows: Sequence[Measured], tolerance: float) -> Measured | None:
    """Return the fastest that keeps a tolerance, if any."""
    return min((row for row in rows if row.error <= tolerance), key=lambda row: row.time, default=None)


def pareto(rows: Sequence[Measured], resolution: float = 0.0) -> tuple[Measured, ...]:
    """Return those that none beats both in time and in error, the fastest first; errors count from `resolution` up."""
    front: list[Measured] = []
    for row in sorted(rows, key=lambda row: (row.time, row.error)):
        if math.isfinite(row.error) and (not front or max(row.error, resolution) < max(front[-1].error, resolution)):
            front.append(row)
    return tuple(front)


def needed(known: Iterable[tuple[int, float]], tolerance: float) -> int | None:
    """Return how many elements keep a tolerance, by a power law between those known; None: more than those.

    known : numbers of elements and their errors
    """
    fewer, larger = 0, math.inf
    for count, error in sorted(known):
        if error <= tolerance:
            if fewer == 0 or not math.isfinite(larger) or error == 0.0:
                return count
            share = math.log(larger / tolerance) / math.log(larger / error)
            between = fewer * math.exp(share * math.log(count / fewer))
            return min(count, max(fewer + 1, math.ceil(between)))
        fewer, larger = count, error
    return None


def choose_discretization(
    mechanism: Mechanism | None = None,
    loads: "str | Measurements | LoadSet | ArrayLike" = "tendons",
    tolerance: float = 1e-6,
    *,
    compared: Sequence[Candidate] | None = None,
    family: str | None = None,
    seed: int = 0,
) -> Choice:
    """Return the cheapest model that keeps a tolerance of the tip pose, checked on loads it was not chosen on.

    Parameters
    ----------
    mechanism, tolerance, compared, family, seed : as for `study_elements`
    loads : "tendons" or "box", of which 300 are drawn to choose and 1000 to check; or load cases, half for each

    Raises
    ------
    InputError : no candidate keeps the tolerance; names the best one and its error.
    NotConverged : the converged solution is not known ten times better than the tolerance.
    """
    neck = Mechanism() if mechanism is None else mechanism
    first, fresh = _two_sets(loads, np.random.default_rng(seed))
    study = study_elements(neck, first, tolerance, compared=compared, family=family)
    check = converged(neck, fresh)
    doubt = max(study.known.error, check.error)
    if doubt > 0.1 * tolerance:
        raise NotConverged(f"errors are known to {short(doubt)} only, too coarse for tolerance = {tolerance:g}")
    keep = sorted((row for row in study.rows if row.error <= tolerance), key=lambda row: row.time)
    for i, row in enumerate(keep):
        model = row.candidate.model(neck)
        if (fresh_error := float(errors(model, check)[0].max())) <= tolerance:
            return Choice(model, row, fresh_error, tuple(keep[i + 1 :]))
    raise InputError(_none_keeps(study.rows, tolerance))


def _two_sets(loads: "str | Measurements | LoadSet | ArrayLike", rng: np.random.Generator) -> tuple[LoadSet, LoadSet]:
    if isinstance(loads, str):
        return LoadSet.drawn(loads, _CASES, rng), LoadSet.drawn(loads, _FRESH, rng, corners=False)
    whole = LoadSet.from_loads(loads)
    if len(whole) < 2:
        raise InputError(f"loads: {len(whole)} cases: allowed are 2 or more, half to choose on and half to check on")
    order = rng.permutation(len(whole))
    return whole.select(order[::2]), whole.select(order[1::2])


def _none_keeps(rows: Sequence[Measured], tolerance: float) -> str:
    best = min(rows, key=lambda row: row.error)
    return (f"tolerance = {tolerance:g}: no candidate keeps it; the best, {best.candidate.name}, leaves "
            f"{short(best.error)}; allow that or compare finer ones")  # fmt: skip
