"""The drawn lines of the neck in metres: beam, head plate, tendons and pulleys."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...mechanism.mechanism import Mechanism
from ...models.equilibrium import Equilibrium

__all__ = ["outline", "rounded"]

Point = tuple[float, float]
_PLACES = 41  # points of the drawn centerline


def rounded(values: ArrayLike) -> list[Any]:
    """Return numbers for a picture: a micrometre is more than it shows."""
    found: list[Any] = np.round(np.asarray(values, dtype=np.float64), 6).tolist()
    return found


def outline(neck: Mechanism, eq: Equilibrium) -> dict[str, Any]:
    """Return the lines of an equilibrium; every point is x, z [m].

    Without the effects that move anchors or pulleys by a little: the solution has them, the picture does not.
    """
    sin, cos = math.sin(eq.theta), math.cos(eq.theta)
    tendons, head = neck.tendons, neck.head
    ends = [(eq.x + side * tendons.plate_half_width * sin, eq.z + side * tendons.plate_half_width * cos)
            for side in (1.0, -1.0)]  # fmt: skip
    centers = [(tendons.pulley_x, side * tendons.pulley_z) for side in (1.0, -1.0)]
    touches = [
        _touch(end, center, tendons.pulley_radius, side)
        for end, center, side in zip(ends, centers, (1.0, -1.0), strict=True)
    ]
    return {
        "beam": rounded(eq.shape(_PLACES)),
        "plate": rounded(ends),
        "tendons": [rounded([end, touch]) for end, touch in zip(ends, touches, strict=True)],
        "pulleys": rounded(centers),
        "radius": tendons.pulley_radius,
        "mass": rounded([eq.x + head.h * cos + head.b * sin, eq.z - head.h * sin + head.b * cos]),
    }


def _touch(end: Point, center: Point, radius: float, side: float) -> Point:
    """Return where a tendon meets its pulley: the tangent point on the outer side."""
    dx, dz = end[0] - center[0], end[1] - center[1]
    distance = math.hypot(dx, dz)
    if distance <= radius or radius == 0.0:
        return center
    angle = math.atan2(dz, dx) + side * math.acos(radius / distance)
    return center[0] + radius * math.cos(angle), center[1] + radius * math.sin(angle)
