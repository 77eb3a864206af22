"""Proof of an answer: hold-out error, external validation, model discrepancy, localization."""
