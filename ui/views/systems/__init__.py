"""Parts of the Systems page."""
