"""The mechanism: its sections, its parameter vector, its file, and the catalogue of effects."""
