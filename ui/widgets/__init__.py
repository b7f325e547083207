"""Small elements that several pages draw."""
