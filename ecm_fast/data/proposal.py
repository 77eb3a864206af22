"""Proposals for the meaning of columns: from the words and units in their names, checked against the numbers.

Certain is what the name says with nothing left over, the unit included, and what the numbers do not contradict. Signs
of places and angles are certain only where the numbers show them: a pull at the left tendon moves the head to +z, and
turns it to -theta. All else is asked for.
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, did_you_mean
from .cells import is_blank, is_number, is_time, number, shown, with_point
from .column_map import NOTE, REST, ColumnMap, told_as
from .columns import COLUMNS, column_of, is_known, is_note
from .grid import RawTable
from .words import understood

__all__ = ["Guess", "propose"]

Floats = NDArray[np.float64]

_CORRELATED = 0.8
"""Least correlation by which numbers show a sign."""
_ROWS = 4  # least number of rows by which they do
_REACH = (5e-3, 5.0)  # [m] along the neck
_SWING = 0.5
"""Change of x over its largest: a head that turns by 90 degrees comes to a third of the neck less."""
_FEW_TURNS = 2.0 * math.pi
_BEND = (0.3, 6.0)
"""Angle of the head over z / x, a beam's tip: 1.5 for a force at the tip, 2 for a couple, with room for others."""
_USUAL = {"lam_l": "N", "lam_r": "N", "fx": "N", "fz": "N", "tau": "Nm", "extra_mass": "kg", "t": "s"}


@dataclass(frozen=True)
class Guess:
    """A column of a file and what it seems to be.

    Attributes
    ----------
    name : in the file, or its place
    told : as a map of columns tells it; empty where nothing can be proposed
    doubt : what has to be asked; empty where the proposal is certain
    because : what it rests on
    """

    name: str
    told: str
    doubt: str
    because: str

    @property
    def certain(self) -> bool:
        """Whether nothing needs to be asked."""
        return not self.doubt


def propose(table: RawTable, told: ColumnMap) -> list[Guess]:
    """Return what the columns of a file are told to be or seem to be, in their order.

    Raises
    ------
    InputError : a column is told of that the file has not.
    """
    names = [name or str(i + 1) for i, (name, _) in enumerate(table.columns)]
    if absent := [name for name in told.columns if name not in (*names, REST)]:
        raise InputError(f"has no column {shown(absent[0])}{did_you_mean(absent[0], names)}; it has "
                         f"{', '.join(map(shown, names))}")  # fmt: skip
    guesses = [
        Guess(name, told.columns[name], "", "it is told so") if name in told.columns else _guess(name, cells)
        for name, (_, cells) in zip(names, table.columns, strict=True)
    ]
    guesses = _paired(_numbered(guesses))
    values = _values(table, guesses)
    guesses = _signed([_sized(guess, values, told.zeroed) for guess in guesses], values)
    return [_told(one, told) for one in guesses]


def _told(guess: Guess, told: ColumnMap) -> Guess:
    """Return what is told of a column, else what is guessed."""
    if guess.name in told.columns:
        return replace(guess, told=told.columns[guess.name], doubt="", because="it is told so")
    if REST in told.columns and guess.doubt:
        return replace(guess, told=NOTE, doubt="", because="all others are told to be")
    return guess


def _guess(name: str, cells: Sequence[object]) -> Guess:
    filled = [cell for cell in cells if not is_blank(cell)]
    numbers = sum(map(is_number, filled))
    if is_note(name):
        return Guess(name, NOTE, "", "its name says so")
    if _is_ours(name):
        return Guess(name, name, "", "it is named so")
    if not filled:
        return Guess(name, NOTE, "", "it is empty")
    said = understood(name)
    because = " and ".join(f"'{word}'" for word in said.because) or "its unit"
    if said.quantity in ("session", "experiment", "pose_id"):
        doubt = f"what {_listed(said.rest)} means" if said.rest else ""
        return Guess(name, said.quantity, doubt, because)
    if numbers < len(filled):
        asked = said.quantity not in ("", "remark")
        cell = next(cell for cell in filled if not is_number(cell))
        return Guess(name, NOTE, f"cells such as {cell!r} hold no number" * asked, "it holds text")
    if said.quantity == "remark":
        return Guess(name, NOTE, "", f"nothing of ours is given in {said.written}" if said.written else because)
    if said.quantity == "t" and any(map(is_time, filled)):
        return Guess(name, "t_s", "", f"{because}, and times in its cells")
    if all(map(is_time, filled)):
        return Guess(name, "t_s", "whether it is the time of the reading", "times in its cells")
    return _of_numbers(name, filled)


def _is_ours(name: str) -> bool:
    """Tell whether a name is one of ours to the letter, and no tendon or marker named by a word for something else."""
    if not is_known(name):
        return False
    column, unit = column_of(name)
    if name != "_".join(filter(None, (column.name, unit))):
        return False
    return column.name in COLUMNS or bool(understood(name).rest)


