"""Predicted readings for every row of a measurement file."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...data.columns import CHANNELS, COLUMNS, LOADS, channel_key
from ...data.measurements import Measurements
from ...files import csv_text, write_whole
from ...mechanism.mechanism import Mechanism
from ...mechanism.mesh.discretization import Discretization
from ...mechanism.vector import pack
from ..body import divide
from ..equilibrium import Status
from ..loads import MIN_TOLERANCE, last_step
from .checks.checks import faults
from .mesh_choice import mesh_for
from .rest_pose import absolute
from .robot_chain import chain_of

__all__ = ["Prediction", "predict"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Prediction:
    """Predicted readings, one entry a row of the measurements.

    Attributes
    ----------
    pose : (n, c) by `channels`: x, z, theta of Q [m, m, rad], then poses of markers and lengths of tendons that the
        measurements name; nan where no equilibrium was found
    status : (n,) values of `Status`
    load_factor : (n,) how much of the load the stable branch carries, see `Equilibrium`
    data : the measurements, relative to the clamp: to poses that are zeroed at rest the model's rest pose is added
    mechanism : that was predicted
    unresolved : (n,) where no discretization was fine enough for the noise, see `mesh_choice.mesh_for`
    channels : names of what is predicted
    """

    pose: Array
    status: NDArray[np.int64]
    load_factor: Array
    data: Measurements
    mechanism: Mechanism
    unresolved: NDArray[np.bool_]
    channels: tuple[str, ...] = CHANNELS

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Faults of the measured poses or loads with their cures, see `checks.check`, and rows that are unresolved."""
        known = np.isfinite(self.data.readings(self.channels)).any()
        found = tuple(map(str, faults(self.mechanism, self.data))) if known else ()
        rows = int(self.unresolved.sum())
        return (*found, f"{rows} rows: the discretization error exceeds a tenth of the noise") if rows else found

    @property
    def residual(self) -> Array:
        """Measured less predicted, (n, c) [m, rad]; nan where not measured or not converged."""
        return self.data.readings(self.channels) - self.pose

    @property
    def rms(self) -> dict[str, float | None]:
        """Root mean square of `residual` by channel, ``x_m``, ``z_m``, ``theta_rad``; None where it has no entry."""
        return dict(zip(map(channel_key, self.channels), _rms(self.residual), strict=True))

    @property
    def sigmas(self) -> Array:
        """`residual` over the noise that the measurements declare of the camera, (n, c); nan where none is."""
        declared = self.data.sigmas(self.channels)
        return np.asarray(np.where(declared > 0.0, self.residual / np.where(declared > 0.0, declared, 1.0), np.nan))

    @property
    def rms_sigma(self) -> dict[str, float | None]:
        """Root mean square of `sigmas` by channel, ``x``, ``z``, ``theta``; None where it has no entry."""
        return dict(zip(self.channels, _rms(self.sigmas), strict=True))

    @property
    def rows(self) -> int:
        """Number of rows with a converged prediction and at least one measured channel."""
        return int(np.isfinite(self.residual).any(axis=1).sum())

    @property
    def counts(self) -> dict[str, int]:
        """Number of rows by status."""
        return {status.name.lower(): int(np.sum(self.status == status)) for status in Status}

    def columns(self) -> dict[str, Sequence[Any]]:
        """Return the table that `to_csv` writes: loads, predicted pose, measured pose, status name of every row."""
        columns: dict[str, Sequence[Any]] = {COLUMNS[name].names[0]: getattr(self.data, name) for name in LOADS}
        columns |= {f"{name}_N": values.tolist() for name, values in self.data.named.items() if name.startswith("lam_")}
        names = self.mechanism.tendon_names
        given = [(name, self.data.lengths([name])[:, 0]) for name in names]
        columns |= {f"len_{name}_given_m": values.tolist() for name, values in given if np.isfinite(values).any()}
        for name, predicted in zip(self.channels, self.pose.T, strict=True):
            columns[channel_key(name)] = predicted
        for name, measured in zip(self.channels, self.data.readings(self.channels).T, strict=True):
            quantity, _, unit = channel_key(name).rpartition("_")
            columns[f"{quantity}_measured_{unit}"] = measured
        columns["status"] = [Status(value).name.lower() for value in self.status]
        return columns

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write `columns` in the order of the rows, to the last digit; what is unknown is blank.

        Raises
        ------
        InputError : the file cannot be written.
        """
        return write_whole(path, csv_text(self.columns()))

    def __repr__(self) -> str:
        kinds = ", ".join(f"{count} {name}" for name, count in self.counts.items() if count)
        rms = ", ".join(f"{name} {value:.3g}" for name, value in self.rms.items() if value is not None)
        text = f"<Prediction of {len(self.status)} rows: {kinds}; rms {rms or 'unknown, no pose is measured'}"
        return "\n".join([text, *(f"  warning: {warning}" for warning in self.warnings)]) + ">"


def _rms(columns: Array) -> list[float | None]:
    """Return the root mean square of what is known of every column, None where nothing is."""
    known = [column[np.isfinite(column)] for column in columns.T]
    return [float(np.sqrt(np.mean(entries**2))) if entries.size else None for entries in known]


def predict(
    mechanism: Mechanism,
    data: Measurements,
    *,
    elements: int | ArrayLike | None = None,
    order: int | None = None,
    threads: int = 1,
) -> Prediction:
    """Predict what the instruments would read in every row.

    Parameters
    ----------
    mechanism : what is built
    data : the loads of every row, and what was changed on the test bed; its poses are only compared
    elements, order : the discretization, see `FiniteElementModel`; default one whose error is a tenth of the declared
        noise, or 1e-6 rad and shares of the length
    threads : how many threads share the rows

    Raises
    ------
    InputError : a row's tilt or extra mass leaves the bounds of the parameter it adds to; names the row.
    """
    data = absolute(mechanism, data)
    par, excess = pack(mechanism), np.zeros(data.n)
    if elements is None and order is None:
        mesh, excess = mesh_for(mechanism, data)
    else:
        mesh = Discretization.from_elements(divide(par, elements), order)
    chain = chain_of(mechanism, data, mesh)
    pose, status, load_factor = chain.solve(par, last_step(MIN_TOLERANCE), threads)
    return Prediction(pose, status, load_factor, data, mechanism, excess > 1.0, chain.channels)
