"""The parts of the Time left page."""
