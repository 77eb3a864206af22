"""Assembly of a diagnosis from what the search selected, and of a plan from what loads can show."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ...data.columns import CHANNELS
from ...identification.rows import State
from ...mechanism.parameters import find
from ..design.detectability import detectabilities, distances
from ..problem.linearization import Linearization
from ..problem.problem import DRIFT, Problem
from ..proof.discrepancy import remainder
from ..proof.external_validation import transfer
from ..proof.holdout_error import Residuals, gap
from ..proof.localization import compliances, where, wrenches
from ..results.diagnosis import Diagnosis, Noise, RowFindings
from ..results.external_validation import not_carried
from ..results.plan import Plan
from ..search.fit import Fit, refit
from ..search.outliers import excess_noise
from ..search.result import Selection
from .caveats import alarms, correlation_caveats, mesh_caveats, stiffness_caveats
from .claims import claims, estimates
from .sentences import missing_columns, nearest, sentence, verdict_of

__all__ = ["assemble", "assemble_plan"]


def assemble_plan(problem: Problem, alpha: float, seed: int) -> Plan:
    """Return what the loads of a problem can tell, its poses being those of the model."""
    values = dict(zip(problem.keys, problem.start(problem.keys).tolist(), strict=True))
    noise = problem.noise(problem.rows.at(problem.start(problem.keys)))
    view = Linearization.at(problem, values, (), noise, known=True)
    _, cosine, separation = distances(view)
    lost = int((~problem.state((), values).stable).sum())
    return Plan(
        rows=problem.rows.n,
        sights=detectabilities(view, alpha, seed),
        names=tuple(candidate.name for candidate in problem.candidates),
        cosines=cosine,
        distances=separation,
        noise=_in_words(view),
        missing=missing_columns(problem),
        warnings=(f"{lost} loads have no stable equilibrium",) if lost else (),
    )


def _in_words(view: Linearization) -> str:
    x, z, theta = (_median(column[np.isfinite(column)]) for column in view.weights.sigma[view.rows].T)
    force = float(np.median(view.noise.force))
    return (f"noise {1e3 * x:.3g} mm, {1e3 * z:.3g} mm, {1e3 * theta:.3g} mrad, forces {force:.3g} N, a drift of "
            f"{DRIFT:g} of it from first to last row, and a build within its tolerances")  # fmt: skip


def assemble(
    problem: Problem,
    selection: Selection,
    tests: Sequence[Problem],
    *,
    alpha: float,
    seed: int,
    only: Sequence[str] | None = None,
    known: Collection[str] = (),
    noticed: tuple[str, ...] = (),
) -> Diagnosis:
    """Return the answer with its proof.

    Parameters
    ----------
    problem : that was searched
    found : what the search selected
    tests : problems of experiments that were never fitted
    alpha, seed : of the search
    only : the names that may be given, where these are not the whole catalogue
    known : stiffnesses of which material tests say what takes the place of the mechanism's value
    noticed : findings about the measurements
    """
    baseline, view, best = selection.baseline, selection.view, selection.best
    before, after = selection.null.state(problem), best.state(problem)
    around = problem.state(problem.keys_of(view.model), view.values)
    weights = problem.weights(view.noise, around)
    without = _without_each(selection)
    lacking = {problem.candidates[i].name: fit.state(problem) for i, fit in without.items() if fit.model}
    opened = Residuals.from_states(problem, before, after, weights, selection.scale, lacking)
    shown_gap, far = gap(problem, opened, problem.locked, "rows set aside", seed)
    effects, missing = claims(selection, without), missing_columns(problem)
    seen = detectabilities(baseline, alpha, seed)
    verdict = verdict_of(effects, outside=selection.outside, gap_in_data=bool(missing) and view.cleaned.memory > 0.2)
    left = None
    if verdict in ("outside_catalogue", "data_gap"):
        left = remainder(problem, view, opened, compliances(problem, before), problem.locked)
    calibrated_now, noise = estimates(best, selection), _noise(view)
    transfers = tuple(entry for test in tests if (entry := transfer(test, selection, noise, seed)))
    lost = [*((int(i), "outlier") for i in [*view.outliers, *far]),
            *((int(i), "no stable equilibrium") for i in np.flatnonzero(~around.stable))]  # fmt: skip
    return Diagnosis(
        verdict=verdict,
        sentence=sentence(verdict, effects, shown_gap, seen, missing, left, transfers, only),
        effects=effects,
        calibration=calibrated_now,
        before=estimates(selection.null, selection),
        dimensions=_by_name(best.build),
        dimensions_before=_by_name(selection.null.build),
        mechanism=problem.mechanism.replace(**best.as_built()),
        gap=shown_gap,
        transfer=transfers,
        models=selection.models(),
        gates=selection.gates,
        sights=seen,
        noise=noise,
        where=where(baseline, seed) if any(gate.alarm for gate in selection.gates) else None,
        remainder=left,
        outliers=tuple((problem.rows.where(i), reason) for i, reason in lost),
        missing=missing,
        noticed=noticed,
        warnings=(
            *not_carried(transfers, [claim.name for claim in effects]),
            *selection.doubts,
            *(excess_noise(view) if selection.effects else ()),
            *nearest(selection),
            *mesh_caveats(problem.unresolved),
            *correlation_caveats(best, problem.candidates),
            *stiffness_caveats(calibrated_now, problem.mechanism, {find(name).name for name in known}),
        ),
        alarms=alarms(selection),
        rows=_rows(problem, opened, before, view, far),
        seconds=0.0,
    )


def _without_each(selection: Selection) -> dict[int, Fit]:
    """Return, by the place of each effect found, the fit of all but it; the most needed one comes first."""
    best = selection.best
    rest = {i: tuple(other for other in best.model if other != i) for i in best.model}
    fits = {i: refit(selection.view, others, best.by_key()) if others else selection.null for i, others in rest.items()}
    return dict(sorted(fits.items(), key=lambda item: -item[1].total))


def _by_name(values: Mapping[str, float]) -> dict[str, float]:
    return {find(key).name: value for key, value in values.items()}


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
