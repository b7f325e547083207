"""The metrics of paper 11-0360: pure functions over columns."""
