"""Training and evaluation of the detectors that ship and of those in docs/validation.md."""
