"""The parts of the Detection page."""
