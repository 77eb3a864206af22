"""Finding what the model is missing: where it disagrees with measurements, which effect that is, and the proof."""

from .results.diagnosis import (
    Claim,
    Detectability,
    Diagnosis,
    HoldoutMisfit,
    LackOfFit,
    Model,
    Remainder,
    Rms,
    Rows,
    Transfer,
    Where,
)
from .results.plan import Plan
from .study import Study, diagnose, plan

__all__ = [
    "Claim",
    "Detectability",
    "Diagnosis",
    "HoldoutMisfit",
    "LackOfFit",
    "Model",
    "Plan",
    "Remainder",
    "Rms",
    "Rows",
    "Study",
    "Transfer",
    "Where",
    "diagnose",
    "plan",
]