def _of_numbers(name: str, cells: Sequence[object]) -> Guess:
    said = understood(name)
    column = COLUMNS.get({"y": "z", "fy": "fz", "lam": "lam_l"}.get(said.quantity, said.quantity))
    if column is None:
        what = f"in {said.written}" if said.written else "without a unit"
        values = [value for cell in cells if math.isfinite(value := number(with_point(cell)))]
        seen = f"{min(values):.4g} to {max(values):.4g} {what}" if values else what
        return Guess(name, "", f"what it is, {seen}", "no word of its name is known")
    unit = {"g": "gf", "kg": "kgf"}.get(said.unit, said.unit) if column.name.startswith("lam_") else said.unit
    doubts = list[str]()
    if unit not in column.units:
        unit = _likely(column.name, cells)
        doubts.append(f"its unit ({said.written} is none of {column.name})" if said.written else "its unit")
    elif unit != said.unit:
        doubts.append(f"whether {said.written} is meant as a force")
    if said.quantity == "lam":
        doubts.append("which tendon")
    elif said.quantity in ("y", "fy"):
        doubts.append("which axis")
    elif column.name in ("fx", "fz", "tau", "extra_mass", "tilt"):
        doubts.append("whether it acts at Q, and its sign" if unit not in ("kg", "g") else "whether it is on the head")
    if said.rest:
        doubts.append(f"what {_listed(said.rest)} means")
    because = [" and ".join(f"'{word}'" for word in said.because), f"unit {said.written}" * bool(said.written)]
    return Guess(name, f"{column.name}_{unit}", ", ".join(doubts), ", ".join(filter(None, because)) or "its place")


def _likely(name: str, cells: Sequence[object]) -> str:
    largest = max((abs(float(str(cell).replace(",", "."))) for cell in cells if not is_time(cell)), default=0.0)
    if name in ("x", "z"):
        return "mm" if largest > 2.0 else "m"
    return _USUAL.get(name) or ("deg" if largest > math.pi / 2.0 else "rad")


def _listed(words: Sequence[str]) -> str:
    return " ".join(f"'{word}'" for word in words)


def _numbered(guesses: list[Guess]) -> list[Guess]:
    """Propose two forces of tendons not told which as left and right, in their order."""
    places = [i for i, guess in enumerate(guesses) if guess.doubt and understood(guess.name).quantity == "lam"]
    if len(places) == 1:  # of a testing machine, as likely as of a tendon
        lone = guesses[places[0]]
        doubt = "which load it is: lam_l, lam_r, fx or fz"
        return [replace(lone, told="", doubt=doubt) if one is lone else one for one in guesses]
    if len(places) == 2 and not any(_quantity(guess) == "lam_r" for guess in guesses if guess.told):
        last = guesses[places[1]]
        guesses = [*guesses]
        guesses[places[1]] = replace(last, told=last.told.replace("lam_l", "lam_r"))
    return guesses


def _paired(guesses: list[Guess]) -> list[Guess]:
    """Ask about columns that would be the same, about one letter for a side, and about planes in space."""
    count = Counter(_quantity(guess) for guess in guesses if guess.told and not is_note(guess.told))
    spatial = {understood(guess.name).quantity for guess in guesses} >= {"x", "y", "z"}
    found = list[Guess]()
    for guess in guesses:
        quantity = _quantity(guess) if guess.told else ""
        other = {"lam_l": "lam_r", "lam_r": "lam_l"}.get(quantity, "")
        if quantity and count[quantity] > 1:
            found.append(_doubted(guess, f"which of {count[quantity]} columns is {quantity}"))
        elif other and other not in count and guess.told != guess.name:
            found.append(_doubted(guess, f"why there is no {other}"))
        elif quantity == "tilt" and "theta" not in count:
            found.append(_doubted(guess, "whether gravity was turned, or it is theta of the head"))
        elif spatial and understood(guess.name).quantity in ("x", "y", "z"):
            found.append(_doubted(guess, "which two of the three axes are the plane of the neck"))
        else:
            found.append(guess)
    return found


def _quantity(guess: Guess) -> str:
    name = told_as(guess.told).name
    return "" if is_note(name) else column_of(name)[0].name


def _doubted(guess: Guess, doubt: str) -> Guess:
    return replace(guess, doubt=", ".join(filter(None, (guess.doubt, doubt))))


def _values(table: RawTable, guesses: list[Guess]) -> dict[str, Floats]:
    """Return the numbers of what is proposed by its quantity, in SI; the first column of each."""
    values = dict[str, Floats]()
    for guess, (_, cells) in zip(guesses, table.columns, strict=True):
        if guess.told and not is_note(guess.told) and _quantity(guess) not in values:
            name, scale = told_as(guess.told)
            column, unit = column_of(name)
            if unit:
                free = replace(column, lower=-math.inf)
                values[column.name] = free.numbers(cells, unit, scale)[0]
    return values


