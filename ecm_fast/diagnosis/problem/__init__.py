"""The problem that a diagnosis solves: measurements, candidates, hold-out, linearization."""
