"""Posterior samples of parameters, each step of the sampler one batch of solves."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data.measurements import Measurements
from ..errors import InputError, did_you_mean, shown
from ..mechanism.derived import limits
from ..mechanism.mechanism import Mechanism
from ..mechanism.parameters import index
from ..mechanism.vector import pack
from ..models.equilibrium import Status
from ..models.instruments.mesh_choice import mesh_for
from ..models.instruments.rest_pose import absolute, free_origins
from ..models.instruments.robot_chain import chain_of
from ..models.loads import last_step
from .fit import t_quantile
from .identify import identify

__all__ = ["Posterior", "posterior"]

Array = NDArray[np.float64]
Priors = Mapping[str, tuple[float, float]]

_FEWEST_STEPS = 100  # emcee asks for fifty autocorrelation times: fewer steps are never enough
# a chain of fewer autocorrelation times has not forgotten where it began; emcee's own advice
_LONG_ENOUGH = 50
_TOLERANCE = 1e-8  # [rad, shares of the length] four decades below the noise of a camera


@dataclass(frozen=True, eq=False, repr=False)
class Posterior:
    """Samples of parameters.

    Attributes
    ----------
    names : of the parameters, as they were asked for
    samples : (m, p) in SI units
    autocorrelation : (p,) how many steps of the chain count as one independent one
    acceptance : share of the proposals that were taken
    solves : how many equilibria it took
    warnings : what to know before the samples are used
    """

    names: tuple[str, ...]
    samples: Array
    autocorrelation: Array
    acceptance: float
    solves: int
    warnings: tuple[str, ...] = field(default=())

    def __getitem__(self, name: str) -> Array:
        """Return the samples of one parameter, (m,), named as it was asked for."""
        if name not in self.names:
            raise InputError(f"{name!r} was not sampled{did_you_mean(str(name), self.names)}; these were: "
                             f"{', '.join(self.names)}")  # fmt: skip
        column: Array = self.samples[:, self.names.index(name)]
        return column

    def interval(self, name: str, level: float = 0.90) -> tuple[float, float]:
        """Return the ends of the middle `level` of a parameter's samples."""
        if not 0.0 < level < 1.0:
            raise InputError(f"level = {shown(level)}: allowed is a number between 0 and 1")
        low, high = np.quantile(self[name], [0.5 - 0.5 * level, 0.5 + 0.5 * level])
        return float(low), float(high)

    @property
    def covariance(self) -> Array:
        """Covariance of the parameters, (p, p)."""
        return np.atleast_2d(np.cov(self.samples.T))

    def __repr__(self) -> str:
        found = ", ".join(
            f"{name} {mean:.6g} +- {std:.2g}"
            for name, mean, std in zip(self.names, self.samples.mean(axis=0), self.samples.std(axis=0), strict=True)
        )
        return f"Posterior({len(self.samples)} samples: {found})"


