"""Figures of the driver in a comparison."""
