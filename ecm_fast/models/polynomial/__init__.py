"""The polynomial model of the paper and its training."""
