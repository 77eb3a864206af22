"""Checks of measurements before any fit, each a one-line finding with its cure."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data.columns import COLUMNS
from ...data.measurements import Measurements
from ...errors import InputError
from ...mechanism.catalogue import CATALOGUE
from ...mechanism.mechanism import Mechanism
from ...models.instruments.prediction import predict
from ..search.subsample import ENOUGH
from .finding import Finding, places
from .matched_rows import load_table, smooth
from .units_and_axes import label_findings

__all__ = ["FEW_ROWS", "Checks", "Finding", "check", "findings"]

Array = NDArray[np.float64]

_CHANNELS = ("x", "z", "theta")
FEW_ROWS = 30
_MANY_ROWS = 3000
_OUTLIER = 8.0
_FEWEST_FOR_OUTLIERS = 40
_STUCK = 4
_SIDE = 0.02
_MEDIAN_TO_SIGMA = 1.4826
_NAMES_SHOWN = 4


@dataclass(frozen=True)
class Checks:
    """What was noticed about data.

    Attributes
    ----------
    findings : the most telling first; none of them keeps the data from being used
    source : where the data come from
    """

    findings: tuple[Finding, ...]
    source: str

    @property
    def warnings(self) -> tuple[str, ...]:
        """The findings as sentences."""
        return tuple(map(str, self.findings))

    @property
    def outliers(self) -> tuple[int, ...]:
        """Records that lie far from their neighbors, as a user finds them."""
        return tuple(row for finding in self.findings if finding.kind == "outliers" for row in finding.rows)

    def __repr__(self) -> str:
        lines = [f"  {finding.kind}: {finding}" for finding in self.findings]
        return "\n".join([f"<Checks of {self.source}: {len(lines)} findings", *lines]) + ">"


def check(mechanism: Mechanism, data: Measurements) -> Checks:
    """Notice what is wrong with data, before anything is fitted.

    Raises
    ------
    InputError : the data cannot be used as they are: a column holds another unit than its label says, the tendons are
        swapped, an axis is mirrored, the origin is elsewhere, every pose is the same, or there is none.
    """
    found = findings(mechanism, data)
    certain = [str(finding) for finding in found if finding.certain]
    if certain:
        raise InputError(f"{data.source}: {'. '.join(certain)}")
    return Checks(tuple(found), data.source)


def findings(mechanism: Mechanism, data: Measurements) -> list[Finding]:
    """Return what `check` notices, what it would refuse included."""
    if not data.measured.any():
        needed = ", ".join(COLUMNS[name].names[0] for name in _CHANNELS)
        return [Finding("no pose", (), "no row holds a measured pose", f"give {needed}", True)]
    stuck = _same_pose(data)
    if any(finding.certain for finding in stuck):
        return stuck
    labels = label_findings(mechanism, data)
    usual = [*_order(data), *_loads(data), *_rows(data), *_columns(data)]
    spoiled = any(finding.certain or finding.kind == "unexplained" for finding in labels)
    return [*labels, *stuck, *([] if spoiled else _outliers(mechanism, data)), *usual]


def _same_pose(data: Measurements) -> list[Finding]:
    known = np.flatnonzero(data.measured.all(axis=1))
    if known.size < _STUCK:
        return []
    pose, loads = np.nan_to_num(data.pose[known]), load_table(data)[known]
    moved = np.ptp(loads, axis=0).any()
    if moved and not np.ptp(pose, axis=0).any():
        sentence = f"all {known.size} poses are the same though the loads change"
        return [Finding("stuck", (), sentence, "the camera's log stood still: record the poses again", True)]
    same = (np.diff(pose, axis=0) == 0.0).all(axis=1) & (np.abs(np.diff(loads, axis=0)) > 0.0).any(axis=1)
    runs = np.split(np.arange(same.size), np.flatnonzero(~same))
    long = [np.r_[run[run > -1][same[run]], run[same[run]][-1] + 1] for run in runs if same[run].sum() >= _STUCK - 1]
    if not long:
        return []
    rows = tuple(int(data.rows[known[i]]) for run in long for i in run)
    sentence = f"{places(data, rows)}: the pose stays the same to the last digit though the loads change"
    return [Finding("stuck", rows, sentence, "leave these rows out where the camera's log stood still")]


def _outliers(mechanism: Mechanism, data: Measurements) -> list[Finding]:
    """Return rows that lie far from what rows of similar loads say, whatever the model lacks."""
    off = predict(mechanism, data).residual
    whole = np.flatnonzero(np.isfinite(off).all(axis=1))
    if whole.size < _FEWEST_FOR_OUTLIERS:
        return []
    off, loads = off[whole], load_table(data)[whole]
    good: Any = np.ones(whole.size, dtype=bool)
    for _ in range(5):
        expected = smooth(loads[good], off[good], loads)
        left = off - (np.median(off[good], axis=0) if expected is None else expected)
        scale = np.maximum(_MEDIAN_TO_SIGMA * np.median(np.abs(left[good]), axis=0), 1e-9)
        size = np.abs(left) / scale
        good = np.all(size < 0.6 * _OUTLIER, axis=1)
    far = np.flatnonzero((size > _OUTLIER).any(axis=1))
    if not far.size:
        return []
    rows = tuple(int(data.rows[whole[i]]) for i in far)
    worst = far[np.argmax(size[far].max(axis=1))]
    channel = int(np.argmax(size[worst]))
    text = f"{places(data, rows)}: far from rows of similar loads, {data.counted} {data.rows[whole[worst]]} by "
    text += f"{size[worst, channel]:.0f} times the scatter of {_CHANNELS[channel]}"
    return [
        Finding(
            "outliers",
            rows,
            text,
            "look at these rows: misread, or loads unlike all others; the fit leaves out what no effect explains",
        )
    ]


def _loads(data: Measurements) -> list[Finding]:
    loads = load_table(data)
    if data.n > 1 and not np.ptp(loads, axis=0).any():
        return [Finding("equal loads", (), f"all {data.n} rows have the same load", "vary the loads: one pose cannot "
                        "tell stiffnesses from effects")]  # fmt: skip
    largest = float(data.lam.max(initial=0.0))
    if largest == 0.0:
        return []
    tension = data.lam_l + data.lam_r > 0.05 * largest
    difference = (data.lam_l - data.lam_r)[tension]
    idle = [name for name in ("lam_l", "lam_r") if getattr(data, name).max() < _SIDE * largest]
    if idle:
        return [Finding("one tendon", (), f"only one tendon is used: {idle[0]}_N stays below "
                        f"{getattr(data, idle[0]).max():.3g} N", "pull the other one too: what differs left and right "
                        "looks like what is alike on both sides until then")]  # fmt: skip
    leaning = np.abs(difference) > _SIDE * largest
    share = float(np.mean(difference[leaning] > 0.0)) if leaning.any() else 0.5
    if share in (0.0, 1.0):
        side = "lam_l >= lam_r" if share else "lam_r >= lam_l"
        return [Finding("one-sided", (), f"one-sided loads: {side} in every row", "repeat some rows with the tendons "
                        "exchanged: mirror images tell what differs left and right without a model")]  # fmt: skip
    return []


def _rows(data: Measurements) -> list[Finding]:
    count = int(data.measured.any(axis=1).sum())
    if count < FEW_ROWS:
        readings = int(data.measured.sum())
        sentence = f"{count} rows with {readings} readings: three stiffnesses and one effect leave "
        sentence += f"{max(readings - 4, 0)} to check them by"
        return [Finding("few rows", (), sentence, f"{FEW_ROWS} rows or more carry names")]
    if count > _MANY_ROWS:
        return [Finding("many rows", (), f"{count} rows", f"the search goes by {ENOUGH} of them, as many of each "
                        "region of loads as there are; what it finds is fitted to all and judged by all")]  # fmt: skip
    return []


def _order(data: Measurements) -> list[Finding]:
    """Return rows that were measured before the row above them: friction, memory and drift go by the order of rows."""
    known = np.flatnonzero(np.isfinite(data.t))
    back = (np.diff(data.t[known]) < 0.0) & (data.session[known][1:] == data.session[known][:-1])
    late = known[1:][back]
    if not late.size:
        return []
    rows = tuple(int(row) for row in data.rows[late])
    seen = f"{places(data, rows)}: t_s is less than in the row before"
    return [Finding("order", rows, seen, "rows are taken to stand in the order of measurement: sort them by t_s, or "
                    "number the sessions in a column session")]  # fmt: skip


def _columns(data: Measurements) -> list[Finding]:
    """Return what cannot be told because columns are not there."""
    out = []
    for column, values in (("t_s", data.t), ("dwell_s", data.dwell)):
        names = [effect.name for effect in CATALOGUE.values() if column in effect.needs]
        if not np.isfinite(values).any() and names:
            rest = f" and {len(names) - _NAMES_SHOWN} more" if len(names) > _NAMES_SHOWN else ""
            out.append(Finding("missing column", (), f"no column {column}", f"without it these cannot be told: "
                               f"{', '.join(names[:_NAMES_SHOWN])}{rest}"))  # fmt: skip
    absent = [COLUMNS[name].names[0] for name in _CHANNELS if not np.isfinite(getattr(data, name)).any()]
    if absent:
        sentence = f"no column {' and no '.join(absent)}"
        out.append(Finding("missing column", (), sentence, "each channel tells effects apart that the others do not"))
    declared = np.isfinite(np.column_stack([data.sigma_x, data.sigma_z, data.sigma_theta])).any()
    if not declared and not (data.pose_id != "").any():
        sentence = "neither sigma_x_m, sigma_z_m, sigma_theta_rad nor pose_id"
        cure = "repeat some loads and give them one pose_id: without it the noise is what the fit leaves"
        out.append(Finding("missing column", (), sentence, cure))
    if not np.isfinite(data.sigma_lam).any() and data.lam.any():
        out.append(Finding("missing column", (), "no column sigma_lam_N", "the noise of the force cells is taken as "
                           "none unless it is told: too many alarms where it is not"))  # fmt: skip
    return out
