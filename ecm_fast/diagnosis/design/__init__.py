"""Design of experiments: which effects loads show, and which loads to measure next."""
