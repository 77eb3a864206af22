"""Measurements: loads and poses row by row, in SI units, in the order in which they were taken."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError, did_you_mean
from ..files import csv_text, write_whole
from .cells import bad_cells
from .column_map import NOTE, ColumnMap, Told
from .columns import CHANNELS, COLUMNS, PAIR, column_of, is_note, is_other, match
from .grid import RawTable
from .readers import files_of, is_pattern, read_table, table_of

__all__ = ["Measurements", "read_measurements"]

Floats = NDArray[np.float64]
Labels = NDArray[np.str_]


@dataclass(frozen=True, eq=False, repr=False)
class Measurements:
    """Measured loads and poses, one entry a row; every array is (n,) and read-only.

    Attributes
    ----------
    lam_l, lam_r : [N] tendon force readings, >= 0
    fx, fz, tau : [N, N, N m] external dead wrench at Q, 0 when the file gives none
    x, z, theta : [m, m, rad] measured pose of Q, nan where it was not measured
    t, dwell : [s, s] time stamp and time held before reading, nan where not given
    extra_mass, tilt : [kg, rad] what was changed on the test bed, 0 when the file gives none
    sigma_x, sigma_z, sigma_theta, sigma_lam : [m, m, rad, N] known noise, nan where not given
    experiment, pose_id, session : text, empty where not given
    rows : what a user calls each record: the line in a text file, else the row
    columns : names as found in the file, notes left out
    source : where the measurements come from, for messages
    counted : "line" or "row", what `rows` counts
    named : readings of named tendons and markers by their quantity, ``lam_front``, ``len_front``, ``M1_x``,
        ``sigma_M1_x``, nan where not given [N, m, m or rad]
    ignored : columns of the file that are none of ours
    zeroed, slack : as in `ColumnMap`; `zeroed` is "added" or "added by session" once the rest pose has been added
    """

    lam_l: Floats
    lam_r: Floats
    fx: Floats
    fz: Floats
    tau: Floats
    x: Floats
    z: Floats
    theta: Floats
    t: Floats
    dwell: Floats
    extra_mass: Floats
    tilt: Floats
    sigma_x: Floats
    sigma_z: Floats
    sigma_theta: Floats
    sigma_lam: Floats
    experiment: Labels
    pose_id: Labels
    session: Labels
    rows: NDArray[np.int64]
    columns: tuple[str, ...]
    source: str
    counted: str
    named: Mapping[str, Floats] = field(default_factory=dict)
    ignored: tuple[str, ...] = ()
    zeroed: str = ""
    slack: float = np.nan

    def __post_init__(self) -> None:
        for array in (*(getattr(self, name) for name in _ARRAYS), *self.named.values()):
            array.setflags(write=False)

    @classmethod
    def from_columns(cls, columns: Mapping[str, Any], source: str = "measurements") -> Self:
        """Return measurements from vectors named as the columns of a file, e.g. ``{"lam_l_N": ..., "x_mm": ...}``.

        None, nan and the empty text are blanks.

        Raises
        ------
        InputError : as `read_measurements`, with `source` in the place of the file.
        """
        try:
            return cls(**_checked(table_of(columns)), source=source)
        except InputError as error:
            raise InputError(f"{source}: {error}") from None

    @property
    def n(self) -> int:
        """Number of rows."""
        return len(self.rows)

    def __len__(self) -> int:
        return self.n

    @property
    def lam(self) -> Floats:
        """Tendon forces, (n, 2) [N]."""
        return np.column_stack([self.lam_l, self.lam_r])

    @property
    def wrench(self) -> Floats:
        """External dead wrench at Q, (n, 3) [N, N, N m]."""
        return np.column_stack([self.fx, self.fz, self.tau])

    @property
    def pose(self) -> Floats:
        """Measured pose of Q, (n, 3) [m, m, rad], nan where it was not measured."""
        return np.column_stack([self.x, self.z, self.theta])

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels: x, z, theta of Q; then ``M1_x`` and so on of markers, ``len_front`` and so on of tendons."""
        return (*CHANNELS, *(name for name in self.named if not name.startswith(("lam_", "sigma_"))))

    def readings(self, channels: Sequence[str]) -> Floats:
        """Return measured values of `channels`, (n, c) [m, rad], nan where not measured.

        The length of a tendon whose force is not given counts as given, not as measured: nan.
        """
        return np.column_stack([self._reading(name) for name in channels])

    def sigmas(self, channels: Sequence[str]) -> Floats:
        """Return the declared noise of `channels`, (n, c) [m, rad], nan where none is: of markers else that of Q."""
        return np.column_stack([self._sigma(name) for name in channels])

    def forces(self, names: Sequence[str]) -> Floats:
        """Return force readings of tendons, (n, m) [N]; nan where only the length is given, 0 where neither is."""
        return np.column_stack([self._force(name) for name in names])

    def lengths(self, names: Sequence[str]) -> Floats:
        """Return the lengths of tendons whose forces are not given, (n, m) [m], nan for the others."""
        given = [self.named.get(f"len_{name}", np.full(self.n, np.nan)) for name in names]
        return np.where(np.isnan(self.forces(names)), np.column_stack(given), np.nan)

    @property
    def hanging(self) -> NDArray[np.bool_]:
        """Tendons that hang slack, (n, 2): their reading is 0, and `slack` is told."""
        return np.asarray((self.lam == 0.0) & np.isfinite(self.slack))

    @property
    def measured(self) -> NDArray[np.bool_]:
        """Whether each entry of `pose` was measured, (n, 3)."""
        return np.isfinite(self.pose)

    def where(self, i: int) -> str:
        """Return the place of row `i` as a user finds it: ``run.csv: line 7``."""
        return f"{self.source}: {self.counted} {self.rows[i]}"

    def select(self, which: ArrayLike) -> Self:
        """Return the rows of a mask (n,) or of a list of indices, in that order; each keeps its place in the file.

        Raises
        ------
        InputError : the mask is not as long as the measurements, or an index is beyond them.
        """
        places = np.arange(self.n)
        try:
            chosen = places[np.asarray(which)] if np.size(which) else places[:0]
        except IndexError as error:
            raise InputError(f"{self.source}: cannot select these rows ({error})") from None
        if chosen.ndim != 1:
            raise InputError(f"{self.source}: a selection of shape {np.shape(which)}; allowed is a mask of shape "
                             f"({self.n},) or a list of indices")  # fmt: skip
        others = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        named = {name: values[chosen] for name, values in self.named.items()}
        return type(self)(**{**others, **{name: others[name][chosen] for name in _ARRAYS}, "named": named})

    def blank(self, which: NDArray[np.bool_], channels: Sequence[str]) -> Self:
        """Return the same rows with readings blank; which : (n, c), of `channels`."""
        values = dict(zip(channels, np.where(which, np.nan, self.readings(channels)).T.copy(), strict=True))
        pose = {name: values.pop(name) for name in CHANNELS if name in values}
        # a length that is given drives the row: it is no reading
        given = {name: own for name, own in values.items() if name.startswith("len_")}
        kept = {name: np.where(np.isnan(self._force(name[4:])), self.named[name], own) for name, own in given.items()}
        return replace(self, **pose, named={**self.named, **values, **kept})

    def with_noise(self, noise: Mapping[str, float]) -> Self:
        """Return the same rows with their noise declared where it is not, e.g. ``{"x_mm": 0.1, "lam_N": 0.2}``.

        Raises
        ------
        InputError : no column says the noise of that, or a number is not > 0.
        """
        changed: dict[str, Any] = {}
        for name, value in noise.items():
            try:
                column, unit = column_of(f"sigma_{name}")
            except InputError:
                known = [each.removeprefix("sigma_") for column in COLUMNS.values() for each in column.names
                         if column.name.startswith("sigma_")]  # fmt: skip
                hint = did_you_mean(name, known)
                raise InputError(f"noise of {name}{hint}: allowed are {', '.join(known)}") from None
            (declared,), wrong = column.numbers([value], unit)
            if wrong or not declared > 0.0:
                largest = column.largest * column.units[unit][1] / column.units[unit][0]
                raise InputError(f"noise of {name} = {value!r}: allowed is a number > 0, at most {largest:g} {unit}")
            own = getattr(self, column.name)
            changed[column.name] = np.where(np.isnan(own), declared, own)
        own_columns = (*self.columns, *(f"sigma_{name}" for name in noise if f"sigma_{name}" not in self.columns))
        return replace(self, **changed, columns=own_columns)

    def to_csv(self, path: str | os.PathLike[str], comment: str = "") -> Path:
        """Write the rows in SI to the last digit, so that `read_measurements` gives back every entry.

        Columns that hold nothing are left out. `comment` is text for the top of the file.

        Raises
        ------
        InputError : there is no row to write, or the file cannot be written.
        """
        if not self.n:
            raise InputError(f"{path}: no rows to write; a measurement file has at least one")
        remarks = "".join(f"# {line}".rstrip() + "\n" for line in comment.splitlines())
        return write_whole(path, remarks + csv_text(self._filled()))

    def _filled(self) -> dict[str, NDArray[Any]]:
        """Return the columns that hold anything, and always the tendon forces, by their names in a file."""
        filled = {}
        for name, column in COLUMNS.items():
            values = getattr(self, name)
            absent = column.absent if column.units else ""
            empty = np.isnan(values) if absent != absent else values == absent
            if name in ("lam_l", "lam_r") or not empty.all():
                filled[column.names[0]] = values
        for name, values in self.named.items():
            filled[f"{name}_{'N' if name.startswith('lam_') else 'rad' if name.endswith('_theta') else 'm'}"] = values
        return filled

    def _reading(self, name: str) -> Floats:
        if name in CHANNELS:
            return np.asarray(getattr(self, name))
        own = self.named.get(name, np.full(self.n, np.nan))
        return np.where(np.isnan(self._force(name[4:])), np.nan, own) if name.startswith("len_") else own

    def _sigma(self, name: str) -> Floats:
        if name in CHANNELS:
            return np.asarray(getattr(self, f"sigma_{name}"))
        own = self.named.get(f"sigma_{name}", np.full(self.n, np.nan))
        *_, channel = name.split("_")
        same = channel in CHANNELS and not name.startswith("len_")
        return np.where(np.isnan(own), getattr(self, f"sigma_{channel}"), own) if same else own

    def _force(self, name: str) -> Floats:
        paired = name in PAIR
        own = getattr(self, f"lam_{name}") if paired else self.named.get(f"lam_{name}", np.zeros(self.n))
        told = (
            any(each in self.columns for each in COLUMNS[f"lam_{name}"].names)
            if paired
            else f"lam_{name}" in self.named
        )
        length = self.named.get(f"len_{name}")
        return np.asarray(own if told or length is None else np.where(np.isnan(length), own, np.nan))

    def __repr__(self) -> str:
        poses = int(self.measured.all(axis=1).sum())
        return f"<Measurements {self.source}: {self.n} rows, {poses} with a whole pose; {', '.join(self.columns)}>"


