"""Settings of a comparison: parameters, kinds of objects, protocols, the primary question."""
