"""Benchmarks of nvcore against other tools and hand-written baselines: ``make bench``."""
