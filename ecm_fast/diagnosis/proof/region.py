"""A scan for loads where a disagreement is local: a stop that is reached, a tendon that goes slack."""

import numpy as np
from numpy.typing import NDArray

__all__ = ["scan"]

Array = NDArray[np.float64]

_DRAWS, _BORDERS = 299, 200
_FEWEST = 2  # rows
_MOST = 0.5  # of all rows; what holds for more is not local
_LOCAL = 0.8
"""Share of all excess that a region must hold to be called local."""
_RARE = 0.01


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
