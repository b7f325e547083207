"""Benchmark of the dashboard in a browser; see ``__main__.py``."""
