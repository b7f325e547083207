"""From paths or a session file to a Dataset, and back to files."""
