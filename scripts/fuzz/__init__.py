"""A fuzzer of all that comes from outside: see `python -m scripts.fuzz --help`."""
