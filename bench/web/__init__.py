"""Benchmark of the dashboard in a browser. See ``__main__.py``."""
