"""Studies with the models: the paper, element counts, sweeps, timings."""
