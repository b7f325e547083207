"""The benchmarks: curves, miss rate, average precision, operating points, protocols applied."""
