"""The result of a diagnosis: verdict, effects with look-alikes, hold-out error, undetectable effects."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...files import plain
from ...identification.result import Estimate
from ...mechanism.mechanism import Mechanism
from .external_validation import Transfer
from .findings import (
    Claim,
    Detectability,
    HoldoutMisfit,
    LackOfFit,
    Model,
    Noise,
    Remainder,
    Rms,
    RowFindings,
    Verdict,
    Where,
)

__all__ = [
    "Claim",
    "Detectability",
    "Diagnosis",
    "HoldoutMisfit",
    "LackOfFit",
    "Model",
    "Noise",
    "Remainder",
    "Rms",
    "RowFindings",
    "Transfer",
    "Verdict",
    "Where",
]


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis:
    """The answer.

    Attributes
    ----------
    verdict : named, family, outside_catalogue, nothing_found or data_gap
    sentence : the same in plain words
    effects : what was found; of two, first the one without which more is left
    calibration, before : identified parameters with and without what was found
    dimensions, dimensions_before : what the calibrations make of dimensions within their tolerances
    mechanism : with everything that was found
    gap : on the locked rows; None where there were too few rows to lock any
    transfer : the same on experiments that were never fitted
    models : every explanation tried, the best first
    gates : tests for structure
    sights : what the data can show of every entry of the catalogue
    noise : what the verdict assumes
    where : where the calibrated model disagrees; None where it does not
    remainder : of what is outside the catalogue
    outliers : place and reason of rows left out
    missing : columns without which effects cannot be distinguished
    noticed : findings about the measurements, see `Study.check`
    warnings : what to know before the answer is used
    alarms : parameters that calibration drives away from their material tests
    rows : row by row
    seconds : it took
    """

    verdict: Verdict
    sentence: str
    effects: tuple[Claim, ...]
    calibration: Mapping[str, Estimate]
    before: Mapping[str, Estimate]
    dimensions: Mapping[str, float]
    dimensions_before: Mapping[str, float]
    mechanism: Mechanism
    gap: HoldoutMisfit | None
    transfer: tuple[Transfer, ...]
    models: tuple[Model, ...]
    gates: tuple[LackOfFit, ...]
    sights: tuple[Detectability, ...]
    noise: Noise
    where: Where | None
    remainder: Remainder | None
    outliers: tuple[tuple[str, str], ...]
    missing: tuple[str, ...]
    noticed: tuple[str, ...]
    warnings: tuple[str, ...]
    alarms: tuple[str, ...]
    rows: RowFindings
    seconds: float

    @property
    def names(self) -> tuple[str, ...]:
        """Names found, the best one of each set."""
        return tuple(claim.name for claim in self.effects)

    def to_json_dict(self) -> dict[str, Any]:
        """Return the answer as JSON has it; what is not finite is None."""
        answer = {
            "verdict": self.verdict,
            "sentence": self.sentence,
            "effects": [claim.to_json_dict() for claim in self.effects],
            "calibration": _estimates(self.calibration),
            "calibration_before": _estimates(self.before),
            "dimensions": self.dimensions,
            "dimensions_before": self.dimensions_before,
            "gap": self.gap.to_json_dict() if self.gap else {"rows": 0},
            "transfer": [gap.to_json_dict() for gap in self.transfer],
            "models": [vars(model) for model in self.models],
            "gates": [{**vars(gate), "alarm": gate.alarm} for gate in self.gates],
            "sights": [sight.to_json_dict() for sight in self.sights],
            "noise": vars(self.noise),
            "where": vars(self.where) if self.where else None,
            "remainder": _remainder(self.remainder),
            "outliers": [{"row": place, "reason": reason} for place, reason in self.outliers],
            "missing": list(self.missing),
            "noticed": list(self.noticed),
            "warnings": [*self.warnings, *self.alarms],
            "seconds": self.seconds,
        }
        return {name: plain(value) for name, value in answer.items()}

    def __repr__(self) -> str:
        lines = [f"<Diagnosis {self.verdict}: {self.sentence}"]
        for claim in self.effects:
            others = f"; or {', '.join(claim.look_alikes)}" if claim.look_alikes else ""
            sizes = [
                f"{name} = {value:.4g} ({claim.interval[name][0]:.4g} to {claim.interval[name][1]:.4g})"
                for name, value in claim.parameters.items()
            ]
            lines.append(f"  {', '.join(sizes)}, {claim.sigmas:.1f} sigma{others}")
        lines += [f"  {name} {estimate}" for name, estimate in self.calibration.items()]
        if self.gap:
            parts = (f"{name} {rms.sigma:.3g}" for name, rms in self.gap.stages.items())
            lines.append(f"  gap on {self.gap.rows} rows set aside [sigma]: {', '.join(parts)}")
        lines += [f"  warning: {text}" for text in (*self.noticed, *self.warnings, *self.alarms)]
        return "\n".join(lines) + ">"


def _estimates(estimates: Mapping[str, Estimate]) -> dict[str, Any]:
    columns = ("value", "std", "lower", "upper")
    return {name: {key: getattr(estimate, key) for key in columns} for name, estimate in estimates.items()}


def _remainder(remainder: Remainder | None) -> dict[str, Any] | None:
    if remainder is None:
        return None
    return {"closed": remainder.closed, "resembles": remainder.resembles, "cosine": remainder.cosine}
