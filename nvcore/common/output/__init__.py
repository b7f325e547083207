"""Output of the program: CSV text, model files, and atomic writes."""
