"""Fuzzer of all external inputs. See `python -m scripts.fuzz --help`."""
