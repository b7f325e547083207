"""Time left: every urgent encounter up to contact, what the speed changes, X against Y."""
