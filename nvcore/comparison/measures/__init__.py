"""Measures: definition of an entry, the core's own entries by kind, and the table of all."""
