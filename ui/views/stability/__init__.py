"""The parts of the Stability page."""
