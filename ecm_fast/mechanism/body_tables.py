"""Tables ``[[segment]]``, ``[[tendon]]`` and ``[[marker]]`` of a mechanism file, read and written."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..errors import InputError, did_you_mean, key_shown, shown
from .body import MOST, N_POINTS, PAIRS, ROUTES, STIFFNESSES, Marker, Segment, Tendon, check_choice, number_fields

__all__ = ["read_tables", "write_tables"]


def read_tables(kind: str, given: object) -> tuple[Any, ...]:
    """Return the parts that the tables ``[[kind]]`` of a mechanism file describe.

    Raises
    ------
    InputError : names the table, the key, the value and what is allowed.
    """
    if not isinstance(given, list) or not all(isinstance(table, dict) for table in given):
        raise InputError(f"{kind} = {shown(given)}: allowed are tables, each written [[{kind}]]")
    if len(given) > MOST[kind]:
        raise InputError(f"{len(given)} tables [[{kind}]]: allowed are {MOST[kind]}")
    parts = []
    for i, table in enumerate(given):
        try:
            parts.append(_READERS[kind](table))
        except InputError as error:
            raise InputError(f"[[{kind}]] {i + 1}: {error}") from None
    return tuple(parts)


def _unknown(table: Mapping[str, Any], allowed: Iterable[str]) -> None:
    names = list(allowed)
    for key in table:
        if key not in names:
            raise InputError(f"unknown key {key_shown(key)}{did_you_mean(key, names)}; allowed are {', '.join(names)}")


def _list(key: str, value: object, n: int) -> list[Any]:
    if not isinstance(value, list) or len(value) != n:
        raise InputError(f"{key} = {shown(value)}: allowed is a list of {n} numbers")
    return value


def _segment(table: Mapping[str, Any]) -> Segment:
    single = [item.name for item in number_fields("segment") if not item.name.endswith(("_start", "_end"))]
    _unknown(table, [*single, *PAIRS])
    values = {key: value for key, value in table.items() if key in single}
    for key in PAIRS:
        if key in table:
            pair = table[key] if isinstance(table[key], list) else [table[key]] * 2
            values[f"{key}_start"], values[f"{key}_end"] = _list(key, pair, 2)
            for value in pair:
                if (
                    not isinstance(value, bool)
                    and isinstance(value, (int, float))
                    and value <= 0
                    and key != STIFFNESSES[3]
                ):
                    raise InputError(f"{key} = {shown(value)}: allowed is a number above 0")
    return Segment(**values)


def _tendon(table: Mapping[str, Any]) -> Tendon:
    keys = {"": (), "chord": ("plate", "pulley", "pulley_radius"), "guided": ("offset", "ends_at")}
    route = table.get("route", "")
    check_choice("route", route, ROUTES)
    if not route:
        raise InputError("route is missing: allowed is 'chord' or 'guided'")
    common = ("compliance", "gain", "zero", *(("shift",) if route == "guided" else ()))
    _unknown(table, ["name", "route", *keys[route], *common])
    values = {key: value for key, value in table.items() if key not in ("plate", "pulley", "offset")}
    if route == "chord":
        for key in ("plate", "pulley"):
            if key not in table:
                raise InputError(f"{key} is missing: a chord runs from plate = [x, z] to pulley = [x, z]")
            values[f"{key}_x"], values[f"{key}_z"] = _list(key, table[key], 2)
    else:
        if "offset" not in table:
            raise InputError("offset is missing: a number, or a list of [place along the body, offset z]")
        offset = table["offset"] if isinstance(table["offset"], list) else [[0.0, table["offset"]]]
        if not 1 <= len(offset) <= N_POINTS:
            raise InputError(f"offset has {len(offset)} points: allowed are 1 to {N_POINTS}")
        values["points"] = float(len(offset))
        for i, point in enumerate(offset, 1):
            values[f"place_{i}"], values[f"offset_{i}"] = _list("offset", point, 2)
    return Tendon(**values)


def _marker(table: Mapping[str, Any]) -> Marker:
    _unknown(table, ["name", "place", "offset", "angle"])
    values = {key: value for key, value in table.items() if key in ("name", "angle", "place")}
    if "place" not in table:
        raise InputError('place is missing: a place along the body [m], or "head"')
    if table["place"] == "head":
        del values["place"]
        values["on_head"] = 1.0
    if "offset" in table:
        values["offset_x"], values["offset_z"] = _list("offset", table["offset"], 2)
    return Marker(**values)


_READERS: dict[str, Any] = {"segment": _segment, "tendon": _tendon, "marker": _marker}


def write_tables(kind: str, parts: Sequence[Any]) -> list[dict[str, Any]]:
    """Return the tables ``[[kind]]`` that describe these parts: what `read_tables` reads."""
    return [_WRITERS[kind](part) for part in parts]


def _segment_table(segment: Segment) -> dict[str, Any]:
    single = [item.name for item in number_fields("segment") if not item.name.endswith(("_start", "_end"))]
    table = {key: getattr(segment, key) for key in single if getattr(segment, key)}
    for key in PAIRS:
        start, end = getattr(segment, f"{key}_start"), getattr(segment, f"{key}_end")
        if start or end:
            table[key] = start if end in (0.0, start) else [start, end]
    return table


def _tendon_table(tendon: Tendon) -> dict[str, Any]:
    table: dict[str, Any] = {"name": tendon.name, "route": tendon.route}
    if tendon.route == "chord":
        table |= {"plate": [tendon.plate_x, tendon.plate_z], "pulley": [tendon.pulley_x, tendon.pulley_z]}
    else:
        table["offset"] = [list(point) for point in tendon.guide]
    optional = ("pulley_radius", "ends_at", "compliance", "gain", "zero", "shift")
    return table | {key: getattr(tendon, key) for key in optional if getattr(tendon, key)}


def _marker_table(marker: Marker) -> dict[str, Any]:
    table: dict[str, Any] = {"name": marker.name, "place": "head" if marker.on_head else marker.place}
    if marker.offset_x or marker.offset_z:
        table["offset"] = [marker.offset_x, marker.offset_z]
    return table | ({"angle": marker.angle} if marker.angle else {})


_WRITERS: dict[str, Any] = {"segment": _segment_table, "tendon": _tendon_table, "marker": _marker_table}
