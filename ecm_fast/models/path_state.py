"""The state of a path of loads, and mechanisms whose poses depend on one."""

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, shown
from ..kernels.history import inherit
from ..kernels.layout import N_PAST
from ..mechanism.mechanism import Mechanism
from ..mechanism.parameters import PARAMETERS
from ..mechanism.vector import pack, unpack
from .instruments.history import on_path, path_effects

__all__ = ["PathChoice", "PathState", "check_order", "check_rows"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PathState:
    """State that a path of loads has left behind, for effects such as friction, memory and drift; see `Stepper.state`.

    Attributes
    ----------
    length_l, length_r, theta : of the tendons [m] and the head [rad] at the last step, without effects of the path
    way_l, way_r : direction in which either tendon last travelled: 1 pulled in, -1 let out, 0 not yet
    slider : of the friction in the material, -1 to 1
    remembered, gap : tip angle that the material remembers, and how far the tip is from it [rad]
    hours, held : time since the first step [h], time that the last one was held [s]
    peak : largest sum of both tendon forces so far, as a share of 320 N
    first : time stamp of the first step [s]; nan where it had none, inf before it
    """

    length_l: float
    length_r: float
    theta: float
    way_l: float
    way_r: float
    slider: float
    remembered: float
    gap: float
    hours: float
    held: float
    peak: float
    first: float

    def array(self) -> Array:
        """Return the state as the kernels take it, (N_PAST,), see `kernels.layout`."""
        return np.array(astuple(self))

    def hold(self, mechanism: Mechanism) -> Mechanism:
        """Return the mechanism that stands where the path has led, as one without effects of the path.

        Its stiffness, its shape and its force cells are those of the last step, for whatever load comes next.

        Raises
        ------
        InputError : a value leaves its bounds there.
        """
        par = pack(mechanism)
        inherit(par, self.array())
        for place in on_path().values():
            par[place] = PARAMETERS[place].default
        return unpack(par)


assert len(PathState.__dataclass_fields__) == N_PAST

PathChoice = Literal["ignore"] | PathState | None
"""Treatment of effects of the path by a solve that knows no order of loads: None refuses them."""


def check_order(effects: Sequence[str], path: object, what: str) -> None:
    """Raise where poses depend on the order of loads, which `what` does not know, and `path` is None.

    effects : of the path that there are

    Raises
    ------
    InputError : names the effects and what helps; or `path` cannot be.
    """
    if path is not None and path != "ignore" and not isinstance(path, PathState):
        raise InputError(f'path = {shown(path)}: allowed is "ignore" or the state of a stepper')
    if path is None and effects:
        verb = "depends" if len(effects) == 1 else "depend"
        raise InputError(
            f"{', '.join(effects)} {verb} on the loads before, whose order {what} does not know: use a stepper or "
            'predict, which do, give a stepper\'s state as path, or leave out such effects with path="ignore"'
        )


def check_rows(par: Array, path: PathChoice, what: str) -> None:
    """Raise where mechanisms that have a vector each, (n, n_parameters), need an order of loads."""
    if isinstance(path, PathState):
        raise InputError('path with parameters: allowed is None or "ignore"; one state does not fit many mechanisms')
    check_order(path_effects(par), path, what)
