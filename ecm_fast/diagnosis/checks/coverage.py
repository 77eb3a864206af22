"""Limits of what measurements can tell: loads of one side, few rows, columns that are not there."""

import numpy as np

from ...data.columns import CHANNELS, COLUMNS
from ...data.measurements import Measurements
from ...mechanism.catalogue import CATALOGUE
from ...models.instruments.checks.finding import Finding
from ...models.instruments.checks.matched_rows import load_table
from ..search.subsample import ENOUGH

__all__ = ["FEW_ROWS", "coverage"]

FEW_ROWS = 30  # a judgement: of fewer rows the noise of three channels and a name are not both known
_MANY_ROWS = 3000  # a judgement: beyond, a search of all rows takes minutes
_SIDE = 0.02  # share of the largest force: less is a cell's zero, not a pull
_NAMES_SHOWN = 4  # that fit one line


def coverage(data: Measurements) -> list[Finding]:
    """Return what a diagnosis cannot tell from measurements, whatever they hold."""
    return [*_loads(data), *_rows(data), *_columns(data)]


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


def _columns(data: Measurements) -> list[Finding]:
    """Return which questions missing columns leave open."""
    out = []
    for column, values in (("t_s", data.t), ("dwell_s", data.dwell)):
        names = [effect.name for effect in CATALOGUE.values() if column in effect.needs]
        if not np.isfinite(values).any() and names:
            rest = f" and {len(names) - _NAMES_SHOWN} more" if len(names) > _NAMES_SHOWN else ""
            out.append(Finding("missing column", (), f"no column {column}", f"without it these cannot be told: "
                               f"{', '.join(names[:_NAMES_SHOWN])}{rest}"))  # fmt: skip
    absent = [COLUMNS[name].names[0] for name in CHANNELS if not np.isfinite(getattr(data, name)).any()]
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
