"""Benchmark of large fleets: generator, cost of each step, projections to 10^11 frames."""
