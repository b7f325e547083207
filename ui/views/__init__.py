"""The pages about the comparison itself, a package each."""
