"""Sealed data sets: a hidden effect, its ground truth, the score of an answer."""
