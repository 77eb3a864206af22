"""The state that rows inherit from the rows before them, and the effects of the path.

Every such effect changes other entries of the parameter vector, row by row; the kernels of a solve know nothing of it.
A history begins anew where the session or the experiment differs from the row before. In a history, for row i

    t       time since its first row [h]; 0 where the measurements have no time stamps
    dwell   log10(1 + time held/1 s); 0 where it is not given
    peak    largest sum of both readings so far, as a share of 320 N
    dir     1 where a tendon was last pulled in, -1 where it was let out; rows with one pose_id in succession count
            as one, and before the first row the neck stands straight
    h       clip(h of the row before + change of theta/angle, -1, 1), first from 0
    gap     (theta - m of the row before) exp(-time held/time), with m = theta - gap, first from 0

theta and the tendons' lengths (attachment to pulley center) are those of the same mechanism without effects of the
path, at the row's own loads. With them

    EA, GA, EI      times (1 - mullins_softening peak) (1 + stiffness_drift t) / (1 + creep dwell)
    precurvature    less bending_hysteresis h/EI + fading_memory gap/L
    1 + gain        of either cell times exp(-tendon_capstan_friction wrap dir)
    zero            of either cell less tendon_coulomb_friction dir, plus its drift times t
    camera offsets  plus their drifts times t

Derivatives follow by the complex step through these laws; that dir, h and gap follow theta, which depends on every
parameter, is left out of them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data.measurements import Measurements
from ...kernels.history import FULL_LOAD, follow, tendon_lengths
from ...kernels.layout import N_PAST, N_STATION, N_TIP, T_ATTACH_LX, T_LENGTH, T_PULLEY_LX
from ...kernels.prepare import prepare
from ...mechanism.catalogue import CATALOGUE
from ...mechanism.parameters import PLACES as P
from ...mechanism.parameters import index

__all__ = ["TARGETS", "USER_ROWS", "History", "Record", "Rows", "attachments", "is_on_path", "on_path", "path_effects"]

Array = NDArray[Any]
Places = NDArray[np.int64] | slice

TARGETS = (
    P.beam_EA, P.beam_GA, P.beam_EI, P.effects_precurvature, P.effects_force_gain, P.effects_force_gain_asymmetry,
    P.effects_force_zero, P.effects_force_zero_asymmetry, P.effects_camera_x_offset, P.effects_camera_z_offset,
)  # fmt: skip
"""Places of the entries that the effects of the catalogue change."""

USER_ROWS: dict[str, Callable[..., Mapping[str, Any]]] = {}
"""Laws of effects that a user adds and that change entries row by row, by the effect's name, see `user_effects`."""


def on_path() -> dict[str, int]:
    """Return keys and places of the parameters of effects of the path."""
    return {entry.key: index(entry.key) for item in CATALOGUE.values() if item.enters == "path" for entry in item}


def path_effects(par: Array) -> list[str]:
    """Return the names of the effects of the path that mechanisms have, (..., n_parameters)."""
    effects = [item for item in CATALOGUE.values() if item.enters == "path"]
    return [item.name for item in effects if par[..., index(item.size.key)].any()]


def is_on_path(par: Array) -> bool:
    """Whether a mechanism has an effect of the path."""
    return bool(path_effects(par))


@dataclass(frozen=True, eq=False)
class Record:
    """Order of the rows as the measurements alone say it, all (n,).

    Attributes
    ----------
    begins : whether a row begins a history
    repeats : whether it repeats the load of the row before
    hours : t; held : time held before reading [s]; peak : see above
    """

    begins: NDArray[np.bool_]
    repeats: NDArray[np.bool_]
    hours: Array
    held: Array
    peak: Array
    data: Measurements = field(repr=False)

    @classmethod
    def from_measurements(cls, data: Measurements) -> "Record":
        """Read the record of measurements."""
        begins, repeats = np.ones(data.n, dtype=np.bool_), np.zeros(data.n, dtype=np.bool_)
        begins[1:] = (data.session[1:] != data.session[:-1]) | (data.experiment[1:] != data.experiment[:-1])
        repeats[1:] = (data.pose_id[1:] == data.pose_id[:-1]) & (data.pose_id[1:] != "") & ~begins[1:]
        first = np.maximum.accumulate(np.where(begins, np.arange(data.n), 0))
        hours = np.nan_to_num((data.t - data.t[first]) / 3600.0)
        load, peak = (data.lam_l + data.lam_r) / FULL_LOAD, np.empty(data.n)
        for start, end in zip(np.flatnonzero(begins), [*np.flatnonzero(begins)[1:], data.n], strict=True):
            peak[start:end] = np.maximum.accumulate(load[start:end])
        return cls(begins, repeats, hours, np.nan_to_num(data.dwell), peak, data)


