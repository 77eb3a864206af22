"""The measuring chain: the readings of the test bed's instruments, row by row."""
