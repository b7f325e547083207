"""The parts of the Systems page."""
