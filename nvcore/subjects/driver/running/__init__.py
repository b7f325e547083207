"""Runs over the pictures of recordings, and the files that they write."""