_ARRAYS = (*COLUMNS, "rows")


def read_measurements(
    path: str | os.PathLike[str],
    columns: ColumnMap | Mapping[str, str] | str | os.PathLike[str] | None = None,
) -> Measurements:
    """Read a measurement file: text (.csv, .txt, .tsv, .dat, .asc), Excel (.xlsx), Parquet or MATLAB (.mat).

    Parameters
    ----------
    path : of a file, or a pattern such as ``runs/*.csv``: every file that fits it becomes a session
    columns : what the columns mean where they have other names: a map, e.g. ``{"F_left [N]": "lam_l_N"}``, or the path
        of one as ``ecm-fast import`` writes it

    Raises
    ------
    InputError : the file cannot be read, or a column or cell is not what it can be; one line with file, line or
        row, column, the cell's content and what is allowed.
    """
    told = ColumnMap.of(columns)
    if is_pattern(path):
        return _joined([read_measurements(each, told) for each in files_of(path)], str(path))
    try:
        if told is None:
            return Measurements(**_checked(read_table(path)), source=str(path))
        table = read_table(path, told.layout, bare=True)
        return Measurements(**_checked(table, told), source=str(path))
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _joined(parts: Sequence[Measurements], source: str) -> Measurements:
    """Return the rows of several files, each its own session."""
    names = dict.fromkeys(name for part in parts for name in part.named)
    named = {name: np.concatenate([part.named.get(name, np.full(part.n, np.nan)) for part in parts]) for name in names}
    arrays = {name: np.concatenate([getattr(part, name) for part in parts]) for name in COLUMNS}
    stems = [np.full(part.n, Path(part.source).stem) for part in parts]
    labels = [[f"{stem} {label}".strip() for stem, label in zip(stems[i], part.session, strict=True)]
              for i, part in enumerate(parts)]  # fmt: skip
    arrays["session"] = np.array([label for each in labels for label in each])
    columns = {column_of(name)[0].name: name for part in reversed(parts) for name in part.columns}
    ignored = tuple(dict.fromkeys(name for part in parts for name in part.ignored))
    rows = np.arange(1, sum(part.n for part in parts) + 1)
    zeroed = {"first": "session"}.get(parts[0].zeroed, parts[0].zeroed)  # each file by its own first row
    return Measurements(**arrays, rows=rows, columns=tuple(columns.values()), source=source, counted="row", named=named,
                        ignored=ignored, zeroed=zeroed, slack=parts[0].slack)  # fmt: skip


