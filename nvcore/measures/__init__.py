"""Measures: what an entry says, the core's own entries by kind, and the table of all of them."""
