"""Localization of a misfit: its part, channel and loads, and the wrench that would close it."""

import numpy as np
from numpy.typing import NDArray

from ...data.columns import CHANNELS
from ...identification.rows import State
from ...models.instruments.measuring_chain import MeasuringChain
from ...models.loads import MIN_TOLERANCE, QUADRATIC
from ..problem.linearization import Linearization
from ..problem.problem import Problem
from ..results.diagnosis import Where

__all__ = ["compliances", "scan", "where", "wrenches"]

Array = NDArray[np.float64]


def compliances(problem: Problem, state: State) -> Array:
    """Return the pose's derivatives by the wrench at Q, (n, 3, 3), at the state's calibrated parameters."""
    parts = []
    for entry in problem.sets:
        par = problem.par.copy()
        par[problem.rows.places] = state.values[: len(problem.keys)]
        found = MeasuringChain(problem.mesh, entry.data).sensitivities((), par, MIN_TOLERANCE / QUADRATIC)
        parts.append(found.compliance)
    return np.concatenate(parts)


def wrenches(residual: Array, compliance: Array) -> Array:
    """Return the wrench at Q that moves the tip by residuals (n, 3), nan where these are not whole."""
    good = np.isfinite(residual).all(axis=1) & np.isfinite(compliance).all(axis=(1, 2))
    out = np.full_like(residual, np.nan)
    out[good] = np.linalg.solve(compliance[good], residual[good][:, :, None])[:, :, 0]
    return out


def where(view: Linearization, seed: int) -> Where:
    """Return where the calibrated model, without any effect, disagrees; `seed` is of the scan's draws."""
    gram, candidates = view.gram, view.problem.candidates
    taken = gram.scores() ** 2
    most = max(float(taken.max(initial=0.0)), 1e-300)
    parts: dict[str, float] = {}
    mirror: dict[str, float] = {}
    for candidate, value in zip(candidates, taken.tolist(), strict=True):
        for table, name in ((parts, candidate.effect.enters), (mirror, candidate.effect.mirror)):
            table[name] = max(table.get(name, 0.0), value / most)
    excess = np.maximum((view.raw**2).sum(axis=0) - view.used.sum(axis=0), 0.0)
    shares = excess / max(float(excess.sum()), 1e-300)
    lam = np.concatenate([part.lam for part in view.problem.data])[view.rows]
    region, chance = scan(lam, (view.raw**2).sum(axis=1), view.used.sum(axis=1).astype(np.float64), seed)
    return Where(
        components=dict(sorted(parts.items(), key=lambda entry: -entry[1])),
        channels=dict(zip(CHANNELS, shares.tolist(), strict=True)),
        mirror=dict(sorted(mirror.items(), key=lambda entry: -entry[1])),
        region=region,
        chance=chance,
    )


_DRAWS, _BORDERS = 299, 200  # permutations, for chances down to 1/300; borders tried along each load
_FEWEST = 2  # rows
_MOST = 0.5  # of all rows; what holds for more is not local
_LOCAL = 0.8
"""Share of all excess that a region must hold to be called local."""
_RARE = 0.01  # chance that is no longer taken for luck


def scan(lam: Array, squares: Array, count: Array, seed: int) -> tuple[str, float]:
    """Return the half space of tendon forces that stands out most, and how often chance makes one stand out as much.

    The statistic is the likelihood ratio of two noise levels, inside and outside, at its maximum over all borders;
    the chance is that of rows exchanged at random. The text is empty where no local disagreement is seen.

    Parameters
    ----------
    lam : (n, 2) tendon forces [N]
    squares, count : (n,) sum of squared whitened residuals of each row, and of how many readings
    seed : of the draws
    """
    coordinates = {
        "lam_l + lam_r": lam.sum(axis=1),
        "lam_l - lam_r": lam[:, 0] - lam[:, 1],
        "|lam_l - lam_r|": np.abs(lam[:, 0] - lam[:, 1]),
    }
    ways = [(name, sign, sign * values) for name, values in coordinates.items() for sign in (1.0, -1.0)]
    orders = np.array([np.argsort(-values, kind="stable") for _, _, values in ways])
    n = len(squares)
    if n < 2 * _FEWEST:
        return "", 1.0
    sizes = np.unique(np.linspace(_FEWEST, max(int(_MOST * n), _FEWEST), _BORDERS).astype(np.int64))
    borders = np.array([np.diff(-values[order])[sizes - 1] > 1e-3 * np.ptp(values) for order, (_, _, values) in
                        zip(orders, ways, strict=True)])  # fmt: skip
    if not borders.any():
        return "", 1.0
    per = squares / np.maximum(count, 1.0)
    ratio = _ratio(per[orders], sizes, borders)
    rng = np.random.default_rng(seed)
    null = [_ratio(rng.permutation(per)[orders], sizes, borders).max() for _ in range(_DRAWS)]
    chance = float((1 + np.sum(np.array(null) >= ratio.max())) / (1 + _DRAWS))
    way, at = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
    name, sign, values = ways[way]
    inside = orders[way][: sizes[at]]
    excess = squares - count
    local = float(excess[inside].sum()) > _LOCAL * float(excess.sum()) > 0.0
    border = sign * 0.5 * (values[orders[way][sizes[at] - 1]] + values[orders[way][sizes[at]]])
    return (f"{name} {'>' if sign > 0.0 else '<'} {border:.3g} N" if local and chance <= _RARE else ""), chance


def _ratio(ordered: Array, sizes: NDArray[np.int64], borders: NDArray[np.bool_]) -> Array:
    """Return the likelihood ratio of every border, (ways, sizes), from squares (ways, n) in the order of each way."""
    sums, n = np.cumsum(ordered, axis=1), ordered.shape[1]
    inside, total = sums[:, sizes - 1], sums[:, -1:]
    within, beyond = inside / sizes, (total - inside) / (n - sizes)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = n * np.log(total / n) - sizes * np.log(within) - (n - sizes) * np.log(beyond)
    return np.where(borders & (within > beyond), ratio, 0.0)
