"""A study: a mechanism and its measurements, from the checks to the diagnosis, the next loads and the page."""

import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data.columns import CAMERA_SIGMA, CHANNELS
from ..data.measurements import Measurements
from ..data.repeated_rows import repeated_rows, without_poses
from ..diagnosis.answer.assembly import assemble, assemble_plan
from ..diagnosis.checks.coverage import FEW_ROWS, coverage
from ..diagnosis.checks.symmetry import parity
from ..diagnosis.design.next_loads import MOST_RIVALS, NextLoads, Pool, fitted_rivals, in_question, next_loads
from ..diagnosis.problem.candidates import chosen, uncertain_parameters
from ..diagnosis.problem.problem import Problem
from ..diagnosis.problem.progress import Progress
from ..diagnosis.results.diagnosis import Diagnosis
from ..diagnosis.results.plan import Plan
from ..diagnosis.search.subsample import search_all
from ..errors import InputError, real, shown
from ..identification.noise import check_force_sigma
from ..mechanism.mechanism import Mechanism
from ..models.instruments.checks.checks import check
from ..models.instruments.prediction import predict
from ..models.instruments.rest_pose import absolute, free_origins

__all__ = ["Study", "diagnose", "plan"]

Priors = Mapping[str, tuple[float, float]]


@dataclass(frozen=True, eq=False, repr=False)
class Study:
    """Mechanism, measurements and what is known of them.

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
    progress : called with one line of text before every step
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
        check_force_sigma(self.force_sigma)
        if not isinstance(self.data, Measurements) and not self.data:
            raise InputError("no measurements; a study takes at least one set")

    @cached_property
    def parts(self) -> tuple[Measurements, ...]:
        """The sets of measurements, poses relative to the clamp."""
        given = (self.data,) if isinstance(self.data, Measurements) else self.data
        return tuple(absolute(self.mechanism, part) for part in given)

    @cached_property
    def tests(self) -> tuple[Measurements, ...]:
        """The sets of measurements that are never fitted, poses relative to the clamp."""
        given = (self.test,) if isinstance(self.test, Measurements) else self.test
        return tuple(absolute(self.mechanism, part) for part in given)

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
        free = dict.fromkeys(free_origins([*self.parts, *self.tests]), np.inf)
        uncertain = {**free, **uncertain_parameters(self.uncertain)}
        candidates = [entry for entry in chosen(self.candidates, self.mechanism) if entry.keys[0] not in uncertain]
        parts = self.fitted if data is None else tuple(data)
        return Problem(self.mechanism, parts, candidates, uncertain, self.priors,
                       force_sigma=self.force_sigma, seed=self.seed, progress=progress)  # fmt: skip

    def plan(self) -> Plan:
        """Return what the loads can tell, whatever will be measured."""
        self.mechanism.check_pair("a plan")
        parts = [_blank_filled(part, predict(self.mechanism, part).pose) for part in self.parts]
        return assemble_plan(self.problem(parts), self.alpha, self.seed)

    def diagnose(self) -> Diagnosis:
        """Return what is missing, and the proof.

        Raises
        ------
        InputError : see `check`, or there are too few rows.
        NotConverged : the mechanism has no stable equilibrium under any of the loads.
        """
        begin, noticed = time.perf_counter(), self.check()
        problem = self.problem(progress=Progress(self.progress))
        found = search_all(problem, self.alpha, self.max_effects, self.seed)
        problem.progress.begin("proof")
        tests = [self.problem([part]) for part in self.unseen]
        answer = assemble(problem, found, tests, alpha=self.alpha, seed=self.seed, only=self.candidates,
                          known=self.priors, noticed=noticed)  # fmt: skip
        return replace(answer, seconds=time.perf_counter() - begin)

    def next_loads(
        self,
        diagnosis: Diagnosis | Mapping[str, Any],
        *,
        minutes: float = 20.0,
        repeats: int = 3,
        pool: Pool | None = None,
        check_single: bool = False,
    ) -> NextLoads | None:
        """Return which loads to measure next so that look-alikes come apart; None where there are none.

        Parameters
        ----------
        found : a diagnosis, or its JSON
        minutes : time on the test bed
        repeats : readings of each load
        pool : loads to choose from; default all that the test bed can do
        check_single : whether an answer without look-alikes is checked against its nearest rivals
        """
        result = diagnosis.to_json_dict() if isinstance(diagnosis, Diagnosis) else diagnosis
        sets, alone = in_question(result["models"], result.get("transfer", ()))
        if len(sets) < 2 or (alone and not check_single):
            return None
        if self.progress:
            self.progress("what to measure next")
        known: dict[str, Any] = {"priors": self.priors, "force_sigma": result["noise"]["force"] or 0.0}
        rivals = fitted_rivals(self.mechanism, self.fitted, sets[:MOST_RIVALS], **known)
        sigma = [value or usual for value, usual in zip(result["noise"]["sigma"], CAMERA_SIGMA, strict=True)]
        return next_loads(rivals, self.fitted, sigma=sigma, minutes=minutes, repeats=repeats, pool=pool,
                          first_alone=alone, **known)  # fmt: skip

    def page(self, diagnosis: Diagnosis, path: str | os.PathLike[str], further: NextLoads | None = None) -> Path:
        """Write the page of a diagnosis, and beside it the numbers of its pictures; return its path.

        Parameters
        ----------
        found : the diagnosis
        path : of the page
        further : what to measure next, see `next_loads`

        Raises
        ------
        InputError : a file cannot be written, or matplotlib or jinja2 is missing.
        """
        from ..pages.diagnosis import write_diagnosis

        if self.progress:
            self.progress("report")
        tests = parity(diagnosis.rows.data[0], diagnosis.rows.before) if len(diagnosis.rows.data) == 1 else None
        return write_diagnosis(diagnosis, self.mechanism, Path(path), parity=tests, plan=self.plan(),
                               next_loads=further, notes=diagnosis.noticed, priors=self.priors)  # fmt: skip


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
        declared = getattr(data, name)
        columns[name] = np.where(np.isfinite(declared) & (declared > 0.0), declared, sigma)
    return replace(data, **columns)
