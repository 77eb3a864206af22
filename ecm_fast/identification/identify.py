"""Identification of parameters from measurements, Section 2.4 of the paper: (42) with exact derivatives."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..data.measurements import Measurements
from ..data.repeated_rows import repeated_rows, without_poses
from ..errors import InputError, real, shown
from ..mechanism.mechanism import Mechanism
from ..mechanism.mesh.discretization import Discretization
from ..mechanism.parameters import find, index
from ..mechanism.sections import STIFFNESSES
from ..mechanism.vector import pack
from ..models.body import divide
from ..models.instruments.checks.checks import faults
from ..models.instruments.checks.finding import Finding
from ..models.instruments.rest_pose import absolute, free_origins
from .fit import WeightedFit
from .least_squares import Loss
from .noise import check_force_sigma
from .result import Identification
from .rows import FitRows, FitSet, common_mesh, prior_std

__all__ = ["fit_parameters", "identify"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Experiment = tuple[Mechanism, Measurements] | tuple[Mechanism, Measurements, Sequence[str]]
Priors = Mapping[str, tuple[float, float]]


def identify(
    mechanism: Mechanism | Sequence[Experiment],
    data: Measurements | Sequence[Measurements] | Sequence[str],
    names: Sequence[str] | None = None,
    *,
    channels: Sequence[str] | None = None,
    priors: Priors | None = None,
    loss: str = "linear",
    loss_scale: float = 1.345,
    force_sigma: float | None = None,
    level: float = 0.90,
    elements: int | ArrayLike | None = None,
    order: int | None = None,
) -> Identification:
    """Return the parameters at which the model meets the measurements best.

    ``identify(neck, data, names)`` or, for experiments on different mechanisms that share these parameters,
    ``identify([(specimen, pushes, ("x",)), (neck, shear)], names)``.

    Parameters
    ----------
    mechanism : what is built, its values the start; or several experiments: a mechanism, its measurements and, where
        they differ from `channels`, the channels that count. The first one's values are the start of all.
    data : one set of measurements or several; the names where `mechanism` holds the experiments
    names : of the parameters, as in `parameters`; any but the axial law. All experiments share them. Of a tendon or
        marker also by its own name, ``front.zero``
    channels : which of x, z, theta, ``M1_x``, ``len_front`` ... count; default all that are measured
    priors : value and standard deviation from other tests, by name: ``{"EA": (7500.0, 75.0)}``
    loss : linear, huber or soft_l1, see `Loss`; the last two hold outliers down
    loss_scale : the residual, in standard deviations, from which on it counts as an outlier
    force_sigma : noise of the force readings [N], carried through the model; default as the measurements declare it
    level : probability of the intervals
    elements, order : the discretization, see `FiniteElementModel`; default one whose error is a tenth of the declared
        noise, or 1e-6 rad and shares of the length, at the start and at the fit

    Raises
    ------
    InputError : a name, a channel or a prior cannot be meant, or the readings are too few; says what is allowed.
        Or the measurements cannot be used as they are, see `checks.check`: a wrong unit or sign, a broken force cell.

    Notes
    -----
    Rows that repeat an earlier one to the last digit count once. A reading's noise is what its sigma column declares;
    else the scatter of rows with the same ``pose_id``; else what the fit leaves, by channel and experiment, see
    `variance_components`. `Identification.noise` says which. From what a fit leaves of fewer than 3 rows no interval is
    taken: it is infinite, and a warning says why. Where poses are zeroed at rest, see `ColumnMap`, the origin of every
    channel is fitted along.

    Examples
    --------
    >>> neck, data = datasets.load("simulated_slender_tendon")
    >>> fit = identify(neck, data, ["EA", "GA", "EI"])
    >>> fit["EI"].lower < 3.0 < fit["EI"].upper
    True
    """
    wanted, sets = _experiments(mechanism, data, names, channels)
    sets = [replace(entry, data=absolute(entry.mechanism, entry.data)) for entry in sets]
    origins = free_origins([entry.counted for entry in sets])
    found, known = _faults(sets, wanted), {*wanted} <= {*STIFFNESSES}
    if known:
        _refuse(sets, found)
    sets = _without_repeats(sets)
    fitted = [*wanted, *(key for key in origins if index(key) not in map(index, wanted))]
    fit = fit_parameters(sets, fitted, priors=priors, loss=loss, loss_scale=loss_scale, force_sigma=force_sigma,
                         level=level, elements=elements, order=order)  # fmt: skip
    if any(finding.certain or finding.kind == "unexplained" for part in found for finding in part):
        built = zip(sets, fit.mechanisms, strict=True)
        found = _faults([replace(entry, mechanism=one) for entry, one in built], wanted)
        _refuse(sets, found)
    several = len(sets) > 1
    texts = (f"{entry.data.source}: {finding}" if several else str(finding)
             for entry, part in zip(sets, found, strict=True) for finding in part)  # fmt: skip
    return replace(fit, warnings=(*fit.warnings, *texts))


def fit_parameters(
    sets: Sequence[FitSet],
    names: Sequence[str],
    *,
    priors: Priors | None = None,
    loss: str = "linear",
    loss_scale: float = 1.345,
    force_sigma: float | None = None,
    level: float = 0.90,
    elements: int | ArrayLike | None = None,
    order: int | None = None,
) -> Identification:
    """Fit parameters to experiments as they are, without any check of the measurements; arguments as `identify`."""
    prior = _prior(names, priors or {})
    if not 0.0 < real("level", level) < 1.0:
        raise InputError(f"level = {shown(level)}: allowed is a number between 0 and 1")
    check_force_sigma(force_sigma)

    def run(mesh: Discretization) -> Identification:
        return WeightedFit(FitRows(sets, names, mesh), prior, Loss(loss, loss_scale), level, force_sigma).best()

    if elements is not None or order is not None:
        return run(Discretization.from_elements(divide(pack(sets[0].mechanism), elements), order))
    mesh, _ = common_mesh(sets)
    fit = run(mesh)
    # the fit may bend further than the start
    fitted = [replace(entry, mechanism=built) for entry, built in zip(sets, fit.mechanisms, strict=True)]
    finer, unresolved = common_mesh(fitted, mesh)
    if finer != mesh:
        fit = run(finer)
    if unresolved:
        warning = f"{unresolved} rows: the discretization error exceeds a tenth of the noise"
        fit = replace(fit, warnings=(*fit.warnings, warning))
    return fit


def _faults(sets: Sequence[FitSet], names: Sequence[str]) -> list[list[Finding]]:
    """Return the faults of every experiment's measurements, channels that do not count left out."""
    counted = [entry.counted for entry in sets]
    known = [np.isfinite(data.readings(data.channels)).any() for data in counted]
    return [faults(entry.mechanism, data, names) if any_ else [] for entry, data, any_ in
            zip(sets, counted, known, strict=True)]  # fmt: skip


