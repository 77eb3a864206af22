"""Sampling of a sweep's inputs, reproducible chunk by chunk."""

import functools
import threading
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .spec import SweepSpec

__all__ = ["cases"]

Array = NDArray[np.float64]
_BITS = 30  # of a Sobol point: SciPy's own default, enough for 1e9 cases
_LOCK = threading.Lock()


def cases(spec: SweepSpec, number: int, out: Array | None = None) -> list[Array]:
    """Return the values of every varied input in the unit of work `number`, each (rows,).

    out : (varied, chunk)   room that they may lie in, overwritten; none: new memory
    """
    varied, rows = spec.varied, spec.rows(number)
    if spec.sample == "grid":
        return _grid(spec, number * spec.chunk, rows)
    u = np.empty((len(varied), spec.chunk)) if out is None else out
    filled = (_random if spec.sample == "random" else _sobol)(spec, number, u)
    return [entry.quantile(shares[:rows]) for entry, shares in zip(varied, filled, strict=True)]


def _grid(spec: SweepSpec, first: int, rows: int) -> list[Array]:
    index, columns = np.arange(first, first + rows), []
    for entry in reversed(spec.varied):
        values = entry.grid()
        index, place = np.divmod(index, len(values))
        columns.append(values[place])
    return columns[::-1]


def _random(spec: SweepSpec, number: int, u: Array) -> Iterator[Array]:
    """Fill `u` with numbers of [0, 1) from a stream of the chunk's own, which NumPy derives from seed and number.

    A row is taken up before the next one is drawn, while it is in the processor's cache.
    """
    source = np.random.Generator(np.random.SFC64(np.random.SeedSequence(spec.seed, spawn_key=(number,))))
    for column in u:
        yield source.random(out=column)


def _sobol(spec: SweepSpec, number: int, u: Array) -> Iterator[Array]:
    """Fill `u` with a block of the scrambled Sobol sequence.

    The sequence is linear over bits: a block of 2^m points is the first one with some bits flipped, the same ones in
    every point, and those of block 5 are those of blocks 4 and 1 together. So no block needs the ones before it.
    """
    first, turns = _sobol_start(len(spec.varied), spec.seed, spec.chunk, spec.chunks)
    turn = np.zeros(len(first), dtype=np.uint32)
    for bit, direction in enumerate(turns):
        if number >> bit & 1:
            turn ^= direction
    for start, bits, place in zip(first, turn, u, strict=True):
        np.add(start ^ bits, 0.5, out=place)
        place *= 2.0**-_BITS
        yield place


@functools.lru_cache(maxsize=4)
def _sobol_points(dimension: int, seed: int, chunk: int, chunks: int) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    from scipy.stats import qmc

    sampler = qmc.Sobol(dimension, bits=_BITS, seed=np.random.default_rng(seed))
    first = np.ascontiguousarray(sampler.random(chunk).T * 2.0**_BITS).astype(np.uint32)
    turns, place = [], chunk
    while place < chunk * chunks:  # the points number chunk, 2 chunk, 4 chunk, ...
        turns.append((sampler.random(1)[0] * 2.0**_BITS).astype(np.uint32) ^ first[:, 0])
        sampler.fast_forward(place - 1)
        place *= 2
    return first, np.array(turns, dtype=np.uint32).reshape(-1, dimension)


def _sobol_start(dimension: int, seed: int, chunk: int, chunks: int) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    """Return the first block, (dimension, chunk), and by which bits the blocks 1, 2, 4, ... differ from it."""
    with _LOCK:  # threads that all need the same points compute them once
        return _sobol_points(dimension, seed, chunk, chunks)
