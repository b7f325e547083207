"""Subjects: further questions about a comparison, each in a package of its own."""
