"""The search for effects: calibration, fits, model selection."""
