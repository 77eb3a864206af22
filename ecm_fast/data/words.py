"""Names of columns as people write them: the words in a name, and the quantity that they speak of."""

import re
from typing import NamedTuple

from .units import OTHER, kind_of, unit_of

__all__ = ["Reading", "understood"]

_FORCE = ("f", "force", "kraft", "seilkraft", "zugkraft", "zug", "tension", "tendon", "cable", "wire", "rope", "seil",
          "sehne", "load", "last", "lam", "lambda", "loadcell", "kraftmessdose")  # fmt: skip
_LEFT = ("l", "left", "links", "li", "linkes", "linke")
_RIGHT = ("r", "right", "rechts", "re", "rechtes", "rechte")
_ANGLE = ("theta", "angle", "winkel", "rotation", "rot", "drehung", "phi", "orientation", "bending", "biegewinkel")
_TIME = ("t", "time", "zeit", "timestamp", "zeitstempel", "datum", "date", "uhrzeit", "datetime",
         "temps")  # fmt: skip
_PLACE = ("pos", "position", "place", "coordinate", "koordinate", "koord", "lage", "ort")
_COUPLE = ("tau", "torque", "moment", "drehmoment")
_MASS = ("mass", "masse", "weight", "gewicht", "payload", "zusatzmasse")
_FILLING = ("tip", "head", "kopf", "spitze", "platte", "plate", "q", "measured", "gemessen", "camera", "kamera", "bild",
            "image", "sensor", "cell", "value", "wert", "messwert", "ist", "actual", "the", "of", "in", "am", "an",
            "der", "des", "tracker", "marker", "mocap")  # fmt: skip
_TEXTS = {"session": ("session", "sitzung"), "experiment": ("experiment", "versuch"), "pose_id": ("pose",)}
_COUNTERS = ("index", "nr", "no", "number", "nummer", "id", "row", "zeile", "frame", "sample", "count", "punkt")
_REMARKS = ("remark", "remarks", "comment", "comments", "bemerkung", "bemerkungen", "kommentar", "operator", "bediener")
_UNKNOWN = ("px", "pixel", "pixels", "raw", "counts")  # units of readings that have to be scaled
_LIMIT = 60  # letters of a unit

_UNITS = re.compile(r"(.*?)[\s_/,-]*(?:\bin\b\s*)?[\[(<{]([^\[\]()<>{}]*)[\])>}]\s*|(.*\w)[\s_/](\S+)")
_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z\u00df-\u00ff]+|[0-9]+|[\u0370-\u03ff]")
_GREEK = {"\u03b8": "theta", "\u03d5": "phi", "\u03c6": "phi", "\u03bb": "lambda", "\u03c4": "tau"}


class Reading(NamedTuple):
    """A name as far as its words are understood.

    Attributes
    ----------
    quantity : as in `COLUMNS`; ``lam`` for a force of a tendon not told which; ``y`` for an axis that is none of ours;
        ``remark`` for what is nothing of ours; empty where no word is known
    unit : as in `COLUMNS`, empty where none is given or it is not known
    written : the unit as it is written, empty where none is
    rest : words that are not understood
    because : words that are
    """

    quantity: str
    unit: str
    written: str
    rest: tuple[str, ...]
    because: tuple[str, ...]


def understood(name: str) -> Reading:
    """Return what the words of a column's name say."""
    body, unit, written = _unit(name)
    words = [_GREEK.get(word, word) for word in (found.lower() for found in _WORDS.findall(body))]
    words = [part for word in words for part in _parts(word)]
    quantity, used = _quantity(words, kind_of(unit), written)
    rest = tuple(word for word in words if word not in used and word not in _FILLING)
    return Reading(quantity, unit, written, rest, tuple(word for word in words if word in used))


def _unit(name: str) -> tuple[str, str, str]:
    """Return a name without its unit, the unit, and how it is written."""
    found = _UNITS.fullmatch(name.strip())
    if found is None:
        return name, "", ""
    if found[2] is not None and found[2].strip().isdigit():  # a column of a matrix
        return name, "", ""
    if found[2] is not None:
        return found[1], unit_of(found[2]), found[2].strip()[:_LIMIT]
    known = unit_of(found[4])
    apart = name.strip()[: -len(found[4])].endswith(("_", " in "))  # else one letter may be a word of the name
    if found[4] in _UNKNOWN:
        return found[3], "", found[4]
    if (known and (apart or len(found[4]) > 1)) or (found[4] in OTHER and (apart or len(found[4]) > 1)):
        return found[3].removesuffix(" in"), known, found[4]
    return name, "", ""


def _parts(word: str) -> tuple[str, ...]:
    """Return the words of ``fleft`` and ``seilkraftlinks``."""
    for side in (*_LEFT[1:4], *_RIGHT[1:4]):
        if word.endswith(side) and word[: -len(side)] in _FORCE:
            return word[: -len(side)], side
    if word in ("fl", "fr"):
        return "f", word[1]
    if len(word) == 2 and word[0] in "pr" and word[1] in "xyz":
        return "pos", word[1]
    return (word,)


def _quantity(words: list[str], kind: str, written: str) -> tuple[str, set[str]]:
    """Return the quantity that words speak of, and which of them."""
    sides = [side for side, names in (("l", _LEFT), ("r", _RIGHT)) if any(word in names for word in words)]
    axes = [word for word in words if word in ("x", "y", "z", "fx", "fy", "fz")]
    forces = {word for word in words if word in _FORCE}

    def of(names: tuple[str, ...]) -> set[str]:
        return {word for word in words if word in names}

    if written in OTHER or of(_REMARKS):
        return "remark", set(words)
    if kind in ("force", "mass", "") and forces and len(sides) == 1:
        return f"lam_{sides[0]}", forces | of(_LEFT) | of(_RIGHT)
    if kind in ("force", "") and len(axes) == 1 and (forces or axes[0].startswith("f")):
        return f"f{axes[0][-1]}", forces | {*axes}
    if kind == "couple" or (not kind and of(_COUPLE)):
        return "tau", of(_COUPLE)
    if kind == "mass" and of(_MASS):
        return "extra_mass", of(_MASS)
    if kind == "force" or (not kind and forces):
        return "lam", forces
    if kind == "angle" or (not kind and of(_ANGLE)):
        return "theta", of(_ANGLE)
    if kind in ("length", "") and len(axes) == 1 and not forces:
        return axes[0], {*axes} | of(_PLACE)
    if kind == "time" or (not kind and of(_TIME)):
        return "t", of(_TIME)
    for quantity, names in _TEXTS.items():
        if not kind and len(words) and words[0] in names:
            return quantity, {words[0], *of(_COUNTERS)}
    return ("remark", set(words)) if words and {*words} <= {*_COUNTERS} and not kind else ("", set())
