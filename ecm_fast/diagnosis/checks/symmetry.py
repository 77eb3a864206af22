"""Model-free tests: mirror symmetry, hysteresis, repeatability.

A neck that is built as drawn looks the same in a mirror that exchanges its tendons: x stays, z and theta change sign.
What breaks this rule has a name in the odd class of the catalogue, whatever the stiffnesses are. In the same way the
order of loads shows path effects, and a repeated load shows drift.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ...data.measurements import Measurements
from ...errors import InputError, shown
from ...models.instruments.checks.matched_rows import (
    MOST_PAIRS,
    approach,
    leaning,
    load_table,
    match,
    mirrored,
    reach_of,
    repeats,
    smooth,
)

__all__ = ["Parity", "ParityTest", "parity"]

Array = NDArray[np.float64]
Places = NDArray[np.int64]

_CHANNELS = ("x", "z", "theta")
_UNITS = ("mm", "mm", "mrad")
_UNDER_MIRROR = np.array([1.0, -1.0, -1.0])
_FEWEST = 6  # with five pairs no pattern of signs is rarer than 1/16
_PAIRS_EACH = 8  # pairs for each column of the fit that is taken off: with fewer it follows them
_ALL_SIGNS = 12  # up to so many pairs all 2^12 patterns of signs are tried, more are drawn
_FLIPS = 1999  # drawn patterns: with the one that was seen 2000, so that p is known to 0.0005
_WORDS = {
    "odd": "left and right differ",
    "even": "what is missing is alike on both sides",
    "path": "the pose depends on the side from which a load is reached",
    "drift": "the same load gives another pose later",
}


@dataclass(frozen=True)
class ParityTest:
    """One of the four questions.

    Attributes
    ----------
    name : odd, even, path or drift
    pairs : how many pairs of rows answer it
    p : probability of a pattern at least as clear among pairs whose signs are random; None where it is not answered
    by_channel : the same for each channel that was measured alone
    deviation : median of what the pairs differ by, x, z, theta [m, m, rad]
    gap : what the data lack, in words, where it is not answered
    """

    name: str
    pairs: int
    p: float | None
    by_channel: Mapping[str, float] = field(default_factory=dict)
    deviation: tuple[float, float, float] | None = None
    gap: str = ""

    def __repr__(self) -> str:
        if self.p is None or self.deviation is None:
            return f"{self.name}: not answered, {self.gap}"
        named = zip(_CHANNELS, self.deviation, _UNITS, strict=True)
        parts = [f"{name} {1e3 * off:+.3g} {unit}" for name, off, unit in named if name in self.by_channel]
        return f"{self.name}: p {self.p:.2g} from {self.pairs} pairs; median {', '.join(parts)}"


@dataclass(frozen=True)
class Parity:
    """Findings from symmetry, order and repetition before anything is fitted.

    Attributes
    ----------
    tests : by name: odd, even, path, drift
    alpha : chance that any of them sees something where there is nothing
    """

    tests: Mapping[str, ParityTest]
    alpha: float

    @property
    def verdict(self) -> tuple[str, ...]:
        """Tests that saw something; the chance of a false one among them is `alpha`, shared by those answered."""
        answered = {name: test.p for name, test in self.tests.items() if test.p is not None}
        return tuple(name for name, p in answered.items() if p <= self.alpha / len(answered))

    @property
    def gaps(self) -> tuple[str, ...]:
        """Data that the unanswered tests lack."""
        return tuple(f"{test.name}: {test.gap}" for test in self.tests.values() if test.p is None)

    @property
    def sentence(self) -> str:
        """The verdict in one sentence."""
        if self.verdict:
            return "; ".join(_WORDS[name] for name in self.verdict)
        quiet = [name for name, test in self.tests.items() if test.p is not None]
        return f"nothing seen by the tests {', '.join(quiet)}" if quiet else "no test could be answered"

    def __repr__(self) -> str:
        return "\n  ".join([f"<Parity: {self.sentence}", *(repr(test) for test in self.tests.values())]) + ">"


def parity(
    data: Measurements,
    residual: Array | None = None,
    *,
    alpha: float = 0.01,
    seed: int | np.random.Generator = 0,
) -> Parity:
    """Ask which symmetry the data break.

    Parameters
    ----------
    data : poses and loads, in the order of measurement
    residual : (n, 3) measured less predicted by a symmetric, calibrated model [m, m, rad]; only the question whether
        what is missing is even needs it
    alpha : chance that any test sees something where there is nothing
    seed : of the random signs

    Raises
    ------
    InputError : `alpha` is no probability, or `residual` is not as long as the data.

    Notes
    -----
    Pairs are matched one to one. Loads that agree only nearly are brought together by a polynomial fitted to the poses
    themselves. The statistic is the part of the differences that follows a constant, the sum and the difference of
    the tendon forces, in the channel where it is clearest; under no effect the sign of each pair is random, which
    gives the p-value without any assumption on the noise but its symmetry.
    """
    if not 0.0 < alpha < 1.0:
        raise InputError(f"alpha = {shown(alpha)}: allowed is a number between 0 and 1")
    if residual is not None and np.shape(residual) != (data.n, 3):
        raise InputError(f"residual has shape {np.shape(residual)}: allowed is ({data.n}, 3)")
    rng = np.random.default_rng(seed)
    measured = data.measured.any(axis=0)
    whole = np.flatnonzero(data.measured[:, measured].all(axis=1) & measured.any())
    data, residual = _without_blanks(data.select(whole)), None if residual is None else np.asarray(residual)[whole]
    residual = None if residual is None else np.where(measured, residual, 0.0)
    tests = (_odd(data, rng), _even(data, residual, rng), _path(data, rng), _drift(data, rng))
    return Parity({test.name: test for test in tests}, alpha)


def _without_blanks(data: Measurements) -> Measurements:
    """Return measurements in which a channel that was not measured is 0: it follows nothing."""
    x, z, theta = np.nan_to_num(data.pose).T.copy()
    return replace(data, x=x, z=z, theta=theta)


def _odd(data: Measurements, rng: np.random.Generator) -> ParityTest:
    pairs = _mirror_pairs(data)
    if len(pairs) < _FEWEST:
        return ParityTest(
            "odd", len(pairs), None, gap=_lacking(len(pairs), "mirrored loads (lam_l and lam_r exchanged)")
        )
    loads = load_table(data)
    i, j = _ordered(pairs, leaning(loads))
    moved = _moved(loads, data.pose, j, mirrored(loads)[i])
    return _tested("odd", data.pose[i] - _UNDER_MIRROR * moved, _shape(loads[i]), rng)


def _even(data: Measurements, residual: Array | None, rng: np.random.Generator) -> ParityTest:
    if residual is None:
        return ParityTest("even", 0, None, gap="what is alike on both sides shows only against a calibrated model")
    known = np.isfinite(residual).all(axis=1)
    data, residual = data.select(known), residual[known]
    pairs = _mirror_pairs(data)
    if len(pairs) < _FEWEST:
        return ParityTest("even", len(pairs), None, gap=_lacking(len(pairs), "mirrored loads"))
    loads = load_table(data)
    i, j = _ordered(pairs, leaning(loads))
    return _tested("even", 0.5 * (residual[i] + _UNDER_MIRROR * residual[j]), _shape(loads[i]), rng)


def _path(data: Measurements, rng: np.random.Generator) -> ParityTest:
    side, loads = approach(data), load_table(data)
    came = np.flatnonzero(side)
    needed = "loads reached from both sides (lam_l - lam_r once rising, once falling)"
    if came.size < 2:
        return ParityTest("path", 0, None, gap=_lacking(0, needed))
    near = reach_of(loads, data.pose)
    pairs = came[match(loads[came], loads[came], side[came], near)]
    if len(pairs) < _FEWEST:
        return ParityTest("path", len(pairs), None, gap=_lacking(len(pairs), needed))
    i, j = _ordered(pairs, side)
    return _tested("path", data.pose[i] - _moved(loads, data.pose, j, loads[i]), _shape(loads[i]), rng)


def _drift(data: Measurements, rng: np.random.Generator) -> ParityTest:
    time = data.t if np.isfinite(data.t).all() else np.arange(data.n, dtype=np.float64)
    loads = load_table(data)
    pairs = []
    for group in repeats(data):
        order = group[np.argsort(time[group], kind="stable")]
        half = order.size // 2
        pairs += list(zip(order[:half], order[order.size - half :], strict=True))
    if len(pairs) < _FEWEST:
        return ParityTest("drift", len(pairs), None, gap=_lacking(len(pairs), "loads repeated at different times"))
    early, late = np.array(pairs, dtype=np.int64).T
    later = time[late] - time[early]
    off = data.pose[late] - _moved(loads, data.pose, early, loads[late])
    return _tested("drift", off, _shape(loads[late]) * (later / max(float(later.max()), 1e-30))[:, None], rng)


def _mirror_pairs(data: Measurements) -> Places:
    loads = load_table(data)
    if data.n < 2:
        return np.empty((0, 2), dtype=np.int64)
    return match(mirrored(loads), loads, np.arange(data.n), reach_of(loads, data.pose))


def _ordered(pairs: Places, sign: Places) -> tuple[Places, Places]:
    """Return the pairs' rows so that the first one is where the sign is positive."""
    first, second = pairs.T
    swap = sign[first] < sign[second]
    return np.where(swap, second, first), np.where(swap, first, second)


