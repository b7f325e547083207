"""Compare two pedestrian-detection systems by what the driver notices."""

__version__ = "0.1.0"
"""The version of the program, written into every output."""
