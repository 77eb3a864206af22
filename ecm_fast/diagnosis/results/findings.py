"""The parts of a diagnosis: claims, models, tests, detectability, hold-out error, residuals."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...data.columns import CHANNEL_KEYS
from ...data.measurements import Measurements

__all__ = [
    "Claim",
    "Detectability",
    "HoldoutMisfit",
    "LackOfFit",
    "Model",
    "Noise",
    "Remainder",
    "Rms",
    "RowFindings",
    "Verdict",
    "Where",
]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Verdict = Literal["named", "family", "outside_catalogue", "nothing_found", "data_gap"]


@dataclass(frozen=True)
class Claim:
    """One effect that the data ask for. A name is never given without its look-alikes.

    Attributes
    ----------
    name : as in the catalogue
    parameters : values by the effect's parameters, those that a mechanism file takes
    interval : lower and upper end by the same names
    look_alikes : names that the data cannot tell from this one
    mirror : even, odd, mixed or path
    group : of effects that look alike
    sigmas : how far it stands out: the root of what the weighted sum of squares gains where it alone is left out and
        all else is fitted again
    probability : of this name among its look-alikes, if the truth is one of them
    times : its size over the typical one
    law : how its law differs from the catalogue's, empty where it does not
    """

    name: str
    parameters: Mapping[str, float]
    interval: Mapping[str, tuple[float, float]]
    look_alikes: tuple[str, ...]
    mirror: str
    group: str
    sigmas: float
    probability: float
    times: float = 1.0
    law: str = ""

    def to_json_dict(self) -> dict[str, Any]:
        """Return the entry of ``effects`` in a diagnosis's JSON."""
        return {
            "name": self.name,
            "parameters": dict(self.parameters),
            "interval": {name: list(ends) for name, ends in self.interval.items()},
            "look_alikes": list(self.look_alikes),
            "class": self.mirror,
            "group": self.group,
            "sigmas": self.sigmas,
            "probability": self.probability,
            "times_typical": self.times,
            "law": self.law,
        }


@dataclass(frozen=True)
class Model:
    """One explanation that was tried.

    Attributes
    ----------
    names : of its effects, one or two
    sizes : of these effects
    evidence : twice the logarithm of its evidence over that of no effect
    chi2 : what it takes off the weighted sum of squares
    behind : evidence it lacks to the best model of as many effects
    in_set : whether the data cannot tell it from the best one
    refused : why it cannot be meant, empty if it can
    """

    names: tuple[str, ...]
    sizes: tuple[float, ...]
    evidence: float
    chi2: float
    behind: float
    in_set: bool
    refused: str = ""


@dataclass(frozen=True)
class LackOfFit:
    """One test for structure: what was compared, and how often clean data exceed it.

    Attributes
    ----------
    name : ``effects`` (largest projected score over all candidates) or ``smooth`` (low polynomials of loads and time)
    stage : number of effects that the model under test has
    statistic, p : value, and its chance where nothing is missing
    alpha : chance that was allowed
    """

    name: str
    stage: int
    statistic: float
    p: float
    alpha: float

    @property
    def alarm(self) -> bool:
        """Whether something is missing."""
        return self.p < self.alpha


@dataclass(frozen=True)
class Detectability:
    """Detectability of one entry of the catalogue under the given loads.

    Attributes
    ----------
    name, unit, typical : of the effect's size
    sigmas : of a typical size, what calibration leaves of it
    smallest : size that is found nine times in ten; inf where none is
    kept : share of the signature that calibration leaves
    rivals : nearest others: name, cosine, sigmas that a typical size is away from them
    visible : ``named``, ``seen`` (beside rivals as good), ``absorbed`` by the calibration or ``invisible``
    needs : columns that are missing for it to show
    shown_by, shown_sigmas : where it does not show: what would, one reading of each load of a kind or tests of the
        material, and the sigmas that a typical size would then have; empty and 0 where nothing on this test bed does
    """

    name: str
    unit: str
    typical: float
    sigmas: float
    smallest: float
    kept: float
    rivals: tuple[tuple[str, float, float], ...]
    visible: str
    needs: tuple[str, ...] = ()
    shown_by: str = ""
    shown_sigmas: float = 0.0

    @property
    def cure(self) -> str:
        """Data that would show it, in words; empty where it does show."""
        if self.visible in ("named", "seen"):
            return ""
        columns = f"columns {', '.join(self.needs)}" if self.needs else ""
        loads = f"{self.shown_by} ({self.shown_sigmas:.1f} sigma)" if self.shown_by else ""
        return " and ".join(filter(None, (columns, loads))) or "nothing that the test bed can do"

    def to_json_dict(self) -> dict[str, Any]:
        """Return the entry of ``sights`` in the JSON of a diagnosis or plan."""
        return {
            **{name: getattr(self, name) for name in ("name", "unit", "typical", "sigmas", "smallest", "kept")},
            "visible": self.visible,
            "needs": list(self.needs),
            "shown_by": self.shown_by,
            "shown_sigmas": self.shown_sigmas,
            "rivals": [{"name": n, "cosine": c, "sigmas": d} for n, c, d in self.rivals],
        }


