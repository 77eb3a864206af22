"""The evidence of every effect and every pair on the linear model, from one Gram matrix.

Everything is whitened and in units of each effect's prior: residual = A nuisances + S sizes + noise of unit size,
sizes ~ N(0, 1), nuisances free or with priors of their own, which are rows of A. Evidence knows more of the sizes, see
`size_factor`.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .priors import size_factor

__all__ = ["EvidenceMatrix", "Pairs"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_ABSORBED = 1e-4  # share of a signature below which rounding alone is left of it


@dataclass(frozen=True, eq=False)
class Pairs:
    """Every pair of candidates.

    Attributes
    ----------
    first, second : (n,) their places
    evidence : (n,) twice its logarithm over that of no effect
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    evidence: Array = field(repr=False)


@dataclass(frozen=True, eq=False)
class EvidenceMatrix:
    """Signatures with everything that calibration can do taken off.

    Attributes
    ----------
    gram : (k, k) of the signatures, each one prior standard deviation large
    score : (k,) products with the residual
    left : sum of squares of the residual
    raw : (k,) norms before calibration took its share
    one_sided : (k,) whose size can only be positive
    center : (k,) size at which the linear model was made, in prior standard deviations
    """

    gram: Array
    score: Array
    left: float
    raw: Array
    one_sided: Mask
    center: Array

    @classmethod
    def from_residual(
        cls, residual: Array, nuisances: Array, signatures: Array, one_sided: Mask, center: Array
    ) -> "EvidenceMatrix":
        """Project the nuisances (m, p) out of residual (m,) and signatures (m, k)."""
        size = np.sqrt((nuisances**2).sum(axis=0))
        q, r = np.linalg.qr(nuisances[:, size > 0.0] / size[size > 0.0])
        q = q[:, np.abs(np.diag(r)) > 1e-10]
        kept = signatures - q @ (q.T @ signatures)
        kept -= q @ (q.T @ kept)
        off = residual - q @ (q.T @ residual)
        raw = np.sqrt((signatures**2).sum(axis=0))
        kept[:, np.sqrt((kept**2).sum(axis=0)) <= _ABSORBED * raw] = 0.0
        return cls(kept.T @ kept, kept.T @ off, float(off @ off), raw, one_sided, center)

    @cached_property
    def norm(self) -> Array:
        """Sigmas of one prior standard deviation of every effect, (k,)."""
        return np.sqrt(np.diag(self.gram))

    @cached_property
    def cosine(self) -> Array:
        """Cosines between signatures, (k, k); 0 for one that is nothing."""
        norm = np.where(self.norm > 0.0, self.norm, 1.0)
        return np.asarray(self.gram / np.outer(norm, norm))

    def scores(self) -> Array:
        """Return the score statistic of every candidate, (k,): standard normal where nothing is missing."""
        return np.divide(self.score, self.norm, out=np.zeros_like(self.score), where=self.norm > 0.0)

    def without(self, places: NDArray[np.int64]) -> "EvidenceMatrix":
        """Return the same with the signatures at `places` free nuisances, too."""
        if not len(places):
            return self
        block = self.gram[np.ix_(places, places)]
        cross = np.linalg.pinv(block, rcond=1e-10, hermitian=True) @ self.gram[places]
        gram = self.gram - self.gram[:, places] @ cross
        score = self.score - self.score[places] @ cross
        gram[places], gram[:, places], score[places] = 0.0, 0.0, 0.0
        gone = np.diag(gram) <= _ABSORBED**2 * np.diag(self.gram)
        gram[gone], gram[:, gone], score[gone] = 0.0, 0.0, 0.0
        left = self.left - float(self.score[places] @ np.linalg.pinv(block, hermitian=True) @ self.score[places])
        return EvidenceMatrix(0.5 * (gram + gram.T), score, left, self.raw, self.one_sided, self.center)

    def at_zero(self) -> Array:
        """Return the scores that the residual would have without the effects that the model has, (k,)."""
        return self.score + self.gram @ self.center

    def singles(self) -> tuple[Array, Array]:
        """Return evidence (k,) and sizes (k,), in prior standard deviations, of every effect alone."""
        score, info = self.at_zero(), np.diag(self.gram)
        size = score / (1.0 + info)
        evidence = score * size - np.log1p(info)
        return evidence + size_factor(size, 1.0 / np.sqrt(1.0 + info), self.one_sided), size

    def pairs(self) -> Pairs:
        """Return the evidence of all pairs."""
        first, second = np.triu_indices(len(self.score), 1)
        score, info = self.at_zero(), np.diag(self.gram)
        a, d, b = 1.0 + info[first], 1.0 + info[second], self.gram[first, second]
        determinant = np.maximum(a * d - b * b, 1e-300)
        u, v = score[first], score[second]
        size_u, size_v = (d * u - b * v) / determinant, (a * v - b * u) / determinant
        evidence = u * size_u + v * size_v - np.log(determinant)
        evidence += size_factor(size_u, np.sqrt(d / determinant), self.one_sided[first])
        evidence += size_factor(size_v, np.sqrt(a / determinant), self.one_sided[second])
        return Pairs(first, second, evidence)
