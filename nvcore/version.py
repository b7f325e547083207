"""The version of the program, written into every output."""

__version__ = "0.1.0"
