"""Load paths or a session file into a Dataset, and write it back to files."""
