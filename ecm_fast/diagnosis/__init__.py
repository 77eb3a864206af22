"""Finding what the model is missing: where it disagrees with measurements, which effect that is, and the proof."""

from .results.diagnosis import Claim, Diagnosis, Gap, Gate, Model, Remainder, Rms, Rows, Sight, Transfer, Where
from .results.plan import Plan
from .study import Study, diagnose, plan

__all__ = [
    "Claim",
    "Diagnosis",
    "Gap",
    "Gate",
    "Model",
    "Plan",
    "Remainder",
    "Rms",
    "Rows",
    "Sight",
    "Study",
    "Transfer",
    "Where",
    "diagnose",
    "plan",
]
