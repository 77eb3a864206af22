"""Faults of measurements of a tendon robot: units and mirrored axes, told whatever the stiffnesses are."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ....data.columns import CHANNELS, channel_key
from ....data.measurements import Measurements
from ....mechanism.body import Tendon
from ....mechanism.mechanism import Mechanism
from ....mechanism.vector import pack
from ..robot_chain import RobotChain
from .finding import Finding

__all__ = ["robot_findings"]

Array = NDArray[np.float64]
_STEP_TOL2 = 1e-14  # squared last Newton step: far below what tells an axis's sign
_MARGIN = 1.5
"""Times the body's length up to which a place or a length can be: silicone stretches, but not so far unseen."""
_TOO_SMALL = 0.02
"""Share of where a point is at rest, from the clamp, within which no row has it where the unit is as labelled."""
_LARGEST_ANGLE = 20.0  # [rad] three turns
_FEWEST, _MIRRORED = 5, -0.9
"""Rows, and the correlation with what is predicted, from which on an axis counts as mirrored."""


def robot_findings(mechanism: Mechanism, data: Measurements) -> list[Finding]:
    """Return what makes the measurements of a robot unusable as they are."""
    chain = RobotChain(mechanism, data)
    readings = dict(zip(chain.channels, data.readings(chain.channels).T, strict=True))
    sizes = [*_sizes(mechanism, data, readings)]
    return sizes or [*_mirrored(mechanism, chain, readings)]


def _sizes(mechanism: Mechanism, data: Measurements, readings: dict[str, Array]) -> Iterator[Finding]:
    rest = {"": mechanism.length} | {
        marker.name: (mechanism.length if marker.on_head else marker.place) + np.hypot(marker.offset_x, marker.offset_z)
        for marker in mechanism.markers
    }
    for name, place in rest.items():
        columns = [f"{name}_{axis}" if name else axis for axis in CHANNELS]
        x, z, theta = (readings.get(column, np.array([])) for column in columns)
        far = np.nanmax(np.abs(np.concatenate([x, z])), initial=0.0)
        whole = np.hypot(x, z) if x.size and z.size else np.array([])
        if far > _MARGIN * place:
            yield _unit(f"{columns[0]}, {columns[1]}", f"up to {far:.4g} m from the clamp", f"{place:.4g} m")
        elif np.isfinite(whole).sum() >= _FEWEST and np.nanmax(whole) < _TOO_SMALL * place:
            yield _unit(f"{columns[0]}, {columns[1]}", f"at most {np.nanmax(whole):.2g} m from the clamp",
                        f"{place:.4g} m")  # fmt: skip
        if np.nanmax(np.abs(theta), initial=0.0) > _LARGEST_ANGLE:
            yield _unit(columns[2], f"up to {np.nanmax(np.abs(theta)):.4g} rad", f"{_LARGEST_ANGLE:g} rad")
    for tendon in mechanism.named_tendons:
        length = np.concatenate([data.lengths([tendon.name])[:, 0], readings.get(f"len_{tendon.name}", np.array([]))])
        longest, straight = np.nanmax(length, initial=0.0), _straight(tendon, mechanism.length)
        if longest > 2.0 * _MARGIN * straight or 0.0 < longest < _TOO_SMALL * straight:
            yield _unit(f"len_{tendon.name}", f"at most {longest:.4g} m", f"{straight:.4g} m")


def _straight(tendon: Tendon, length: float) -> float:
    """Return about how long a tendon is along the straight body."""
    if tendon.route == "chord":
        return float(np.hypot(length + tendon.plate_x - tendon.pulley_x, tendon.plate_z - tendon.pulley_z))
    return tendon.ends_at or length


def _unit(columns: str, seen: str, usual: str) -> Finding:
    sentence = f"{columns}: {seen}, where about {usual} is the size of the robot"
    cure = "the unit is not what the label says, or the origin is not the clamp: correct the column or its name"
    return Finding("unit", (), sentence, cure, True)


def _mirrored(mechanism: Mechanism, chain: RobotChain, readings: dict[str, Array]) -> Iterator[Finding]:
    predicted = dict(zip(chain.channels, chain.solve(pack(mechanism), _STEP_TOL2)[0].T, strict=True))
    turned, seen = [], 0
    for name, measured in readings.items():
        if not name.endswith(("z", "theta")) or name.startswith("len_"):
            continue
        known = np.isfinite(measured) & np.isfinite(predicted[name])
        if known.sum() < _FEWEST or not (np.ptp(measured[known]) and np.ptp(predicted[name][known])):
            continue
        seen += 1
        if float(np.corrcoef(measured[known], predicted[name][known])[0, 1]) < _MIRRORED:
            turned.append(channel_key(name))
    if turned and len(turned) == seen:
        sentence = f"{', '.join(turned)}: the other way round than predicted in every row"
        yield Finding(
            "mirrored", (), sentence, "turn their signs, or give the tendons the offsets of the other side", True
        )
