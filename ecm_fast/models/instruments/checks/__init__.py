"""Checks of measurements: faults of instruments and labels, for every command."""
