"""Studies with people, between addresses, the file of answers and the browser."""
