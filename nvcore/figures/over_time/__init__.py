"""Figures with time along them: similarity, losses, lanes of pedestrians, all recordings."""