def _refuse(sets: Sequence[FitSet], findings: Sequence[Sequence[Finding]]) -> None:
    for entry, part in zip(sets, findings, strict=True):
        certain = [str(finding) for finding in part if finding.certain]
        if certain:
            raise InputError(f"{entry.data.source}: {'. '.join(certain)}")


def _without_repeats(sets: Sequence[FitSet]) -> list[FitSet]:
    """Return the experiments, the poses of rows that repeat an earlier row of the same kind of experiment blank."""
    kept = list(sets)
    for i, entry in enumerate(sets):
        alike = [j for j in range(i + 1) if (sets[j].mechanism, sets[j].channels) == (entry.mechanism, entry.channels)]
        again = repeated_rows([sets[j].data for j in alike])[-1]
        if again.any():
            kept[i] = replace(entry, data=without_poses(entry.data, again))
    return kept


def _experiments(
    mechanism: Any, data: Any, names: Sequence[str] | None, channels: Sequence[str] | None
) -> tuple[list[str], list[FitSet]]:
    """Return names and experiments of either way to call `identify`."""
    if isinstance(mechanism, Mechanism):
        several = [data] if isinstance(data, Measurements) else list(data)
        experiments: list[Any] = [(mechanism, part) for part in several]
    else:
        experiments, names = list(mechanism), data if names is None else names
    wanted = [names] if isinstance(names, str) else list(names or ())
    if not wanted or not experiments:
        raise InputError("nothing to fit: name at least one parameter, and give at least one set of measurements")
    wanted = [experiments[0][0].key_of(name) for name in wanted]
    for name in wanted:
        if find(name).key == "beam.axial_law":
            raise InputError("axial_law is a choice, not a number: fit once with each and compare the rms")
    if len({index(name) for name in wanted}) < len(wanted):
        raise InputError(f"a parameter is named twice in {', '.join(wanted)}")
    whole = [(*entry, channels)[:3] for entry in experiments]
    return wanted, [FitSet(built, measured, None if counted is None else tuple(counted)) for built, measured, counted
                    in whole]  # fmt: skip


def _prior(names: Sequence[str], priors: Priors) -> Array:
    """Return place, value and standard deviation of every prior, (k, 3)."""
    places = [index(name) for name in names]
    table = np.empty((len(priors), 3))
    for row, (name, (value, std)) in enumerate(priors.items()):
        if index(name) not in places:
            raise InputError(f"a prior for {name}, which is not fitted: fit it too, or set it in the mechanism")
        center = find(name).check(value)
        table[row] = places.index(index(name)), center, prior_std(name, center, std)
    return table
