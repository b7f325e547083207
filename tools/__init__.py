"""Tools that make parts of the distribution but do not ship. Run them from the project's folder."""
