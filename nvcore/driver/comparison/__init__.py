"""Comparison of X and Y with what the driver sees unaided."""
