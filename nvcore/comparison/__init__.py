"""The comparison of two systems, and the measures of its result."""
