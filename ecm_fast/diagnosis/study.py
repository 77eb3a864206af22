"""A study: a mechanism and its measurements, from the checks to the diagnosis and the page."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..data.columns import CAMERA_SIGMA, CHANNELS
from ..data.measurements import Measurements
from ..data.repeated_rows import repeated_rows, without_poses
from ..errors import InputError, real, shown
from ..identification.rows import State
from ..mechanism.mechanism import Mechanism
from ..mechanism.parameters import find
from ..models.instruments.checks.checks import check
from .answer.caveats import alarms, correlation_caveats, size_caveats, stiffness_caveats
from .answer.claims import claims, estimates
from .answer.sentences import missing_columns, nearest, sentence, verdict_of
from .checks.coverage import FEW_ROWS, coverage
from .design.detectability import distances, sights
from .problem.candidates import chosen, uncertain_parameters
from .problem.linearization import Linearization
from .problem.problem import DRIFT, Problem
from .problem.progress import Progress
from .proof.discrepancy import remainder
from .proof.external_validation import transfer
from .proof.holdout_error import Residuals, gap
from .proof.localization import compliances, where, wrenches
from .results.diagnosis import Diagnosis, Noise, RowFindings, Transfer
from .results.external_validation import not_carried
from .results.plan import Plan
from .search.fit import Fit, refit
from .search.outliers import excess_noise
from .search.selection import Selection
from .search.subsample import search_all

__all__ = ["Study", "diagnose", "plan"]

Priors = Mapping[str, tuple[float, float]]

"""Camera noise that a plan takes where nothing is declared [m, m, rad]."""


@dataclass(frozen=True, eq=False, repr=False)
class Study:
    """What there is to go by.

    Attributes
    ----------
    mechanism : as it was built, as far as is known
    data : one or several sets of measurements on it
    candidates : names that an answer may give; default the whole catalogue
    uncertain : parameters, effects or ``camera_frame`` that are known only within a standard deviation, or, with None,
        not at all: they are calibrated along with EA, GA and EI, and never named
    priors : value and standard deviation from material tests, by name
    force_sigma : noise of the force readings [N]; default as the measurements declare it
    test : measurements that are never fitted, for the proof
    alpha : chance of a false alarm on clean data
    max_effects : most effects that an answer may name
    seed : of the lock and of all draws
    progress : called with one line of text before every step of a diagnosis
    """

    mechanism: Mechanism
    data: Measurements | Sequence[Measurements]
    candidates: Sequence[str] | None = None
    uncertain: Mapping[str, float | None] = field(default_factory=dict)
    priors: Priors = field(default_factory=dict)
    force_sigma: float | None = None
    test: Measurements | Sequence[Measurements] = ()
    alpha: float = 0.01
    max_effects: int = 2
    seed: int = 0
    progress: Callable[[str], None] | None = None

    def __post_init__(self) -> None:
        if not 0.0 < real("alpha", self.alpha) < 1.0:
            raise InputError(f"alpha = {shown(self.alpha)}: allowed is a number between 0 and 1")
        if self.max_effects not in (0, 1, 2):
            raise InputError(f"max_effects = {shown(self.max_effects)}: allowed is 0, 1 or 2")
        if self.force_sigma is not None and not 0.0 <= real("force_sigma", self.force_sigma) < np.inf:
            raise InputError(f"force_sigma = {shown(self.force_sigma)}: allowed is a finite number >= 0")
        if not self.parts:
            raise InputError("no measurements; a study takes at least one set")

    @cached_property
    def parts(self) -> tuple[Measurements, ...]:
        """The sets of measurements."""
        return (self.data,) if isinstance(self.data, Measurements) else tuple(self.data)

    @cached_property
    def tests(self) -> tuple[Measurements, ...]:
        """The sets of measurements that are never fitted."""
        return (self.test,) if isinstance(self.test, Measurements) else tuple(self.test)

    @cached_property
    def fitted(self) -> tuple[Measurements, ...]:
        """The sets of measurements without the poses of rows that repeat an earlier one, sets of nothing else left out.

        The same reading under the same load is the same evidence, and is weighed once.
        """
        again = repeated_rows(self.parts)
        kept = [without_poses(part, rows) if rows.any() else part for part, rows in zip(self.parts, again, strict=True)]
        return tuple(part for part, rows in zip(kept, again, strict=True) if part.measured.any() or not rows.any())

    @cached_property
    def unseen(self) -> tuple[Measurements, ...]:
        """The test measurements without rows that are among those fitted.

        Raises
        ------
        InputError : all rows of a test are.
        """
        again = repeated_rows([*self.parts, *self.tests])[len(self.parts) :]
        kept = []
        for part, rows in zip(self.tests, again, strict=True):
            kept.append(without_poses(part, rows) if rows.any() else part)
            if rows.any() and not kept[-1].measured.any():
                raise InputError(f"{part.source}: all its {int(rows.sum())} rows are among those fitted: a test takes "
                                 "measurements that no fit has seen")  # fmt: skip
        return tuple(kept)

    def check(self) -> tuple[str, ...]:
        """Return what is noticed about the measurements, one sentence each with its cure.

        Raises
        ------
        InputError : a set cannot be used as it is, see `checks.check`, or all rows of a test are among those fitted.
        """
        known = {"lam_N": self.force_sigma} if self.force_sigma else {}
        enough = sum(int(part.measured.any(axis=1).sum()) for part in self.parts) >= FEW_ROWS
        lines = list[str]()
        for part in self.parts:
            found = [*check(self.mechanism, part).findings, *coverage(part.with_noise(known))]
            texts = [str(finding) for finding in found if not (enough and finding.kind == "few rows")]
            lines += [f"{part.source}: {text}" for text in texts] if len(self.parts) > 1 else texts
        lines += self._repeated_across()
        for part in self.unseen:
            check(self.mechanism, part)  # a wrong sign or unit there would look like an effect that does not carry over
        return tuple(lines)

    def _repeated_across(self) -> Iterator[str]:
        """Yield a line for every set whose rows repeat those of an earlier one."""
        across = repeated_rows([*self.parts, *self.tests])
        for part, rows in zip((*self.parts, *self.tests), across, strict=True):
            count = int((rows & ~repeated_rows([part])[0]).sum())
            if count:
                yield (f"{part.source}: {count} of {part.n} rows repeat rows of the files before to the last digit: "
                       "the same evidence, which counts once")  # fmt: skip

    def problem(self, data: Sequence[Measurements] | None = None, progress: Progress | None = None) -> Problem:
        """Return what the diagnosis works on."""
        uncertain = uncertain_parameters(self.uncertain)
        candidates = [entry for entry in chosen(self.candidates, self.mechanism) if entry.keys[0] not in uncertain]
        parts = self.fitted if data is None else tuple(data)
        return Problem(self.mechanism, parts, candidates, uncertain, self.priors,
                       force_sigma=self.force_sigma, seed=self.seed, progress=progress)  # fmt: skip

    def plan(self) -> Plan:
        """Return what the loads can tell, whatever will be measured."""
        from ..models.instruments.prediction import predict

        parts = [_blank_filled(part, predict(self.mechanism, part).pose) for part in self.parts]
        problem = self.problem(parts)
        values = dict(zip(problem.keys, problem.start(problem.keys).tolist(), strict=True))
        noise = problem.noise(problem.rows.at(problem.start(problem.keys)))
        view = Linearization.at(problem, values, (), noise, known=True)
        _, cosine, apart = distances(view)
        lost = int((~problem.state((), values).stable).sum())
        return Plan(
            rows=problem.rows.n,
            sights=sights(view, self.alpha, self.seed),
            names=tuple(candidate.name for candidate in problem.candidates),
            cosines=cosine,
            distances=apart,
            noise=_in_words(view),
            missing=missing_columns(problem),
            warnings=(f"{lost} loads have no stable equilibrium",) if lost else (),
        )

    def diagnose(self) -> Diagnosis:
        """Return what is missing, and the proof."""
        begin, noticed = time.perf_counter(), self.check()
        problem = self.problem(progress=Progress(self.progress))
        found = search_all(problem, self.alpha, self.max_effects, self.seed)
        problem.progress.begin("proof")
        return _answer(self, problem, found, noticed, begin)


def diagnose(
    mechanism: Mechanism,
    data: Measurements | Sequence[Measurements],
    *,
    candidates: Sequence[str] | None = None,
    uncertain: Mapping[str, float | None] | None = None,
    priors: Priors | None = None,
    force_sigma: float | None = None,
    test: Measurements | Sequence[Measurements] = (),
    alpha: float = 0.01,
    max_effects: int = 2,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> Diagnosis:
    """Return which effect the model is missing, with its look-alikes and the proof; the arguments are `Study`'s.

    Raises
    ------
    InputError : a name or a number cannot be meant, or there are too few rows; says what is allowed.
    NotConverged : the mechanism has no stable equilibrium under any of the loads.
    """
    return Study(mechanism, data, candidates, uncertain or {}, priors or {}, force_sigma, test, alpha, max_effects,
                 seed, progress).diagnose()  # fmt: skip


def plan(
    mechanism: Mechanism,
    data: Measurements | Sequence[Measurements],
    *,
    candidates: Sequence[str] | None = None,
    uncertain: Mapping[str, float | None] | None = None,
    priors: Priors | None = None,
    force_sigma: float | None = None,
    alpha: float = 0.01,
    seed: int = 0,
) -> Plan:
    """Return which names the loads of `data` can carry, before anything is measured; the arguments are `Study`'s."""
    return Study(mechanism, data, candidates, uncertain or {}, priors or {}, force_sigma, alpha=alpha, seed=seed).plan()