@dataclass(frozen=True)
class Rms:
    """Root mean squares by channel [m, m, rad] and of all readings in units of their noise; nan where unknown."""

    x: float
    z: float
    theta: float
    sigma: float
    interval: tuple[float, float] = (math.nan, math.nan)
    """Of `sigma`, from resampled blocks of rows."""

    def to_json_dict(self) -> dict[str, Any]:
        """Return the entry of ``gap`` in a diagnosis's JSON."""
        return {
            **dict(zip(CHANNEL_KEYS, (self.x, self.z, self.theta), strict=True)),
            "rms_sigma": self.sigma,
            "interval": list(self.interval),
        }


@dataclass(frozen=True)
class HoldoutMisfit:
    """Misfit between model and measurements in rows that no step of the diagnosis has seen.

    Attributes
    ----------
    rows : how many
    what : which rows these are
    given : of the mechanism as it was given
    before, after : of the calibrated model without and with what was found
    floor : what noise alone leaves
    closed : share of the mean square above the floor that is gone since `before`; nan where there was none
    without : of two effects found, by name, what is left where the other one alone is in the calibrated model
    """

    rows: int
    what: str
    given: Rms
    before: Rms
    after: Rms
    floor: Rms
    closed: float
    without: Mapping[str, Rms] = field(default_factory=dict, kw_only=True)

    def to_json_dict(self) -> dict[str, Any]:
        """Return ``gap`` of a diagnosis's JSON."""
        parts = {name: getattr(self, name).to_json_dict() for name in ("given", "before", "after", "floor")}
        without = {name: rms.to_json_dict() for name, rms in self.without.items()}
        return {"rows": self.rows, "what": self.what, **parts, "closed": self.closed, "without": without}

    @property
    def stages(self) -> dict[str, Rms]:
        """All root mean squares by a few words for a reader, in the order in which they shrink."""
        without = {f"fitted without {name}": rms for name, rms in self.without.items()}
        return {"as given": self.given, "calibrated alone": self.before, **without, "with what was found": self.after,
                "floor": self.floor}  # fmt: skip


@dataclass(frozen=True, eq=False)
class RowFindings:
    """Row by row, the experiments one below the other, for tables and pictures.

    Attributes
    ----------
    data : the measurements
    locked : (n,) rows that were set aside
    outlier : (n,) rows that were left out as outliers
    used : (n, 3) readings that the fit counted
    before, after : (n, 3) measured less predicted without and with what was found [m, m, rad]
    sigma : (n, 3) noise of each reading, force noise included [m, m, rad]
    wrench_before, wrench_after : (n, 3) the wrench at Q that would close the gap [N, N, N m]
    """

    data: tuple[Measurements, ...]
    locked: Mask
    outlier: Mask
    used: Mask
    before: Array
    after: Array
    sigma: Array
    wrench_before: Array
    wrench_after: Array


@dataclass(frozen=True)
class Noise:
    """Noise that the verdict assumes.

    Attributes
    ----------
    sigma : of x, z, theta [m, m, rad], median over the rows, nan where nothing was measured
    force : of the force cells [N]
    origin : by channel declared, replicates or residual
    scale : by channel, noise seen over `sigma`
    tail : how heavy the tails are: 0 Gaussian, larger is heavier
    correlation : of neighboring rows
    """

    sigma: tuple[float, float, float]
    force: float
    origin: Mapping[str, str]
    scale: tuple[float, float, float]
    tail: float
    correlation: float


@dataclass(frozen=True)
class Where:
    """Loads and channels at which the calibrated model disagrees.

    Attributes
    ----------
    components : share of the excess that effects of one part of the mechanism can explain alone, by part
    channels : share of the excess in x, z, theta
    mirror : share that is even and odd under exchange of left and right, by class
    region : text of the loads where the disagreement is local, empty where it is everywhere
    chance : how often rows exchanged at random would make some region stand out as much
    """

    components: Mapping[str, float]
    channels: Mapping[str, float]
    mirror: Mapping[str, float]
    region: str
    chance: float


@dataclass(frozen=True, eq=False)
class Remainder:
    """Misfit that no admissible model explains, as a smooth wrench at Q that no parameter could make.

    Attributes
    ----------
    wrench : (n, 3) [N, N, N m] row by row
    closed : share of the locked rows' excess that it explains
    resembles : nearest group; it resembles, it does not explain
    cosine : to that group's nearest member
    """

    wrench: Array = field(repr=False)
    closed: float
    resembles: str
    cosine: float
