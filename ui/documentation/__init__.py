"""Documentation inside the dashboard."""