def _blank_filled(data: Measurements, pose: NDArray[np.float64]) -> Measurements:
    """Return measurements with the poses that the model predicts, and with noise where none is declared."""
    columns = dict(zip(CHANNELS, pose.T.copy(), strict=True))
    for name, sigma in zip(("sigma_x", "sigma_z", "sigma_theta"), CAMERA_SIGMA, strict=True):
        own = getattr(data, name)
        columns[name] = np.where(np.isfinite(own) & (own > 0.0), own, sigma)
    return replace(data, **columns)


def _in_words(view: Linearization) -> str:
    x, z, theta = (_median(column[np.isfinite(column)]) for column in view.weights.sigma[view.rows].T)
    force = float(np.median(view.noise.force))
    return (f"noise {1e3 * x:.3g} mm, {1e3 * z:.3g} mm, {1e3 * theta:.3g} mrad, forces {force:.3g} N, a drift of "
            f"{DRIFT:g} of it from first to last row, and a build within its tolerances")  # fmt: skip


def _answer(study: Study, problem: Problem, found: Selection, noticed: tuple[str, ...], begin: float) -> Diagnosis:
    baseline, view, best = found.baseline, found.view, found.best
    before, after = found.null.state(problem), best.state(problem)
    around = problem.state(problem.keys_of(view.model), view.values)
    weights = problem.weights(view.noise, around)
    without = _without_each(found)
    lacking = {problem.candidates[i].name: fit.state(problem) for i, fit in without.items() if fit.model}
    opened = Residuals.of(problem, before, after, weights, found.scale, lacking)
    shown_gap, far = gap(problem, opened, problem.locked, "rows set aside", study.seed)
    effects, missing = claims(found, without), missing_columns(problem)
    seen = sights(baseline, study.alpha, study.seed)
    verdict = verdict_of(effects, outside=found.outside, gap_in_data=bool(missing) and view.cleaned.memory > 0.2)
    left = None
    if verdict in ("outside_catalogue", "data_gap"):
        left = remainder(problem, view, opened, compliances(problem, before), problem.locked)
    calibrated_now, noise = estimates(best, found), _noise(view)
    tests = _transfer(study, found, noise)
    lost = [*((int(i), "outlier") for i in [*view.outliers, *far]),
            *((int(i), "no stable equilibrium") for i in np.flatnonzero(~around.stable))]  # fmt: skip
    return Diagnosis(
        verdict=verdict,
        sentence=sentence(verdict, effects, shown_gap, seen, missing, left, tests, study.candidates),
        effects=effects,
        calibration=calibrated_now,
        before=estimates(found.null, found),
        dimensions=_by_name(best.build),
        dimensions_before=_by_name(found.null.build),
        mechanism=problem.mechanism.replace(**best.as_built()),
        gap=shown_gap,
        transfer=tests,
        models=found.models(),
        gates=found.gates,
        sights=seen,
        noise=noise,
        where=where(baseline, study.seed) if any(gate.alarm for gate in found.gates) else None,
        remainder=left,
        outliers=tuple((problem.rows.where(i), reason) for i, reason in lost),
        missing=missing,
        noticed=noticed,
        warnings=(
            *not_carried(tests, [claim.name for claim in effects]),
            *found.doubts,
            *(excess_noise(view) if found.effects else ()),
            *nearest(found),
            *size_caveats(effects, problem.mechanism),
            *correlation_caveats(best, problem.candidates),
            *stiffness_caveats(calibrated_now, problem.mechanism, {find(name).name for name in study.priors}),
        ),
        alarms=alarms(found),
        rows=_rows(problem, opened, before, view, far),
        seconds=time.perf_counter() - begin,
    )


