"""Rival explanations: models that the data cannot separate, each fitted together with the calibration."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...data.measurements import Measurements
from ...errors import InputError, did_you_mean
from ...identification.identify import fit_parameters
from ...identification.rows import FitSet
from ...mechanism.catalogue import CATALOGUE
from ...mechanism.mechanism import Mechanism
from ...mechanism.parameters import index
from ...mechanism.sections import STIFFNESSES
from ...mechanism.vector import pack

__all__ = ["MOST_RIVALS", "STIFFNESSES", "Rival", "fitted_rivals", "in_question"]

MOST_RIVALS = 5
"""Explanations of a look-alike set that loads are sought for: every ordered pair of them is refitted."""
_NEAREST = 3
"""So many others check a name that stands alone."""


@dataclass(frozen=True)
class Rival:
    """One explanation of the data.

    Attributes
    ----------
    names : of its effects
    mechanism : with these effects and all else as fitted
    free : parameters that it may adapt, EA, GA, EI and its sizes
    """

    names: tuple[str, ...]
    mechanism: Mechanism
    free: tuple[str, ...]

    @property
    def name(self) -> str:
        """Its effects in words."""
        return " with ".join(self.names) or "no effect"


def fitted_rivals(
    mechanism: Mechanism,
    data: Sequence[Measurements],
    sets: Sequence[Sequence[str]],
    *,
    priors: Mapping[str, tuple[float, float]] | None = None,
    force_sigma: float | None = None,
) -> list[Rival]:
    """Return explanations of measurements, each fitted together with EA, GA and EI.

    Parameters
    ----------
    mechanism : without them
    data : what was measured on it
    sets : names of effects; an empty one is the mechanism as it is
    priors, force_sigma : as for `identify`

    Raises
    ------
    InputError : no such effect, or the readings are too few.
    """
    rivals = []
    for names in sets:
        for name in names:
            if name not in CATALOGUE:
                raise InputError(f"no such effect: {name!r}{did_you_mean(str(name), CATALOGUE)}")
        sizes = {CATALOGUE[name].size.key: CATALOGUE[name].size for name in names}
        free = (*STIFFNESSES, *sizes)
        start = mechanism.replace(**{
            key: float(np.clip(pack(mechanism)[index(key)] + 0.1 * entry.typical, entry.lower, entry.upper))
            for key, entry in sizes.items()
        })  # fmt: skip
        fit = fit_parameters(
            [FitSet(start, part) for part in data], free, priors=priors, loss="huber", force_sigma=force_sigma
        )
        rivals.append(Rival(tuple(names), fit.mechanism, free))
    return rivals


def in_question(
    models: Sequence[Mapping[str, Any]], transfer: Sequence[Mapping[str, Any]] = ()
) -> tuple[list[tuple[str, ...]], bool]:
    """Return explanations that further loads have to tell apart, and whether that is the first one from the others.

    Where data leave one alone, the nearest ones that can be meant check it. `models` and `transfer` are those of a
    diagnosis's JSON. Explanations by another number of effects than the first one's are out of the question, and so is
    what an experiment that was never fitted refutes.
    """
    out = {entry["name"] for part in transfer for entry in part.get("rivals", ()) if not entry["carries_over"]}
    models = [model for model in models if len(model["names"]) == len(models[0]["names"])
              and " with ".join(model["names"]) not in out]  # fmt: skip
    found = [tuple(model["names"]) for model in models if model["in_set"]]
    if len(found) != 1:
        return found, False
    others = [model for model in models if tuple(model["names"]) != found[0]]
    meant = sorted((model for model in others if not model["refused"]), key=lambda model: float(model["behind"]))
    return [*found, *(tuple(model["names"]) for model in meant[:_NEAREST])], True
