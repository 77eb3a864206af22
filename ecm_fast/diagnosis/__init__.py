"""Diagnosis of a model from measurements: which physical effect is missing, and the evidence for it."""

from .results.diagnosis import (
    Claim,
    Detectability,
    Diagnosis,
    HoldoutMisfit,
    LackOfFit,
    Model,
    Remainder,
    Rms,
    RowFindings,
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
    "RowFindings",
    "Study",
    "Transfer",
    "Where",
    "diagnose",
    "plan",
]
