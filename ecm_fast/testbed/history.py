"""The state that a row inherits from the rows before it, and the laws that need it.

A history begins where the session or the experiment differs from the row before. Before its first row the neck stood
straight and was never loaded. Angles and tendons are those of the same mechanism without any memory or friction.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data.measurements import Measurements
from . import outside
from .laws import Parameters, length, tendon_lengths
from .variants import NO_FORCE, SETTLES, STICK, blend

__all__ = ["FULL_LOAD", "Past", "aged", "drifted", "hours", "needs_past", "new", "tendon_forces"]

Array = Any

FULL_LOAD = 320.0
"""Sum of both readings of which the largest so far is a share [N]."""
FULL_SCALE = 160.0
"""Force at which the nonlinearity of a cell is stated [N]."""

_AGES = ("bending_hysteresis.couple", "fading_memory.share", "creep", "mullins_softening", "stiffness_drift")
_RUBS = ("tendon_capstan_friction.coefficient", "tendon_coulomb_friction")
_DRIFTS = ("force_zero_drift", "force_zero_drift_asymmetry")
_PAST = (*(f"effects.{name}" for name in (*_AGES, *_RUBS)), "outside.guide_friction", "outside.two_time_memory")


@dataclass(frozen=True, eq=False)
class Past:
    """History of the rows, one entry a row.

    Attributes
    ----------
    begins : (n,) whether a history begins here
    hours : (n,) time since it began [h]
    dwell : (n,) time held [s]
    peak : (n,) largest sum of both readings so far, as a share of `FULL_LOAD`
    theta : (n,) angle of the head without memory [rad]
    pulled : (2, n) 1 where a tendon was last pulled in, -1 where it was let out
    """

    begins: NDArray[np.bool_]
    hours: Array
    dwell: Array
    peak: Array
    theta: Array
    pulled: Array

    @classmethod
    def from_poses(cls, p: Parameters, loads: Measurements, pose: Array) -> "Past":
        """Return the past of every row from the poses without memory, (n, 3)."""
        begins = _begins(loads)
        straight = np.array([[length(p)], [0.0], [0.0]])
        pulled, travel = _last_pulled(loads, begins, tendon_lengths(p, straight)[:, 0], tendon_lengths(p, pose.T))
        pulled = blend(p, "stick_zone", pulled, pulled * (1.0 - np.exp(-travel / STICK)))
        dwell = np.where(np.isfinite(loads.dwell), loads.dwell, 0.0)
        peak = np.concatenate([np.maximum.accumulate(loads.lam[rows].sum(axis=1)) for rows in _histories(begins)])
        return cls(begins, hours(loads), dwell, peak / FULL_LOAD, pose[:, 2], pulled)

    def slider(self, angle: float) -> Array:
        """Follow theta/angle between -1 and 1 as a slider with dry friction does, (n,)."""
        followed = np.empty_like(self.theta)
        for rows in _histories(self.begins):
            h, before = 0.0, 0.0
            for i in rows:
                h = float(np.clip(h + (self.theta[i] - before) / angle, -1.0, 1.0))
                followed[i], before = h, self.theta[i]
        return followed

    def gap(self, time: float) -> Array:
        """Distance of theta from what is remembered of it, (n,) [rad]; 1/e of a gap is left after `time` [s]."""
        gaps = np.empty_like(self.theta)
        for rows in _histories(self.begins):
            remembered = 0.0
            for i in rows:
                gaps[i] = (self.theta[i] - remembered) * np.exp(-self.dwell[i] / time)
                remembered = self.theta[i] - gaps[i]
        return gaps


def needs_past(p: Parameters) -> bool:
    """Tell whether any law of these parameters asks for poses of the rows before."""
    return any(p[key] != 0.0 for key in _PAST)


def new(p: Parameters) -> Parameters:
    """Return the parameters of the neck without anything that comes from the past."""
    return {**p, **dict.fromkeys([*_PAST, *(f"effects.{name}" for name in _DRIFTS)], 0.0)}


def hours(loads: Measurements) -> Array:
    """Time since the history of each row began, (n,) [h]; 0 where a time is not given."""
    first = np.concatenate([np.full(rows.size, loads.t[rows[0]]) for rows in _histories(_begins(loads))])
    return np.nan_to_num((loads.t - first) / 3600.0, nan=0.0)


def aged(p: Parameters, past: Past) -> Parameters:
    """Return the parameters of every row as its past has left them.

    Stiffnesses fall with the largest load and with the time held, and drift. Hysteresis and memory act on every section
    as the precurvature that makes their couples in the new neck.
    """
    share = (
        (
            1.0
            - p["effects.mullins_softening"] * blend(p, "mullins_saturates", past.peak, 1.0 - np.exp(-2.0 * past.peak))
        )
        * (1.0 + p["effects.stiffness_drift"] * drifted(p, past.hours))
        / (1.0 + p["effects.creep"] * np.log10(1.0 + past.dwell))
    )
    changed: Mapping[str, Array] = {key: p[key] * share for key in ("beam.EA", "beam.GA", "beam.EI")}
    angle, time = p["effects.bending_hysteresis.angle"], p["effects.fading_memory.time"]
    sliders = 0.5 * (past.slider(0.5 * angle) + past.slider(2.0 * angle))
    rub = p["effects.bending_hysteresis.couple"] * blend(p, "two_sliders", past.slider(angle), sliders)
    gaps = 0.5 * (past.gap(time / 3.0) + past.gap(3.0 * time))
    turn = p["effects.fading_memory.share"] * blend(p, "stretched_memory", past.gap(time), gaps)
    turn = turn + outside.memory(p, (past.gap(outside.TIMES[0]), past.gap(outside.TIMES[1])))
    cast = p["effects.precurvature"] - rub / p["beam.EI"] - turn / length(p)
    return {**p, **changed, "effects.precurvature": cast}


def tendon_forces(p: Parameters, loads: Measurements, past: Past | None = None) -> Array:
    """Forces that the tendons exert on the head, (2, n) [N], from the readings of the cells.

    lam_l = r_l (1 + gain + asymmetry/2) exp(-mu wrap dir) + zero + asymmetry/2 - friction dir
    + nonlinearity r_l^2/(160 N) + crosstalk r_r; lam_r with left and right exchanged, asymmetries with the other sign.
    """
    r, side, t = loads.lam.T, np.array([[0.5], [-0.5]]), hours(loads)
    more = p["effects.force_gain"] + side * p["effects.force_gain_asymmetry"]
    gain = 1.0 + more * blend(p, "gain_saturates", 1.0, 1.0 - r / 400.0)
    zero = p["effects.force_zero"] + side * p["effects.force_zero_asymmetry"]
    drift = p["effects.force_zero_drift"] + side * p["effects.force_zero_drift_asymmetry"]
    zero = zero + drift * drifted(p, t)
    zero = blend(p, "zero_above_2N", zero, np.where(r > NO_FORCE, zero, 0.0))
    rubbed: Array | float = 1.0
    if past is not None:
        mu, wrap = (p[f"effects.tendon_capstan_friction.{name}"] for name in ("coefficient", "wrap"))
        wrap = blend(p, "wrap_grows", wrap, wrap + 2.0 * side * past.theta)
        rubbed = np.exp(-mu * wrap * past.pulled) * outside.friction(p, past.theta, past.pulled)
        rub = p["effects.tendon_coulomb_friction"]
        zero = zero - blend(p, "slack_rubs_not", rub, np.minimum(rub, 0.2 * r)) * past.pulled
    bent = p["effects.force_nonlinearity"] * r * r / FULL_SCALE
    return outside.cells(p, r * gain * rubbed + zero + bent + p["effects.force_crosstalk"] * r[::-1], t)


def drifted(p: Parameters, hours: Array) -> Array:
    """Time that drifts go with [h]."""
    return blend(p, "drift_settles", hours, SETTLES * (1.0 - np.exp(-hours / SETTLES)))


def _begins(loads: Measurements) -> NDArray[np.bool_]:
    begins = np.ones(loads.n, dtype=np.bool_)
    begins[1:] = (loads.session[1:] != loads.session[:-1]) | (loads.experiment[1:] != loads.experiment[:-1])
    return begins


def _histories(begins: NDArray[np.bool_]) -> Iterator[NDArray[np.int64]]:
    """Yield the rows of every history."""
    yield from np.split(np.arange(begins.size), np.flatnonzero(begins)[1:])


def _last_pulled(
    loads: Measurements, begins: NDArray[np.bool_], straight: Array, lengths: Array
) -> tuple[Array, Array]:
    """Return the direction and the length of each tendon's last move, (2, n) each.

    Rows with one pose_id in succession count as one.
    """
    pulled, travel = np.zeros_like(lengths), np.zeros_like(lengths)
    before, now, way = straight, straight, np.zeros(2)
    for i in range(loads.n):
        if begins[i]:
            before, now, way = straight, straight, np.zeros(2)
        same = not begins[i] and loads.pose_id[i] != "" and loads.pose_id[i] == loads.pose_id[i - 1]
        if not same:
            before, now = now, lengths[:, i]
            way = np.where(now == before, way, np.sign(before - now))
        pulled[:, i], travel[:, i] = way, np.abs(now - before)
    return pulled, travel
