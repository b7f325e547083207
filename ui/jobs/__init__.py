"""Background jobs and their progress bars."""
