"""Faults of measurements that have nothing to do with the mechanism, each in one line with its cure."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....data.columns import CAMERA_SIGMA, CHANNELS, COLUMNS
from ....data.measurements import Measurements
from ....data.repeated_rows import repeated_rows
from ....errors import InputError
from ....mechanism.mechanism import Mechanism
from .calibration import MEDIAN_TO_SIGMA, calibrate
from .finding import Finding, places
from .force_cells import force_cell_findings
from .label_sentences import label_findings
from .matched_rows import load_table, smooth
from .resolution import resolution_findings
from .robots import robot_findings

__all__ = ["Checks", "check", "faults"]

Array = NDArray[np.float64]

_OUTLIER = 8.0  # standard deviations; in 1e4 rows of Gaussian noise none is as far
_FEWEST_FOR_OUTLIERS = 40  # rows; with fewer the polynomial that rows are compared with follows them
_STUCK = 4  # rows with the same pose to the last digit


@dataclass(frozen=True)
class Checks:
    """Findings about measurements.

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


def check(mechanism: Mechanism, data: Measurements, unknown: Collection[str] = ()) -> Checks:
    """Check measurements before anything is concluded from them.

    Parameters
    ----------
    mechanism : what is built, as far as is known
    data : poses and loads
    unknown : stiffnesses, EA, GA or EI, of which not even the order of magnitude is known

    Raises
    ------
    InputError : the data cannot be used as they are: a column holds another unit than its label says, columns are
        swapped, an axis is mirrored, the origin is elsewhere, a force cell is dead, stuck, saturated or drops out,
        every pose is the same, or there is none.
    """
    found = faults(mechanism, data, unknown)
    certain = [str(finding) for finding in found if finding.certain]
    if certain:
        raise InputError(f"{data.source}: {'. '.join(certain)}")
    return Checks(tuple(found), data.source)


def faults(mechanism: Mechanism, data: Measurements, unknown: Collection[str] = ()) -> list[Finding]:
    """Return what `check` finds, what it would refuse included."""
    if data.named or not mechanism.has_pair:
        return [*robot_findings(mechanism, data), *_repeated(data)]
    if not data.measured.any():
        needed = ", ".join(COLUMNS[name].names[0] for name in CHANNELS)
        return [Finding("no pose", (), "no row holds a measured pose", f"give {needed}", True)]
    stuck = [*_same_pose(data), *_still_channels(mechanism, data)]
    if any(finding.certain for finding in stuck):
        return stuck
    cells, labels = force_cell_findings(mechanism, data), label_findings(mechanism, data, unknown)
    broken = cells if cells and not any(finding.certain for finding in labels) else labels  # a label explains all rows
    spoiled = any(finding.certain or finding.kind == "unexplained" for finding in broken)
    usual = [*_repeated(data), *resolution_findings(data), *_order(data)]
    return [*broken, *stuck, *([] if spoiled else _outliers(mechanism, data)), *usual]


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


def _still_channels(mechanism: Mechanism, data: Measurements) -> Iterator[Finding]:
    """Yield channels that hold one number in all rows though the model moves them."""
    still = [i for i, known in enumerate(data.measured.T) if known.sum() >= _STUCK and not np.ptp(data.pose[known, i])]
    if not still:
        return
    pose = calibrate(mechanism, data, np.flatnonzero(data.measured.any(axis=1))).pose
    for i in still:
        moved = pose[np.isfinite(pose[:, i]), i]
        if moved.size and np.ptp(moved) > _OUTLIER * CAMERA_SIGMA[i]:
            name = CHANNELS[i]
            column = next((given for given in data.columns if given.startswith(f"{name}_")), COLUMNS[name].names[0])
            sentence = f"{column}: one number in all {int(data.measured[:, i].sum())} rows though the loads change"
            cure = "the channel was not recorded: leave the column out, or record it again"
            yield Finding("stuck", (), sentence, cure, True)


def _repeated(data: Measurements) -> list[Finding]:
    again = repeated_rows([data])[0]
    if not again.any():
        return []
    rows = tuple(int(row) for row in data.rows[again])
    sentence = f"{places(data, rows)}: copies of earlier rows, every load and reading the same to the last digit"
    return [Finding("repeated", rows, sentence, "each row is weighed once: measure a load again instead of copying it")]


def _outliers(mechanism: Mechanism, data: Measurements) -> list[Finding]:
    """Return rows that lie far from what rows of similar loads say, whatever the model lacks."""
    off = calibrate(mechanism, data, np.arange(data.n)).residual
    whole = np.flatnonzero(np.isfinite(off).all(axis=1))
    if whole.size < _FEWEST_FOR_OUTLIERS:
        return []
    off, loads = off[whole], load_table(data)[whole]
    good: Any = np.ones(whole.size, dtype=bool)
    for _ in range(5):
        expected = smooth(loads[good], off[good], loads)
        left = off - (np.median(off[good], axis=0) if expected is None else expected)
        scale = np.maximum(MEDIAN_TO_SIGMA * np.median(np.abs(left[good]), axis=0), 1e-9)
        size = np.abs(left) / scale
        good = np.all(size < 0.6 * _OUTLIER, axis=1)
    far = np.flatnonzero((size > _OUTLIER).any(axis=1))
    if not far.size:
        return []
    rows = tuple(int(data.rows[whole[i]]) for i in far)
    worst = far[np.argmax(size[far].max(axis=1))]
    channel = int(np.argmax(size[worst]))
    text = f"{places(data, rows)}: far from rows of similar loads, {data.counted} {data.rows[whole[worst]]} by "
    text += f"{size[worst, channel]:.0f} times the scatter of {CHANNELS[channel]}"
    return [
        Finding(
            "outliers",
            rows,
            text,
            "look at these rows: misread, or loads unlike all others; the fit leaves out what no effect explains",
        )
    ]


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