@dataclass(frozen=True, eq=False)
class Rows:
    """Quantities that the law of a user's effect may look at; one entry a row, named as in `Measurements` and above.

    Attributes
    ----------
    data : loads and labels
    hours, held, peak : (n,) t [h], time held [s], largest load so far [-]
    travel : (n, 2) dir of both tendons
    theta : (n,) tip angle without memory [rad]
    """

    data: Measurements
    hours: Array
    held: Array
    peak: Array
    travel: Array
    theta: Array


@dataclass(frozen=True, eq=False)
class History:
    """The record of measurements, and what the neck without memory does along it.

    Attributes
    ----------
    theta, lengths : (n,) tip angle, (n, 2) tendons [rad, m]
    rest : (2,) tendons on the straight neck [m]
    """

    record: Record
    theta: Array = field(repr=False)
    lengths: Array = field(repr=False)
    rest: Array = field(repr=False)

    @classmethod
    def from_record(cls, record: Record, par: Array, pose: Array) -> "History":
        """Make the history of a record from poses (n, 3) without memory; par : (1 or n, n_parameters)."""
        attached, pulleys, rest = attachments(par)
        lengths = np.empty((len(pose), 2))
        tendon_lengths(pose, attached, pulleys, lengths)
        return cls(record, pose[:, 2].copy(), lengths, rest)

    def apply(self, rows: Array, only: Places = slice(None)) -> None:
        """Write what the effects of the path make of the parameter vectors, (k, n_parameters), real or complex.

        only : places of their rows in the record; default all of them
        """
        record, par, n = self.record, rows[0].copy(), len(self.theta)
        marks = record.begins, record.repeats, record.hours, record.held, record.peak
        past, travel, places = np.zeros(N_PAST, rows.dtype), np.empty((n, 2)), np.arange(n)[only]
        follow(marks, self.theta, self.lengths, self.rest, par, past, places, rows, travel)
        seen = Rows(record.data, record.hours, record.held, record.peak, travel, self.theta)
        for name, law in USER_ROWS.items():
            values = [par[index(entry.key)] for entry in CATALOGUE[name]]
            for key, change in law(*values, seen).items():
                rows[:, index(key)] += np.broadcast_to(change, n)[only]


def attachments(par: Array) -> tuple[Array, Array, Array]:
    """Return where tendons begin and end, left and right, and their lengths on the straight neck.

    Attachments in the head's frame and pulley centers, (n, 2, 2) each, from parameter vectors (n, n_parameters), and
    the lengths of the first one, (2,) [m].
    """
    tips, stations, q_rest = np.empty((len(par), N_TIP)), np.empty((1, N_STATION)), np.empty(3)
    mesh, nodes = np.array([[0.5, 1.0, 1.0]]), np.zeros(1)
    for vector, tip in zip(par, tips, strict=True):
        prepare(vector, mesh, nodes, stations, tip, q_rest)
    attached = np.ascontiguousarray(tips[:, T_ATTACH_LX : T_ATTACH_LX + 4].reshape(-1, 2, 2))
    pulleys = np.ascontiguousarray(tips[:, T_PULLEY_LX : T_PULLEY_LX + 4].reshape(-1, 2, 2))
    straight, rest = np.array([[tips[0, T_LENGTH], 0.0, 0.0]]), np.empty((1, 2))
    tendon_lengths(straight, attached, pulleys, rest)
    return attached, pulleys, rest[0]
