"""The measuring chain: what the instruments of a test bed read, row by row."""
