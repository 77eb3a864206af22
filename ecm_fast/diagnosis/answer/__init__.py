"""The answer in words: claims, sentences, caveats."""
