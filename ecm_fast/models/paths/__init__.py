"""The ways of solving, each a thin layer over its kernels."""
