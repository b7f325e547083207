"""Data page: what the audit found, and all that each finding concerns."""
