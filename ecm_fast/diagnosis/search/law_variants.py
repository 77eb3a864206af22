"""Effects whose law is not the catalogue's: by how much it differs, and cameras that were zeroed at rest."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ...mechanism.catalogue import CATALOGUE
from ..problem.law_tolerance import FUNCTIONS, POSITION_ANGLE
from ..problem.linearization import Linearization
from ..statistics.evidence import EvidenceMatrix

__all__ = ["FRAME", "bent", "zeroed", "zeroing"]

Array = NDArray[np.float64]

FRAME = tuple(CATALOGUE[name].size.key for name in ("camera_x_offset", "camera_z_offset", "marker_angle_offset"))
"""Keys of the effects that a camera's origin makes."""


def zeroing(
    view: Linearization, model: tuple[int, ...], values: Mapping[str, float], amplitudes: Array
) -> dict[str, float]:
    """Return the offsets of the camera's frame, by key, that a zeroed camera shows with a model's effects.

    amplitudes : (q,) of `laws_of`
    """
    if view.share is None:
        return {}
    moved, at = np.zeros(3), 0
    for candidate in map(view.candidate, model):
        at += len(FUNCTIONS) if view.share > 0.0 else 0
        if candidate.effect.enters == "camera":
            size = values[candidate.keys[0]] - candidate.start[0]
            moved += size * view.at_rest(candidate.keys[0]) * (POSITION_ANGLE @ amplitudes[at : at + 2])
            at += 2
    now = view.problem.start(FRAME)
    return {key: float(old + more) for key, old, more in zip(FRAME, now, moved, strict=True)
            if more != 0.0 and key not in values}  # fmt: skip


def bent(
    view: Linearization, model: tuple[int, ...], values: Mapping[str, float], amplitudes: Array
) -> tuple[float, str]:
    """Return by how much the law of one effect differs, as a share of the effect, and what that mostly goes with.

    amplitudes : (q,) of `laws_of`
    """
    if not view.share or len(model) != 1:
        return 0.0, ""
    candidate, count = view.candidate(model[0]), len(FUNCTIONS)
    size = values[candidate.keys[0]] - candidate.start[0]
    signature = np.nan_to_num(size * view.by[:, :, view.place[candidate.keys[0]]])
    changed = view.laws_of(model, values)[:, :, :count] @ amplitudes[:count]
    share = float(np.sqrt((changed**2).sum() / max((signature**2).sum(), 1e-300)))
    return share, list(FUNCTIONS.values())[int(np.argmax(np.abs(amplitudes[:count])))]


def zeroed(view: Linearization) -> dict[int, tuple[float, float]]:
    """Return, by the place of each effect of the camera, evidence and size [its unit] if it was zeroed at rest."""
    places = [i for i, candidate in enumerate(view.problem.candidates) if candidate.effect.enters == "camera"]
    if not places:
        return {}
    signatures = view.sizes[:, :, places].copy()
    for n, candidate in enumerate(map(view.candidate, places)):
        signatures[:, :, n] -= candidate.spread[0] * view.whitening @ view.at_rest(candidate.keys[0])
    off = view.residual.copy()
    off[: 3 * len(view.rows)] += view.flat(view.sizes) @ view.center
    columns = np.vstack([view.flat(signatures), np.zeros((len(view.nuisances[1]), len(places)))])
    gram = EvidenceMatrix.from_residual(off, view.free, columns, view.one_sided[places], np.zeros(len(places)))
    evidence, size = gram.singles()
    return {i: (float(e), float(view.candidate(i).start[0] + s * view.candidate(i).spread[0]))
            for i, e, s in zip(places, evidence, size, strict=True)}  # fmt: skip
