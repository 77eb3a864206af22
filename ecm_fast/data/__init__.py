"""Measurements: columns, units, file formats, bundled data sets."""
