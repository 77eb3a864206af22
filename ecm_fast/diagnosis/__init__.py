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
    "Transfer",
    "Where",
]
