"""The answer of a diagnosis in words: claims, sentences, caveats."""
