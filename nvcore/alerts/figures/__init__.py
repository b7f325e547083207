"""Figures of alerts."""
