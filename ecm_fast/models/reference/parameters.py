"""The parameter vector by name."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...mechanism.body import MOST
from ...mechanism.parameters import PARAMETERS

__all__ = ["Parameters", "beam_weight", "gravity", "length", "named"]

Parameters = Mapping[str, Any]


def named(par: Any) -> Parameters:
    """Return a parameter vector as a mapping from key to value."""
    return {entry.key: par[place] for place, entry in enumerate(PARAMETERS)}


def gravity(p: Parameters) -> Any:
    """[G1] Acceleration of gravity, (2,) [m/s^2]: along -e_x, turned by the test bed's tilt.

        g = -g (cos a, sin a)    in (x, z)

    Source: the paper, (21), where a = 0.
    """
    tilt = p["gravity.tilt"] + p["effects.gravity_tilt"]
    return -p["gravity.g"] * np.array([np.cos(tilt), np.sin(tilt)])


def length(p: Parameters) -> Any:
    """Length of the beam, or of a body of segments [m]."""
    segments = sum(p[f"segment{i}.length"] for i in range(1, MOST["segment"] + 1))
    return (segments if segments != 0.0 else p["beam.length"]) + p["effects.beam_length"]


def beam_weight(p: Parameters) -> Any:
    """Weight of the beam per length, (2,) [N/m]."""
    return (p["beam.mass_per_length"] + p["effects.beam_mass"]) * gravity(p)
