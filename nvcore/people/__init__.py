"""Studies with people: what two subjects share (participants, order, terms, where answers are)."""
