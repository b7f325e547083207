"""Benchmarks of nvcore beside other tools and hand-written baselines: ``make bench``."""