def _moved(loads: Array, pose: Array, place: Places, to: Array) -> Array:
    """Return the poses of some rows as they would be at slightly other loads."""
    smoothed = smooth(loads, pose, np.concatenate([loads[place], to]))
    if smoothed is None:
        return pose[place]
    moved: Array = pose[place] + smoothed[len(place) :] - smoothed[: len(place)]
    return moved


def _shape(loads: Array) -> Array:
    """Return what differences may follow, (k, 1 to 4): a constant, the sum of the tendon forces, their difference.

    Few pairs would follow all of them by chance.
    """
    total, difference = loads[:, 0] + loads[:, 1], loads[:, 0] - loads[:, 1]
    columns = [np.ones(len(loads)), total, np.abs(difference), difference]
    return np.column_stack(columns[: max(len(loads) // _PAIRS_EACH, 1)])


def _tested(name: str, off: Array, basis: Array, rng: np.random.Generator) -> ParityTest:
    """Return what random signs say about differences (k, 3) that may follow the columns of a basis (k, b)."""
    every = len(off)
    if every > MOST_PAIRS:
        kept = np.sort(rng.choice(every, MOST_PAIRS, replace=False))
        off, basis = off[kept], basis[kept]
    median = tuple(float(value) for value in np.median(off, axis=0))
    scale = np.sqrt(np.mean(off**2, axis=0))
    scaled = off / np.where(scale > 0.0, scale, 1.0)
    u, s, _ = np.linalg.svd(basis / np.maximum(np.abs(basis).max(axis=0), 1e-30), full_matrices=False)
    u = u[:, s > 1e-6 * s[0]]
    parts = (scaled[:, :, None] * u[:, None, :]).reshape(len(off), -1)
    signs = _signs(len(off), rng)
    found = np.square(parts.sum(axis=0)).reshape(3, -1).sum(axis=1)
    random = np.square(signs @ parts).reshape(len(signs), 3, -1).sum(axis=2)
    as_clear = np.column_stack([random, random.max(axis=1)]) >= np.r_[found, found.max()] * (1.0 - 1e-12)
    exact = len(off) <= _ALL_SIGNS
    share = as_clear.mean(axis=0) if exact else (1.0 + as_clear.sum(axis=0)) / (1.0 + len(signs))
    channels = {name: float(share[i]) for i, name in enumerate(_CHANNELS) if off[:, i].any()}
    return ParityTest(name, every, float(share[3]), channels, (median[0], median[1], median[2]))


def _signs(k: int, rng: np.random.Generator) -> Array:
    """Return all patterns of k signs where they are few, else random ones."""
    every = np.arange(2 ** min(k, _ALL_SIGNS))[:, None] >> np.arange(k)
    bits = every & 1 if k <= _ALL_SIGNS else rng.integers(0, 2, (_FLIPS, k))
    return 1.0 - 2.0 * bits.astype(np.float64)


def _lacking(found: int, what: str) -> str:
    return f"{found or 'no'} pairs of {what}, needed are {_FEWEST}"
