"""How the detectors that ship and those of docs/validation.md are trained and measured."""
