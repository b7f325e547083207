"""Comparison of X and Y with what drivers see unaided."""
