"""What is computed of the open inputs, and cached: the comparison, its evidence, the audit."""
