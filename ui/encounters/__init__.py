"""The parts of the Encounters page."""
