"""Checks of measurements before any effect is named: units, axes, symmetry, repeated rows."""
