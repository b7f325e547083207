"""A result as tables, and what each column means."""
