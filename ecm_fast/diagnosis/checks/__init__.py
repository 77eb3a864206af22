"""Checks of a diagnosis: mirror symmetry, and what the rows can tell; `models.instruments.checks` has all others."""
