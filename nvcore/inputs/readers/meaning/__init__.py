"""Meaning of names of files, of classes, and of values in files."""
