"""The next experiment: the loads that separate a set of look-alikes, and by how many sigma.

Two explanations i and j, each fitted to what is there, are apart by what is left of the difference of their poses after
the rival j has adapted everything that it may: d_ij^2 is the smallest weighted sum of squares of j where i is true. A
load that was not measured yet adds to it what j cannot follow without losing the old rows.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ...data.columns import CAMERA_SIGMA
from ...data.measurements import Measurements
from ...errors import InputError, real, shown
from ..results.next_loads import NextLoads, Suggestion
from .discrimination import DiscriminationDesign
from .load_pool import Pool
from .rivals import MOST_RIVALS, Rival, fitted_rivals, in_question

__all__ = ["MOST_RIVALS", "NextLoads", "Pool", "Rival", "Suggestion", "fitted_rivals", "in_question", "next_loads"]


def next_loads(
    rivals: Sequence[Rival],
    data: Sequence[Measurements],
    *,
    sigma: Sequence[float] = CAMERA_SIGMA,
    force_sigma: float = 0.0,
    minutes: float = 20.0,
    repeats: int = 3,
    priors: Mapping[str, tuple[float, float]] | None = None,
    pool: Pool | None = None,
    first_alone: bool = False,
) -> NextLoads:
    """Choose loads that tell explanations apart, the most certainty per minute first.

    Parameters
    ----------
    rivals : at least two explanations, see `fitted_rivals`
    data : what was measured already; its loads hold the rivals together
    sigma : noise of x, z, theta [m, m, rad]
    force_sigma : noise of the force cells [N], carried through the model
    minutes : time on the test bed
    repeats : readings of each load
    priors : value and standard deviation from material tests, by name
    pool : loads to choose from; default tendons with every add-on, and wrenches
    first_alone : tell the first explanation from every other one, not these from each other

    Raises
    ------
    InputError : fewer than two rivals, or a number cannot be meant.
    """
    if len(rivals) < 2:
        raise InputError(f"{len(rivals)} explanation: nothing to tell apart; the answer stands alone")
    if not 0.0 < real("minutes", minutes) < np.inf:
        raise InputError(f"minutes = {shown(minutes)}: allowed is a positive number")
    if repeats < 1:
        raise InputError(f"repeats = {shown(repeats)}: allowed is a whole number >= 1")
    noise = np.array([float(value) for value in sigma])
    if noise.shape != (3,) or not (noise > 0.0).all():
        raise InputError(f"sigma = {shown(list(sigma))}: allowed are three positive numbers [m, m, rad]")
    chosen_from = pool or Pool.from_add_ons()
    race = DiscriminationDesign(rivals, data, chosen_from, (noise, force_sigma), priors or {}, first_alone=first_alone)
    return race.run(minutes, repeats)
