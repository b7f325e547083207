"""The parts of the Driver page."""
