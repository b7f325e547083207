"""Experiments with people: participants, order, an append-only store."""
