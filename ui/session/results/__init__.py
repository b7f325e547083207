"""Cached results for the open inputs: comparison, evidence, audit."""
