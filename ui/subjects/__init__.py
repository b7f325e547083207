"""The pages of the subjects, a package each."""
