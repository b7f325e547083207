"""Every box of truth, X and Y as a row: what became of it, and whom it matches."""
