"""Calls from Python and from the command line, and their arguments."""
