"""The driver in the comparison: whom they see unaided, beside X and Y."""
