"""Identification of stiffnesses and other parameters from measurements."""
