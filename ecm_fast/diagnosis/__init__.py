"""Finding what the model is missing: where it disagrees with measurements, which effect that is, and the proof."""

from .result import Claim, Diagnosis, Gap, Gate, Model, Remainder, Rms, Rows, Sight, Where

__all__ = ["Claim", "Diagnosis", "Gap", "Gate", "Model", "Remainder", "Rms", "Rows", "Sight", "Where"]
