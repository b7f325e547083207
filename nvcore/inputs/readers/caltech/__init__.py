"""Caltech and KAIST text files: truth and results."""
