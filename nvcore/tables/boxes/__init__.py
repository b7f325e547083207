"""What became of every box of truth, X and Y: in one frame, and of all in a table."""
