"""The mechanism: its sections, its parameter vector, its file, its mesh, and the catalogue of effects."""
