"""Common parts of a diagnosis's figures: the rows as one table, channels with units, maps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...data.measurements import Measurements
from ...diagnosis import Diagnosis
from ...mechanism.mechanism import Mechanism
from ...mechanism.parameters import find

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["MANY", "MOST", "Story", "map_points", "row_columns"]

Array = NDArray[np.float64]

MANY = 400
"""More points than these are drawn as pixels: as lines they would weigh more than the rest of the page."""
MOST = 2000
"""Of more rows, so many are drawn, evenly over the order of measurement."""


@dataclass(frozen=True, eq=False)
class Story:
    """A diagnosis and the mechanism that it began with.

    Attributes
    ----------
    found : the diagnosis
    mechanism : as it was built, as far as is known
    """

    found: Diagnosis
    mechanism: Mechanism

    def joined(self, name: str) -> Any:
        """Return a column of the measurements for all rows."""
        return np.concatenate([getattr(part, name) for part in self.found.rows.data])

    @property
    def lam(self) -> Array:
        """Tendon forces (n, 2) [N]."""
        return np.column_stack([self.joined("lam_l"), self.joined("lam_r")])

    @property
    def pose(self) -> Array:
        """Measured poses (n, 3) [m, m, rad]."""
        return np.asarray(self.joined("pose"))

    @property
    def channels(self) -> list[int]:
        """Places of the measured channels among x, z and theta."""
        return np.flatnonzero(np.isfinite(self.pose).any(axis=0)).tolist()

    @cached_property
    def whole(self) -> NDArray[np.bool_]:
        """Rows to draw: residuals in all channels that were measured, not left out, not too many to see, (n,)."""
        rows = self.found.rows
        known = np.isfinite(rows.before) & np.isfinite(rows.after)
        whole = np.asarray(known[:, self.channels].all(axis=1) & ~rows.outlier)
        places = np.flatnonzero(whole)
        if places.size > MOST:
            whole[:] = False
            whole[places[np.linspace(0, places.size - 1, MOST).round().astype(int)]] = True
        return whole

    @property
    def calibrated(self) -> Mechanism:
        """The mechanism with what calibration found before anything was added."""
        moved = {name: entry.value for name, entry in self.found.before.items()} | dict(self.found.dimensions_before)
        return self.mechanism.replace(**{find(name).key: value for name, value in moved.items()})

    @property
    def data(self) -> tuple[Measurements, ...]:
        """The measurements, one below the other."""
        return self.found.rows.data


def map_points(axes: Axes, u: Array, v: Array, values: Array, limit: float) -> None:
    """Draw colored points, blue for negative, red for positive values."""
    axes.locator_params(nbins=4)
    axes.scatter(u, v, c=values, s=14.0, cmap="RdBu_r", vmin=-limit, vmax=limit, edgecolors="#8a8f98",
                        linewidths=0.25, rasterized=u.size > MANY)  # fmt: skip


def row_columns(story: Story, rows: NDArray[np.bool_]) -> dict[str, Sequence[Any] | NDArray[Any]]:
    """Return what identifies rows in the numbers of a picture."""
    places = np.concatenate([part.rows for part in story.data])
    source = np.repeat([part.source for part in story.data], [part.n for part in story.data])
    return {
        "source": source[rows],
        "row": places[rows],
        "lam_l_N": story.lam[rows, 0],
        "lam_r_N": story.lam[rows, 1],
    }