def _sized(guess: Guess, values: dict[str, Floats], zeroed: str) -> Guess:
    """Ask about numbers that are of another size, or of another sign, than the quantity has."""
    quantity = _quantity(guess) if guess.told else ""
    own = values.get(quantity)
    if own is None or not np.isfinite(own).any() or guess.told == NOTE:
        return guess
    least, most = float(np.nanmin(own)), float(np.nanmax(own))
    if quantity.startswith("lam_") and most <= 0.0 and least < 0.0:
        return _doubted(replace(guess, told=f"-{guess.told}"), "its sign: all are negative")
    if quantity == "x" and zeroed:
        return guess
    if quantity == "x" and most < 0.0:
        return _doubted(replace(guess, told=f"-{guess.told}"), "its sign: all are negative")
    if quantity == "x" and not _from_clamp(own):
        words = "its unit, or where x begins (zeroed at rest? say --zeroed first, session or unloaded)"
        return _doubted(guess, f"{words}: {1e3 * least:.4g} to {1e3 * most:.4g} mm")
    if quantity == "x" and (least < 0.0 or most - least > _SWING * most):
        return _doubted(guess, "whether x is along the neck: it changes much")
    if quantity == "x" and "z" in values and _larger(values["z"], own):
        return _doubted(guess, "whether x is along the neck: z is larger")
    if quantity == "theta" and max(-least, most) > _FEW_TURNS:
        return _doubted(guess, f"its unit: up to {math.degrees(max(-least, most)):.4g} degrees")
    if quantity == "theta" and {"x", "z"} <= values.keys() and _from_clamp(values["x"]) and not _bends(values):
        return _doubted(guess, "its unit: the angle does not go with z / x")
    return guess


def _from_clamp(x: Floats) -> bool:
    """Tell whether places along the neck can be distances from its clamp."""
    return bool(np.isfinite(x).any()) and _REACH[0] <= float(np.nanmedian(np.abs(x))) <= _REACH[1]


def _larger(one: Floats, other: Floats) -> bool:
    return bool(np.nanmax(np.abs(one), initial=0.0) > np.nanmax(np.abs(other), initial=0.0))


def _bends(values: dict[str, Floats]) -> bool:
    """Tell whether angle and place go with each other as those of a beam's tip, up to their signs."""
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = values["z"] / np.abs(values["x"])
    theta = values["theta"]
    given = np.isfinite(theta) & np.isfinite(slope)
    if given.sum() < 1 or not np.abs(slope[given]).max() > 0.0:
        return True
    ratio = math.sqrt(float(np.sum(theta[given] ** 2) / np.sum(slope[given] ** 2)))
    return _BEND[0] <= ratio <= _BEND[1]


def _signed(guesses: list[Guess], values: dict[str, Floats]) -> list[Guess]:
    """Ask about signs that the numbers contradict or, under names of the file's own, do not show."""
    pull = values["lam_l"] - values["lam_r"] if {"lam_l", "lam_r"} <= values.keys() else None
    shown = {"z": _correlation(values.get("z"), pull)}
    turned = _correlation(values.get("theta"), pull)
    shown["theta"] = -turned
    found = list[Guess]()
    for guess in guesses:
        quantity = _quantity(guess) if guess.told and guess.told != NOTE else ""
        if quantity not in shown:
            found.append(guess)
        elif shown[quantity] <= -_CORRELATED:
            turn = f"-{guess.told}"
            found.append(
                _doubted(replace(guess, told=turn), "its sign, or which tendon is left: they contradict each other")
            )
        elif quantity == "theta" and _same_side(values):
            found.append(_doubted(guess, "its sign, or that of z: a neck that bends to +z turns by -theta"))
        elif shown[quantity] < _CORRELATED and guess.told != guess.name:
            found.append(_doubted(guess, "its sign: the tendon forces do not show it"))
        else:
            showed = "; the tendon forces show its sign" if shown[quantity] >= _CORRELATED else ""
            found.append(replace(guess, because=f"{guess.because}{showed}"))
    return found


def _same_side(values: dict[str, Floats]) -> bool:
    """Tell whether z and theta are mostly of the same sign, where those of a beam's tip are opposite."""
    if not {"z", "theta"} <= values.keys():
        return False
    products = values["z"] * values["theta"]
    known = products[np.isfinite(products)]
    return bool(known.sum() > 0.5 * np.abs(known).sum())


def _correlation(one: Floats | None, other: Floats | None) -> float:
    """Return the correlation of two columns, 0 where it cannot be told."""
    if one is None or other is None:
        return 0.0
    given = np.isfinite(one) & np.isfinite(other)
    if given.sum() < _ROWS or min(np.ptp(one[given]), np.ptp(other[given])) <= 0.0:
        return 0.0
    return float(np.corrcoef(one[given], other[given])[0, 1])
