"""Solution paths: condensed, chain and general, each a thin layer over its kernels."""
