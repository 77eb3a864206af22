"""The element study: how few elements of which order keep an accuracy."""
