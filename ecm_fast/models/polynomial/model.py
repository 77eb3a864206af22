"""The paper's polynomial models: tip pose to wrench (46)-(48), and loads to pose."""

import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...data.columns import COLUMNS
from ...errors import InputError, OutOfRangeWarning, shown
from .file import read_fields, write_fields
from .multivariate import Polynomial, check_degree, energy_regression, monomials, regression

__all__ = ["ForwardPolynomial", "PolynomialModel"]

Array = NDArray[np.float64]

POSE, WRENCH, TENDONS = ("x", "z", "theta"), ("fx", "fz", "tau"), ("lam_l", "lam_r")


@dataclass(frozen=True, eq=False, repr=False)
class _Fitted:
    """Three polynomials, the range they were fitted on, and how well they fit there.

    Attributes
    ----------
    polynomial : the coefficients, about the middle of the range
    lower, upper : (k,) the smallest box that holds every training input
    rms : (3,) root mean square of what the fit leaves, one entry an output
    condition : condition number of the regression, inputs scaled to the range; its logarithm is the digits lost
    rows : how many rows it was fitted to
    energy_coefficients : (M,) of the energy whose gradient the outputs are, None where each was fitted alone
    """

    polynomial: Polynomial
    lower: Array
    upper: Array
    rms: Array
    condition: float
    rows: int
    energy_coefficients: Array | None = None

    _outputs: ClassVar[tuple[str, ...]]
    _ways_in: ClassVar[Mapping[int, tuple[str, ...]]]
    """Names of the inputs by their number."""

    @classmethod
    def _fit(
        cls, inputs: ArrayLike, outputs: ArrayLike, degree: int, conservative: bool, weights: ArrayLike | None
    ) -> Self:
        points, values = _rows("inputs", inputs, cls._ways_in), _rows("outputs", outputs, {3: cls._outputs})
        if len(points) != len(values):
            raise InputError(f"{len(points)} rows of inputs and {len(values)} of outputs: allowed is one for one")
        names, factors = cls._ways_in[points.shape[1]], _weights(weights, len(points))
        degree, energy = check_degree(degree), None
        if conservative:
            center, energy, condition = energy_regression(points, values, degree, factors, names)
            polynomial = Polynomial.gradient(center, energy)
        else:
            polynomial, condition = regression(points, values, degree, factors, names)
        rms = np.sqrt(np.mean((polynomial(points) - values) ** 2, axis=0))
        return cls(polynomial, points.min(axis=0), points.max(axis=0), rms, condition, len(points), energy)

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return self._ways_in[self.lower.size]

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return self._outputs

    @property
    def degree(self) -> int:
        """Degree of the three polynomials."""
        return self.polynomial.degree

    @property
    def coefficient_count(self) -> int:
        """Number of coefficients that the regression found."""
        energy = self.energy_coefficients
        return self.polynomial.coefficients.size if energy is None else energy.size - 1

    def stepper(self, *, slopes: bool = False) -> Callable[..., tuple[float, float, float]]:
        """Return the compiled evaluation for control loops: floats in, three floats out, no array, no warning.

        With ``slopes=True`` the last argument is an array (3, k) that the derivatives are written to.
        """
        return self.polynomial.stepper(slopes=slopes)

    def outside(self, inputs: ArrayLike) -> NDArray[np.bool_]:
        """Return which inputs (n, k) leave the range, (n, k)."""
        points = _rows("inputs", inputs, {self.lower.size: self.inputs}, finite=False)
        return (points < self.lower) | (points > self.upper)

    def to_json(self, path: str | os.PathLike[str]) -> Path:
        """Write everything, to the last digit, with the names of inputs and outputs and the exponents of every term.

        Raises
        ------
        InputError : the file cannot be written.
        """
        return write_fields(vars(self), type(self).__name__, (self.inputs, self.outputs), path)

    @classmethod
    def from_json(cls, path: str | os.PathLike[str]) -> Self:
        """Read what `to_json` wrote.

        Raises
        ------
        InputError : the file cannot be read, is damaged, or holds something else; names it and what is wrong.
        """
        return cls(**read_fields(cls.__name__, tuple(cls._ways_in.values()), cls._outputs, path))

    def _evaluated(self, inputs: ArrayLike, function: Callable[[Array], Array]) -> Array:
        """Return `function` of inputs, one (k,) or many (n, k); warns where they leave the range."""
        points = _rows("inputs", inputs, {self.lower.size: self.inputs}, finite=False)
        outside = self.outside(points)
        if outside.any():
            warnings.warn(self._warning(points, outside), OutOfRangeWarning, stacklevel=3)
        result = function(points)
        return result[0] if np.ndim(inputs) == 1 else result

    def _warning(self, points: Array, outside: NDArray[np.bool_]) -> str:
        beyond = np.where(outside, np.maximum(self.lower - points, points - self.upper), 0.0).max(axis=0)
        parts = []
        for name, far, low, high in zip(self.inputs, beyond, self.lower, self.upper, strict=True):
            if far > 0.0:
                unit = COLUMNS[name].names[0].removeprefix(f"{name}_")
                parts.append(f"{name} by up to {far:.3g} {unit} (trained from {low:.6g} to {high:.6g})")
        return f"{int(outside.any(axis=1).sum())} of {len(points)} rows leave the range: {', '.join(parts)}"

    def __repr__(self) -> str:
        way = f"{', '.join(self.inputs)} to {', '.join(self._outputs)}"
        kind = "" if self.energy_coefficients is None else "conservative, "
        units = [COLUMNS[name].names[0] for name in self._outputs]
        rms = ", ".join(f"{unit} {value:.3g}" for unit, value in zip(units, self.rms, strict=True))
        return (
            f"<{type(self).__name__} of degree {self.degree}, {way}: {kind}{self.coefficient_count} coefficients from "
            f"{self.rows} rows, condition {self.condition:.3g}; rms {rms}>"
        )