def posterior(
    mechanism: Mechanism,
    data: Measurements,
    names: Sequence[str],
    *,
    priors: Priors | None = None,
    force_sigma: float = 0.0,
    walkers: int | None = None,
    steps: int = 1000,
    seed: int = 0,
) -> Posterior:
    """Return samples of parameters from their posterior, by emcee's ensemble of walkers.

    The walkers begin about the best fit; the first fifth of the steps is left out. Noise is Gaussian, of the size that
    the measurements declare; priors are flat between the bounds of a parameter where none is given. Where `identify`
    finds the noise from what the fit leaves, its size is integrated out: the density is Student's t of the sum of
    squares above its minimum, with the fewest degrees of freedom that `identify` gives one of the parameters.

    Parameters
    ----------
    mechanism : what is built, its values the start
    data : measurements with poses
    names : of the parameters, as in `parameters`; any but the axial law. The origins of channels that are zeroed at
        rest, see `ColumnMap`, are sampled along
    priors : value and standard deviation from other tests, by name
    force_sigma : noise of the force readings [N], carried through the model at the best fit
    walkers : how many; default four a parameter, at least eight
    steps : of each walker
    seed : of the sampler

    Raises
    ------
    InputError : as `identify`; or emcee is not installed, or the data leave a parameter free that has no prior.
    """
    try:
        import emcee
    except ImportError:
        raise InputError("sampling needs the package emcee: pip install 'ecm-fast[uq]'") from None
    data = absolute(mechanism, data)
    names = [*names, *(key for key in free_origins([data]) if index(key) not in map(index, names))]
    count = max(8, 4 * len(names)) if walkers is None else walkers
    if count < 2 * len(names) or count % 2 or steps < _FEWEST_STEPS:
        raise InputError(f"walkers = {shown(walkers)}, steps = {shown(steps)}: allowed is an even number from "
                         f"{2 * len(names)} up, and from {_FEWEST_STEPS} up")  # fmt: skip
    density = _Density(mechanism, data, names, priors or {}, force_sigma)
    rng = np.random.RandomState(seed)
    start = density.best + 0.5 * density.scale * rng.standard_normal((count, len(names)))
    start = np.clip(start, density.lower, density.upper)
    sampler: Any = emcee.EnsembleSampler(count, len(names), density, vectorize=True)
    sampler.random_state = rng.get_state()
    sampler.run_mcmc(start, steps)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what there is to say, `_complaints` says
        times = np.asarray(sampler.get_autocorr_time(discard=steps // 5, tol=0), dtype=np.float64)
    return Posterior(
        names=tuple(names),
        samples=sampler.get_chain(discard=steps // 5, flat=True),
        autocorrelation=times,
        acceptance=float(np.mean(sampler.acceptance_fraction)),
        solves=density.solves,
        warnings=_complaints(times, steps),
    )


def _complaints(times: Array, steps: int) -> tuple[str, ...]:
    """Return what to know of a chain with these autocorrelation times."""
    if np.all(times * _LONG_ENOUGH <= 0.8 * steps):
        return ()
    longest = float(times.max())
    enough = int(np.ceil(_LONG_ENOUGH * longest / 0.8)) if np.isfinite(longest) else 10 * steps
    return (f"{steps} steps are few for an autocorrelation time of {longest:.3g}: take at least {enough}",)


class _Density:
    """The logarithm of the posterior's density, up to a constant, for many sets of parameters at once."""

    def __init__(
        self, mechanism: Mechanism, data: Measurements, names: Sequence[str], priors: Priors, force_sigma: float
    ) -> None:
        fit = identify(mechanism, data, names, priors=priors, force_sigma=force_sigma)
        self.best, self.scale = fit.values, np.sqrt(np.diag(fit.covariance))
        if not np.isfinite(self.scale).all():
            name = names[int(np.argmin(np.isfinite(self.scale)))]
            raise InputError(f"no samples of {name}: {next(iter(fit.warnings), 'the measurements do not see it')}")
        self.lower, self.upper = np.array([limits(name, pack(fit.mechanism)) for name in names]).T
        self._places = [index(name) for name in names]
        self._par = pack(fit.mechanism)
        self._chain = chain_of(fit.mechanism, data, mesh_for(fit.mechanism, data)[0])
        self._data, self._used = data, fit.used
        self._whiten = self._whitening(fit.sigma, force_sigma)
        self._priors = [(list(names).index(name), value, std) for name, (value, std) in priors.items()]
        self.solves = 0
        self._dof = min(found.dof for found in fit.parameters.values())
        quantiles = [t_quantile(fit.level, found.dof) for found in fit.parameters.values()]
        self._widened = float((fit._reach / quantiles).max())
        self._most = float(self._gaussian(self.best[None])[0])

    def _whitening(self, sigma: Array, force_sigma: float) -> Array:
        """Return the matrices (n, c, c) that make a row's errors independent and of unit size."""
        slopes = self._chain.sensitivities((), self._par, last_step(_TOLERANCE)).jacobian
        both = self._used[:, :, None] & self._used[:, None, :]
        covariance = np.where(both, force_sigma**2 * slopes @ slopes.transpose(0, 2, 1), 0.0)
        diagonal = np.arange(sigma.shape[1])
        covariance[:, diagonal, diagonal] += np.where(self._used, sigma, 1.0) ** 2
        return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)) * self._used[:, None, :], dtype=np.float64)

    def __call__(self, values: Array) -> Array:
        """Return the logarithm at (w, p) sets of parameters, (w,)."""
        found = self._gaussian(values)
        if np.isinf(self._dof):
            return found
        unit = np.maximum(self._most - found, 0.0) / self._widened**2
        return np.asarray(-0.5 * (self._dof + values.shape[1]) * np.log1p(2.0 * unit / self._dof))

    def _gaussian(self, values: Array) -> Array:
        """Return the logarithm where the size of the noise is known, (w,)."""
        out = np.full(len(values), -np.inf)
        fits = ((values >= self.lower) & (values <= self.upper)).all(axis=1)
        if not fits.any():
            return out
        par = np.tile(self._par, (int(fits.sum()), 1))
        par[:, self._places] = values[fits]
        self.solves += len(par) * self._data.n
        pose, status = self._chain.solve_many(par, last_step(_TOLERANCE))
        stable = ((status == Status.CONVERGED) | ~self._used.any(axis=1)).all(axis=1)
        off = np.where(self._used, self._data.readings(self._chain.channels) - pose, 0.0)
        errors = np.einsum("nij,wnj->wni", self._whiten, off)
        total = np.where(stable, -0.5 * np.einsum("wni,wni->w", errors, errors), -np.inf)
        for place, value, std in self._priors:
            total -= 0.5 * ((values[fits, place] - value) / std) ** 2
        out[fits] = total
        return out