def _without_each(found: Selection) -> dict[int, Fit]:
    """Return, by the place of each effect found, the fit of all but it; the most needed one comes first."""
    best = found.best
    rest = {i: tuple(other for other in best.model if other != i) for i in best.model}
    fits = {i: refit(found.view, others, best.by_key()) if others else found.null for i, others in rest.items()}
    return dict(sorted(fits.items(), key=lambda item: -item[1].total))


def _by_name(values: Mapping[str, float]) -> dict[str, float]:
    return {find(key).name: value for key, value in values.items()}


def _transfer(study: Study, found: Selection, noise: Noise) -> tuple[Transfer, ...]:
    """Return the gap on every experiment that was never fitted."""
    parts = (transfer(study.problem([part]), found, noise, study.seed) for part in study.unseen)
    return tuple(entry for entry in parts if entry)


def _noise(view: Linearization) -> Noise:
    sigma = np.array([_median(view.weights.sigma[view.rows][view.used[:, i], i]) for i in range(3)])
    origin = {
        name: " and ".join(sorted(set(view.noise.origin[view.rows][view.used[:, i], i].tolist())))
        for i, name in enumerate(CHANNELS)
    }
    x, z, theta = (float(value) for value in sigma)
    a, b, c = (float(value) for value in view.cleaned.scale)
    force = float(np.median(view.noise.force))
    return Noise((x, z, theta), force, origin, (a, b, c), view.cleaned.tail, view.cleaned.memory)


def _median(values: NDArray[np.float64]) -> float:
    """Return the median; nan of none."""
    return float(np.median(values)) if values.size else np.nan


def _rows(
    problem: Problem, opened: Residuals, state: State, view: Linearization, far: NDArray[np.int64]
) -> RowFindings:
    outlier = np.zeros(problem.rows.n, dtype=bool)
    outlier[[*view.outliers, *far]] = True
    used = np.zeros((problem.rows.n, 3), dtype=bool)
    used[view.rows] = view.used
    compliance = compliances(problem, state)
    return RowFindings(
        data=problem.data,
        locked=problem.locked,
        outlier=outlier,
        used=used,
        before=opened.before,
        after=opened.after,
        sigma=opened.spread(),
        wrench_before=wrenches(opened.before, compliance),
        wrench_after=wrenches(opened.after, compliance),
    )