class PolynomialModel(_Fitted):
    """From the pose of the tip to the wrench that holds it there, (46)-(48).

    The wrench is what tendons and external loads together do at Q, in world axes. The weights of the beam and the
    head are not part of it: they act always, and belong to the neck.

    Examples
    --------
    >>> model = FiniteElementModel(Mechanism.preset("paper"))
    >>> known = training_poses(model, 1000, seed=1)
    >>> poly = PolynomialModel.fit(known.poses, known.wrenches)
    >>> poly.wrench([0.039, 0.001, -0.05])
    """

    _outputs = WRENCH
    _ways_in: ClassVar[Mapping[int, tuple[str, ...]]] = {3: POSE}

    @classmethod
    def fit(
        cls,
        poses: ArrayLike,
        wrenches: ArrayLike,
        degree: int = 3,
        conservative: bool = False,
        weights: ArrayLike | None = None,
    ) -> Self:
        """Return the polynomials nearest to wrenches in the sense of least squares.

        Parameters
        ----------
        poses : (n, 3) x, z, theta [m, m, rad]
        wrenches : (n, 3) fx, fz, tau [N, N, N m]
        degree : 1 to 6
        conservative : fit one energy, of one degree more, whose gradient the wrench is: the stiffness is then
            symmetric, and 34 coefficients take the place of 60 at degree 3
        weights : (n,) factors of the rows' residuals, such as 1 / standard deviation; default 1

        Raises
        ------
        InputError : the poses do not determine the coefficients; says how many are needed, or what they lack.
        """
        return cls._fit(poses, wrenches, degree, conservative, weights)

    def wrench(self, pose: ArrayLike) -> Array:
        """Return fx, fz, tau [N, N, N m] at one pose (3,) or many (n, 3); `OutOfRangeWarning` beyond the range."""
        return self._evaluated(pose, self.polynomial)

    def stiffness(self, pose: ArrayLike) -> Array:
        """Return d(fx, fz, tau)/d(x, z, theta) at one pose, (3, 3), or many, (n, 3, 3); warns as `wrench` does."""
        return self._evaluated(pose, self.polynomial.slopes)

    def energy(self, pose: ArrayLike) -> Array:
        """Return the energy [J] at one pose, (), or many, (n,), zero at the middle of the range; may warn as `wrench`.

        Raises
        ------
        InputError : the model is not conservative.
        """
        energy = self.energy_coefficients
        if energy is None:
            raise InputError("only a model fitted with conservative=True has an energy")
        center, degree = self.polynomial.center, self.degree + 1
        return self._evaluated(pose, lambda points: monomials(points - center, degree) @ energy)


class ForwardPolynomial(_Fitted):
    """From loads to the pose of the tip: from two tendon forces, or from a dead wrench at Q."""

    _outputs = POSE
    _ways_in: ClassVar[Mapping[int, tuple[str, ...]]] = {2: TENDONS, 3: WRENCH}

    @classmethod
    def fit(cls, inputs: ArrayLike, poses: ArrayLike, degree: int = 3, weights: ArrayLike | None = None) -> Self:
        """Return the polynomials nearest to poses in the sense of least squares.

        Parameters
        ----------
        inputs : (n, 2) tendon forces left, right [N], or (n, 3) wrenches fx, fz, tau [N, N, N m]
        poses : (n, 3) x, z, theta [m, m, rad]
        degree, weights : see `PolynomialModel.fit`
        """
        return cls._fit(inputs, poses, degree, False, weights)

    def pose(self, inputs: ArrayLike) -> Array:
        """Return x, z, theta [m, m, rad] at one load (k,) or many (n, k); `OutOfRangeWarning` beyond the range."""
        return self._evaluated(inputs, self.polynomial)

    def jacobian(self, inputs: ArrayLike) -> Array:
        """Return d(x, z, theta)/d(inputs) at one load, (3, k), or many, (n, 3, k); warns as `pose` does."""
        return self._evaluated(inputs, self.polynomial.slopes)


def _rows(what: str, values: ArrayLike, ways_in: Mapping[int, Sequence[str]], *, finite: bool = True) -> Array:
    """Return values as rows (n, k) for one of the numbers of columns k that are allowed, or raise."""
    try:
        rows = np.atleast_2d(np.asarray(values, dtype=np.float64))
    except (TypeError, ValueError):
        raise InputError(f"{what} = {shown(values)}: allowed is an array of numbers") from None
    if rows.ndim != 2 or rows.shape[1] not in ways_in:
        allowed = " or ".join(f"(n, {k}): {', '.join(names)}" for k, names in ways_in.items())
        raise InputError(f"{what} have shape {np.shape(values)}: allowed is {allowed}")
    if finite and not np.isfinite(rows).all():
        row, column = np.argwhere(~np.isfinite(rows))[0]
        name = ways_in[rows.shape[1]][column]
        raise InputError(f"{name} = {rows[row, column]} in row {row} of {what}: allowed is a finite number")
    return rows


def _weights(weights: ArrayLike | None, n: int) -> Array:
    if weights is None:
        return np.ones(n)
    try:
        factors = np.asarray(weights, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"weights = {shown(weights)}: allowed is an array of numbers") from None
    if factors.shape != (n,) or not (np.isfinite(factors) & (factors >= 0.0)).all():
        raise InputError(f"weights of shape {factors.shape}: allowed is ({n},), finite and >= 0")
    return factors
