"""The record of an element family."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Family"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Family:
    """One kind of element: 3 (order + 1) unknowns, of which three at either end are the pose there.

    Attributes
    ----------
    name : what a user calls it
    meaning : one line
    highest_order : the lowest is 1
    points : by order, how many Gauss points an element takes unless told; fewer than the order leave it loose
    tip_order : by order p, the power of the element length with which the tip's error falls
    inner_places : whether x and z of an inner node are places on the centerline; otherwise they are unknowns of
        another kind in the same units, zero in the straight beam. The third is always the angle there
    tables : by order and Gauss points, what the kernels need; its type is what they know the family by
    centerline : by order, Gauss points, unknowns (n, order + 1, 3) and place in the element (n,), the poses (n, 3)
    """

    name: str
    meaning: str
    highest_order: int
    points: Callable[[int], int]
    tip_order: Callable[[int], int]
    inner_places: bool
    tables: Callable[[int, int], Any]
    centerline: Callable[[int, int, Array, Array], Array]
