"""Detectors: boxes before and after suppression, and how an ICF model comes to its confidence."""
