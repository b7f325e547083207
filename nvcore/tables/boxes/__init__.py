"""Outcome of every box of truth, X and Y, for single frames and as a table of all."""