def _checked(table: RawTable, told: ColumnMap | None = None) -> dict[str, Any]:
    """Return the fields of `Measurements` but its source."""
    names = [name for name, _ in table.columns]
    if told is None:
        ignored = [name for name in names if is_other(name)]
        meant = [Told(NOTE if name in ignored else name) for name in names]
    else:
        meant, ignored = told.read(names)
    kept = [
        (name, cells, own) for (name, cells), own in zip(table.columns, meant, strict=True) if not is_note(own.name)
    ]
    matched = match(own.name for _, _, own in kept)
    n = len(table.rows)
    if n == 0:
        raise InputError("names columns but holds no rows")
    arrays: dict[str, Any] = {
        name: np.full(n, column.absent) if column.units else np.full(n, "") for name, column in COLUMNS.items()
    }
    bad: list[tuple[int, str]] = []
    named: dict[str, Floats] = {}
    for (name, cells, own), (column, unit) in zip(kept, matched, strict=True):
        place: dict[str, Any] = arrays if column.name in COLUMNS else named
        slack = told.slack if told and column.name in ("lam_l", "lam_r") else None
        column = column if slack is None else replace(column, lower=-slack)
        values, wrong = column.numbers(cells, unit, own.scale) if unit else column.labels(cells)
        place[column.name] = values if slack is None else np.where(np.abs(values) <= slack, 0.0, values)
        bad += [(i, f"{table.counted} {table.rows[i]}, column {name}: {text}") for i, text in wrong.items()]
    if bad:
        raise InputError(bad_cells(bad))
    rows = np.array(table.rows, dtype=np.int64)
    columns = tuple(own.name for _, _, own in kept)
    return {**arrays, "rows": rows, "columns": columns, "counted": table.counted, "named": named,
            "ignored": tuple(ignored), "zeroed": told.zeroed if told else "",
            "slack": np.nan if told is None or told.slack is None else told.slack}  # fmt: skip
