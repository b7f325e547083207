"""Parts of the Detection page."""
