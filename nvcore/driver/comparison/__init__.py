"""The driver in the comparison: whom he sees by himself, beside X and Y."""
