"""Commands that write what the others start from: a mechanism file, a map of columns."""
