"""The condensed path: one element, positions eliminated exactly, on which control steps and batches run."""
